// Bands of 90 % hold nine of ten measurements where the posterior is right, and fewer where it is not.
#include <gtest/gtest.h>

#include <cmath>
#include <memory>

#include "costs/prediction/recording_model.h"
#include "identify/prediction/judge_bands.h"
#include "identify/prediction/random_force.h"
#include "sim/rollout/simulator.h"
#include "tests/costs/synthetic_clouds.h"
#include "tests/costs/synthetic_motion.h"

namespace clothid::held_bands_test {
namespace {

// Stretch 50 N/m, known to `spread` of it.
FitPosterior OfStretch(double spread) {
  FitPosterior posterior;
  posterior.parameters = {{"k_stretch", ParameterScale::kLog, 50.0, 5e-5, 5e7}};
  posterior.covariance = Eigen::MatrixXd::Constant(1, 1, spread * spread);
  return posterior;
}

RecordedMotion Swing(double stretch, double noise) {
  MotionOptions truth;
  truth.true_values = {{"k_stretch", stretch}};
  truth.noise = truth.sigma = noise;
  return MakeMotion(SwingScene(), truth);
}

std::vector<ParameterBlock> Blocks(const RecordedMotion& motion) {
  return {MakeParameterBlock("k_stretch", motion, {})};
}

// The positions that the scene of a recording predicts.
Eigen::MatrixXd PredictedByScene(const RecordedMotion& motion) {
  RecordingModel model(motion, {});
  Eigen::MatrixXd predicted;
  model.Simulate(Eigen::VectorXd(), {}, {}, &predicted);
  return predicted;
}

// Without the error of step and mesh, which the truth does not have.
HeldBands Judge(const RecordedMotion& motion, const FitPosterior& posterior, HeldBandOptions options = {}) {
  options.with_step = options.with_mesh = false;
  return JudgeByBands({motion}, Blocks(motion), Eigen::VectorXd::Constant(1, 50.0), posterior, HeldOut::kRecordings, {},
                      options);
}

TEST(HeldBandsTest, NoiseAloneIsHeldAsOftenAsPromised) {
  HeldBandOptions options;
  options.num_draws = 60;
  const HeldBands bands = Judge(Swing(50.0, 1e-3), OfStretch(1e-6), options);
  EXPECT_EQ(bands.why_not, "");
  EXPECT_NEAR(bands.all.inside, 0.9, 0.03);
  EXPECT_NEAR(bands.all.half_width, 1.645e-3, 1e-4);
  EXPECT_NEAR(bands.all.rmse, 1e-3, 1e-4);
  EXPECT_NEAR(bands.all.score, 1e-3 / std::sqrt(std::acos(-1.0)), 5e-5) << "that of a normal distribution, in the mean";
  EXPECT_FALSE(bands.has_force);
}

TEST(HeldBandsTest, WhatIsTooSureHoldsLittle) {
  const RecordedMotion motion = Swing(25.0, 1e-4);
  const HeldBands sure = Judge(motion, OfStretch(0.01)), honest = Judge(motion, OfStretch(0.7));
  EXPECT_LT(sure.all.inside, 0.6);
  EXPECT_GT(honest.all.inside, 0.85);
  EXPECT_LT(honest.all.score, sure.all.score);
  FitPosterior with_force = OfStretch(0.01);
  with_force.forces = {{2.0, 0.1, 0.1}};
  const HeldBands forced = Judge(motion, with_force);
  EXPECT_TRUE(forced.has_force);
  EXPECT_GT(forced.all.half_width, 2.0 * sure.all.half_width);
}

TEST(HeldBandsTest, CellsAreOfLeadTimesAndAddUp) {
  const HeldBands bands = Judge(Swing(50.0, 1e-3), OfStretch(0.1));
  ASSERT_EQ(bands.leads.size(), 2u) << "of .2 s";
  EXPECT_EQ(bands.leads[0].until, 0.1);
  EXPECT_EQ(bands.leads[1].until, 0.3);
  EXPECT_EQ(bands.leads[0].num + bands.leads[1].num, bands.all.num);
  const double inside = bands.leads[0].num * bands.leads[0].inside + bands.leads[1].num * bands.leads[1].inside;
  EXPECT_NEAR(inside, bands.all.num * bands.all.inside, 1e-6);
  EXPECT_LT(bands.leads[0].half_width, bands.leads[1].half_width);
  const std::string text = HeldBandsText(bands, false);
  EXPECT_NE(text.find("bands of 90 % held "), std::string::npos) << text;
  EXPECT_NE(text.find(" to 0.1 s"), std::string::npos) << text;
}

TEST(HeldBandsTest, EachRecordingIsToldWithUntilWhenItsPredictionIsWorthSomething) {
  const RecordedMotion motion = Swing(50.0, 1e-3);
  HeldBands bands = Judge(motion, OfStretch(0.1));
  ASSERT_EQ(bands.recordings.size(), 1u);
  EXPECT_EQ(bands.recordings[0].name, motion.name);
  EXPECT_EQ(bands.recordings[0].all.inside, bands.all.inside);
  EXPECT_EQ(bands.recordings[0].all.score, bands.all.score);
  EXPECT_TRUE(std::isinf(bands.recordings[0].worth_until)) << "to the end";
  RecordedMotion still = motion;
  still.positions = still.positions.col(0).replicate(1, still.num_frames()).eval();
  bands = Judge(still, OfStretch(0.1));
  EXPECT_EQ(bands.recordings[0].worth_until, 0.0);
  RecordedMotion stops = motion;  // where the motion has come to the half
  const Eigen::Index half = stops.num_frames() / 2;
  stops.positions.rightCols(stops.num_frames() - half) =
      stops.positions.col(0).replicate(1, stops.num_frames() - half).eval();
  const double until = Judge(stops, OfStretch(0.1)).recordings[0].worth_until;
  EXPECT_GE(until, 0.4 * stops.times[stops.num_frames() - 1]);
  EXPECT_LT(until, 0.8 * stops.times[stops.num_frames() - 1]);
}

TEST(HeldBandsTest, ThreadsChangeNothing) {
  FitPosterior posterior = OfStretch(0.1);
  posterior.forces = {{0.5, 0.05, 0.1}};
  const RecordedMotion motion = Swing(50.0, 1e-3);
  HeldBandOptions options;
  const HeldBands one = Judge(motion, posterior, options);
  options.num_threads = 3;
  const HeldBands three = Judge(motion, posterior, options);
  EXPECT_EQ(one.all.inside, three.all.inside);
  EXPECT_EQ(one.all.score, three.all.score);
  EXPECT_EQ(one.all.half_width, three.all.half_width);
}

// Twice the stretch that each recording found for itself is between that of one and that of the other.
TEST(HeldBandsTest, AnotherRecordingIsLikeOneOfThoseThatWereFitted) {
  const RecordedMotion motion = Swing(50.0, 1e-4);
  std::vector<ParameterBlock> blocks = {Blocks(motion)[0], Blocks(motion)[0]};
  FitPosterior posterior;
  for (std::size_t r = 0; r < 2; ++r) {
    blocks[r].recording = static_cast<int>(r);
    blocks[r].name = "k_stretch@" + std::to_string(r + 1);
    posterior.parameters.push_back({blocks[r].name, ParameterScale::kLog, r == 0 ? 35.0 : 70.0, 5e-5, 5e7});
  }
  posterior.covariance = 1e-6 * Eigen::Matrix2d::Identity();
  HeldBandOptions options;
  options.with_step = options.with_mesh = false;
  const HeldBands bands =
      JudgeByBands({motion}, blocks, Eigen::Vector2d(35.0, 70.0), posterior, HeldOut::kRecordings, {}, options);
  const HeldBands sure = Judge(motion, OfStretch(1e-3));
  EXPECT_GT(bands.all.half_width, 2.0 * sure.all.half_width);
  EXPECT_GT(bands.all.inside, 0.85);
}

// The truth is pushed by a force of 1 N/m^2, the posterior believes in one of .2 or of 5.
TEST(HeldBandsTest, OneFactorOnTheForceMakesBandsHoldWhatTheySay) {
  Scene scene = SwingScene();
  MotionOptions truth;
  truth.noise = truth.sigma = 1e-4;
  std::vector<RecordedMotion> motions;
  const Simulator simulator(scene);
  const ForceSource source({{1.0, 0.1, 0.1}}, simulator.model());
  for (int r = 0; r < 8; ++r) {
    motions.push_back(MakeMotion(scene, truth));
    RecordingModel model(motions.back(), {});
    model.Correct(source.Draw(1.0, model.cloth(), scene.nominal_parameters().material, model.num_steps(), 99, r));
    Eigen::MatrixXd predicted;
    model.Simulate(Eigen::VectorXd(), {}, {}, &predicted);
    motions.back().positions += predicted - PredictedByScene(motions.back());
  }
  for (const double believed : {0.2, 5.0}) {
    FitPosterior posterior = OfStretch(1e-3);
    posterior.forces = {{believed, 0.1, 0.1}};
    HeldBandOptions options;
    options.with_step = options.with_mesh = false;
    options.num_draws = 24;
    options.num_threads = 2;
    options.calibrates = true;
    const HeldBands bands = JudgeByBands(motions, Blocks(motions[0]), Eigen::VectorXd::Constant(1, 50.0), posterior,
                                         HeldOut::kRecordings, {}, options);
    ASSERT_TRUE(bands.calibration.has_value());
    EXPECT_NEAR(std::log(bands.calibration->factor * believed), 0.0, 0.5) << bands.calibration->factor;
    EXPECT_NEAR(bands.calibration->inside, 0.9, 0.05);
    EXPECT_GT(std::abs(bands.all.inside - 0.9), 0.08) << bands.all.inside;
  }
}

// Of a cloud distances to the surface are held: as often as promised where noise is all, less where stretch is wrong.
TEST(HeldBandsTest, CloudsAreHeldByTheirDistanceToTheSurface) {
  RecordedMotion motion = Swing(50.0, 1e-12);
  motion.cloud_sigma = 1e-3;
  AddClouds(60, 1e-3, /*keep_points=*/false, &motion);
  HeldBandOptions options;
  options.num_draws = 60;
  const HeldBands right = Judge(motion, OfStretch(1e-6), options);
  EXPECT_EQ(right.why_not, "");
  EXPECT_NEAR(right.all.inside, 0.9, 0.03);
  EXPECT_NEAR(right.all.half_width, 1.645e-3, 1e-4);
  RecordedMotion soft = Swing(20.0, 1e-12);
  soft.cloud_sigma = 1e-3;
  AddClouds(60, 1e-3, /*keep_points=*/false, &soft);
  const HeldBands wrong = Judge(soft, OfStretch(1e-6), options), honest = Judge(soft, OfStretch(0.9), options);
  EXPECT_LT(wrong.all.inside, right.all.inside - 0.02);
  EXPECT_GT(honest.all.half_width, wrong.all.half_width);
  EXPECT_GT(honest.all.inside, wrong.all.inside);
}

TEST(HeldBandsTest, SaysWhyThereAreNone) {
  const RecordedMotion motion = Swing(50.0, 1e-3);
  EXPECT_EQ(Judge(motion, FitPosterior()).why_not, "no parameter has an interval");
  RecordedMotion unseen = motion;
  unseen.positions.rightCols(motion.num_frames() - 1).setConstant(std::nan(""));
  EXPECT_EQ(Judge(unseen, OfStretch(0.1)).why_not, "neither a position nor a force was held out");
}

}  // namespace
}  // namespace clothid::held_bands_test
