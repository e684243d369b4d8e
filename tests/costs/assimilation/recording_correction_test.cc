// Rollouts that their recording corrects: gains, how innovations spread, and derivatives,
// adjoint = sensitivity = central differences.
#include "costs/assimilation/recording_correction.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include "costs/prediction/recording_model.h"
#include "costs/rollout_cost.h"
#include "tests/costs/synthetic_clouds.h"
#include "tests/costs/synthetic_motion.h"

namespace clothid::recording_correction_test {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

TEST(CorrectionGainsTest, AreThoseOfTheSteadyKalmanFilter) {
  // Of a point with white accelerations and measured positions, iterated until covariance and gain stand still. Its
  // memory is the one whose alpha it has; beta must follow.
  const double dt = 0.01, sigma = 1e-3;
  for (const double acceleration : {0.1, 3.0, 100.0}) {
    Eigen::Matrix2d covariance = Eigen::Matrix2d::Identity();
    const Eigen::Matrix2d move = (Eigen::Matrix2d() << 1.0, dt, 0.0, 1.0).finished();
    const Eigen::Vector2d noise(0.5 * dt * dt * acceleration, dt * acceleration);
    Eigen::Vector2d gain;
    for (int i = 0; i < 20000; ++i) {
      covariance = (move * covariance * move.transpose() + noise * noise.transpose()).eval();
      gain = covariance.col(0) / (covariance(0, 0) + sigma * sigma);
      covariance -= (gain * covariance.row(0)).eval();
    }
    const double memory = -dt / std::log(std::sqrt(1.0 - gain[0]));
    const CorrectionGains gains = GainsOver(dt, memory);
    EXPECT_NEAR(gains.positions, gain[0], 1e-9);
    EXPECT_NEAR(gains.velocities, gain[1], 1e-6 * gain[1]) << acceleration;
  }
}

TEST(CorrectionGainsTest, LongMemoryCorrectsNothingAndShortTakesTheMeasurement) {
  EXPECT_NEAR(GainsOver(0.01, 1e6).positions, 2e-8, 1e-12);
  EXPECT_NEAR(GainsOver(0.01, 1e6).velocities, 2e-14, 1e-18);
  EXPECT_NEAR(GainsOver(0.01, 1e-4).positions, 1.0, 1e-12);
  EXPECT_NEAR(GainsOver(0.01, 1e-4).velocities, 200.0, 1e-9);
}

InfluenceOf Of(const std::string& loss) {
  return [loss = ParseRobustLoss(loss)](double squared) { return InfluenceOn(loss, squared); };
}

// What one corrected step makes of a recording that shows `measured` [3P] at its end, where the cloth stands at x.
Eigen::VectorXd CorrectedBy(const RecordedMotion& motion, const Assimilation& assimilation,
                            const InfluenceOf& influence, const Eigen::VectorXd& x) {
  const Observation observation(motion);
  const Simulator simulator(motion.scene);
  const RecordingCorrection correction(assimilation, influence, observation, motion.times, simulator.model());
  Eigen::VectorXd positions, velocities;
  EXPECT_TRUE(correction.Corrects(1));
  correction.Evaluate(1, {x, x}, &positions, &velocities);
  const CorrectionGains gains = GainsOver(motion.times[1] - motion.times[0], assimilation.memory);
  EXPECT_LT((velocities - gains.velocities / gains.positions * positions).norm(), 1e-12);
  return positions / gains.positions;
}

// A flat cloth that hangs in the air.
RecordedMotion StillMotion() {
  Scene scene = ClothScene(24, 8);
  scene.gravity.setZero();
  return MakeMotion(scene, {});
}

TEST(RecordingCorrectionTest, SeenNodesTakeTheirInnovation) {
  RecordedMotion motion = StillMotion();
  const Eigen::VectorXd x = motion.positions.col(0);
  motion.positions.col(1) = x + 1e-3 * Eigen::VectorXd::LinSpaced(x.size(), -1.0, 1.0);
  const Eigen::VectorXd moved = CorrectedBy(motion, {0.05, 0.0}, {}, x);
  EXPECT_LT((moved - (motion.positions.col(1) - x)).norm(), 1e-8 * moved.norm());
}

TEST(RecordingCorrectionTest, WavesAreSmoothedByTheirLength) {
  RecordedMotion motion = StillMotion();
  const Eigen::VectorXd x = motion.positions.col(0);
  const double length = 0.2, smoothing = 0.02;
  for (int node = 0; node < motion.num_points(); ++node) {
    motion.positions(3 * node + 2, 1) += 1e-3 * std::cos(2.0 * M_PI * x[3 * node] / length);
  }
  const Eigen::VectorXd moved = CorrectedBy(motion, {0.05, smoothing}, {}, x);
  const Eigen::VectorXd wave = motion.positions.col(1) - x;
  const double kept = 1.0 / (1.0 + std::pow(2.0 * M_PI * smoothing / length, 4));
  EXPECT_LT((moved - kept * wave).norm(), 0.03 * wave.norm());
}

TEST(RecordingCorrectionTest, UnseenNodesMoveWithThoseAroundThem) {
  RecordedMotion motion = WithMarkers(StillMotion());
  const Eigen::VectorXd x = motion.scene.initial_positions;
  motion.positions.col(1) = motion.positions.col(0).array() + 1e-3;
  const Eigen::VectorXd moved = CorrectedBy(motion, {0.05, 0.005}, {}, x);
  EXPECT_LT((moved.array() - 1e-3).abs().maxCoeff(), 1e-5) << "a cloth that is shifted is shifted everywhere";
}

TEST(RecordingCorrectionTest, GrossErrorsCountAsTheLossLetsThem) {
  RecordedMotion motion = StillMotion();
  motion.sigma = Eigen::VectorXd::Constant(motion.num_points(), 1e-3);
  const Eigen::VectorXd x = motion.positions.col(0);
  motion.positions(300, 1) += 1.0;
  EXPECT_NEAR(CorrectedBy(motion, {0.05, 0.0}, {}, x)[300], 1.0, 1e-6);
  EXPECT_NEAR(CorrectedBy(motion, {0.05, 0.0}, Of("huber:2"), x)[300], 2e-3, 1e-6);
  EXPECT_NEAR(CorrectedBy(motion, {0.05, 0.0}, Of("cauchy:2"), x)[300], 4e-6, 1e-8);
}

// A cloth whose nodes stand at `x`, seen as 4000 points of the same cloth moved by `shift`.
RecordedMotion SeenAsCloud(const Eigen::VectorXd& x, const Eigen::Vector3d& shift) {
  RecordedMotion motion = StillMotion();
  motion.positions = (x + shift.replicate(x.size() / 3, 1)).replicate(1, motion.num_frames());
  AddClouds(4000, 0.0, /*keep_points=*/false, &motion);
  motion.cloud_sigma = 1e-3;
  return motion;
}

Eigen::VectorXd Waves() {
  Eigen::VectorXd x = StillMotion().positions.col(0);
  for (Eigen::Index node = 0; node < x.size() / 3; ++node) x[3 * node + 2] += 0.05 * std::sin(20.0 * x[3 * node]);
  return x;
}

TEST(CloudCorrectionTest, MovesTheClothAlongItsNormal) {
  const Eigen::VectorXd flat = StillMotion().positions.col(0);
  const Eigen::Vector3d shift(0.0, 0.0, 1e-3);
  const Eigen::VectorXd moved = CorrectedBy(SeenAsCloud(flat, shift), {0.05, 0.02}, {}, flat);
  for (Eigen::Index node = 0; node < flat.size() / 3; ++node) {
    EXPECT_LT((moved.segment<3>(3 * node) - shift).norm(), 5e-6) << node;
  }
}

TEST(CloudCorrectionTest, TellsHowAClothThatIsNotFlatMovesAlongItself) {
  const Eigen::VectorXd waves = Waves();
  const Eigen::Vector3d shift(1e-3, 0.0, 0.0);
  const Eigen::VectorXd moved = CorrectedBy(SeenAsCloud(waves, shift), {0.05, 0.02}, {}, waves);
  const Eigen::Vector3d mean = moved.reshaped(3, moved.size() / 3).rowwise().mean();
  EXPECT_GT(mean.x(), 0.5 * shift.x()) << "crests are level";
  EXPECT_LT(mean.x(), shift.x());
  EXPECT_LT(mean.tail<2>().norm(), 0.02 * shift.x());
}

TEST(CloudCorrectionTest, SaysNothingWhereTheClothIs) {
  const Eigen::VectorXd waves = Waves();
  const RecordedMotion motion = SeenAsCloud(waves, Eigen::Vector3d::Zero());
  EXPECT_LT(CorrectedBy(motion, {0.05, 0.02}, {}, waves).norm(), 1e-12);
}

TEST(CloudCorrectionTest, GrossErrorsCountAsTheLossLetsThem) {
  const Eigen::VectorXd flat = StillMotion().positions.col(0);
  RecordedMotion motion = SeenAsCloud(flat, Eigen::Vector3d::Zero());
  motion.clouds[1](2, 7) += 0.1;
  const double plain = CorrectedBy(motion, {0.05, 0.02}, {}, flat).lpNorm<Eigen::Infinity>();
  EXPECT_GT(plain, 5e-4);
  EXPECT_LT(CorrectedBy(motion, {0.05, 0.02}, Of("huber:2"), flat).lpNorm<Eigen::Infinity>(), 0.03 * plain);
}

// A cloth that clings, seen at times between steps by markers, some of them hidden, and far from what is simulated.
struct Case {
  const char* name;
  RecordedMotion (*motion)();
  const char* loss;
  double memory, smoothing;
};

RecordedMotion Swinging() {
  MotionOptions options;
  options.true_values = {{"k_stretch", 90.0}, {"drag", 0.3}};
  options.noise = 1e-3;
  RecordedMotion motion = MakeMotion(SwingScene(), options);
  motion.positions.block(21, 5, 12, 6).setConstant(kNaN);
  motion.positions(40, 9) = kNaN;
  return motion;
}

RecordedMotion Sliding(double frame_interval) {
  MotionOptions options;
  options.true_values = {{"mu", 0.35}, {"k_stretch", 90.0}};
  options.sigma = 1e-3;
  options.noise = 1e-3;
  options.frame_interval = frame_interval;
  return MakeMotion(SphereScene(), options);
}

RecordedMotion SlidingMarkers() { return WithMarkers(Sliding(0.0125)); }
RecordedMotion OftenSeen() { return Sliding(0.004); }

// Clouds and points that slide, with noise, between steps and two frames in some steps.
RecordedMotion Clouded(double frame_interval, int count, bool keep_points) {
  RecordedMotion motion = Sliding(frame_interval);
  AddClouds(count, 2e-3, keep_points, &motion);
  motion.cloud_sigma = 2e-3;
  motion.clouds[2].resize(3, 0);
  return motion;
}

RecordedMotion SparseClouds() { return Clouded(0.0125, 40, false); }
RecordedMotion DenseClouds() { return Clouded(0.004, 800, false); }
RecordedMotion CloudsBesideMarkers() { return WithMarkers(Clouded(0.0125, 60, true)); }

RecordedMotion SlidingPoints() {
  RecordedMotion motion = Sliding(0.0125);
  SlidePoints(/*borders=*/true, 12, &motion);
  motion.positions.col(3).setConstant(kNaN);
  std::mt19937_64 generator(13);
  std::normal_distribution<double> normal(0.0, 2e-3);
  for (double& position : motion.positions.reshaped()) position += normal(generator);
  return motion;
}

RecordedMotion SlidingSdirk() {
  RecordedMotion motion = Sliding(0.02);
  motion.scene.integrator = Integrator::kSdirk2;
  return motion;
}

class AssimilatedModelTest : public testing::TestWithParam<Case> {
 protected:
  AssimilatedModelTest()
      : motion_(GetParam().motion()),
        model_(motion_, MakeBlocks(motion_.scene, Names())),
        point_(StartOf(model_.blocks())) {
    model_.Assimilate({GetParam().memory, GetParam().smoothing}, ParseRobustLoss(GetParam().loss));
  }

  std::vector<std::string> Names() const {
    std::vector<std::string> names = {"k_stretch", "drag", "k_bend"};
    if (!motion_.scene.obstacles.empty()) names.push_back("mu");
    return names;
  }

  Eigen::MatrixXd PredictionAt(const Eigen::VectorXd& point) {
    Eigen::MatrixXd predicted;
    EXPECT_TRUE(model_.Simulate(point, {}, {}, &predicted).ok());
    return predicted;
  }

  RecordedMotion motion_;
  RecordingModel model_;
  Eigen::VectorXd point_;
};

INSTANTIATE_TEST_SUITE_P(Motions, AssimilatedModelTest,
                         testing::Values(Case{"Swing", &Swinging, "none", 0.015, 0.02},
                                         Case{"SwingRobust", &Swinging, "cauchy:3", 0.1, 0.0},
                                         Case{"SwingLong", &Swinging, "huber:2", 1.0, 0.04},
                                         Case{"Markers", &SlidingMarkers, "none", 0.05, 0.03},
                                         Case{"MarkersRobust", &SlidingMarkers, "huber:1.5", 0.02, 0.03},
                                         Case{"OftenSeen", &OftenSeen, "cauchy:2", 0.02, 0.01},
                                         Case{"SecondOrder", &SlidingSdirk, "none", 0.03, 0.02},
                                         Case{"SparseClouds", &SparseClouds, "none", 0.03, 0.02},
                                         Case{"SparseCloudsRobust", &SparseClouds, "huber:1.5", 0.03, 0.0},
                                         Case{"DenseClouds", &DenseClouds, "cauchy:2", 0.02, 0.01},
                                         Case{"CloudsBesideMarkers", &CloudsBesideMarkers, "none", 0.1, 0.03},
                                         Case{"SlidingPoints", &SlidingPoints, "huber:2", 0.03, 0.02}),
                         [](const auto& test) { return test.param.name; });

TEST_P(AssimilatedModelTest, AdjointAgreesWithSensitivitiesAndDifferences) {
  std::vector<int> all;
  for (int i = 0; i < model_.num_blocks(); ++i) all.push_back(i);
  Eigen::MatrixXd predicted;
  const Rollout rollout = model_.Simulate(point_, {}, {}, &predicted);
  ASSERT_TRUE(rollout.ok()) << rollout.failure->ToString();
  const Observation& observation = model_.observation();
  Eigen::MatrixXd jacobian = Eigen::MatrixXd::Zero(observation.num_residuals(), point_.size());
  const auto keep = [&](int frame, const Eigen::VectorXd& points, const Eigen::VectorXd& residuals,
                        const Eigen::MatrixXd& own) {
    EXPECT_LT((points - predicted.col(frame)).norm(), 1e-13);
    jacobian.middleRows(observation.first_row(frame), residuals.size()) = own;
  };
  model_.PushForward(point_, {all, {}}, keep, {});
  std::mt19937_64 generator(3);
  std::normal_distribution<double> normal;
  Eigen::MatrixXd seeds(observation.num_residuals(), 2);
  for (double& seed : seeds.reshaped()) seed = normal(generator);
  const Eigen::MatrixXd back = model_.PullBack(rollout, predicted, {}, point_, all, seeds, {}, Precision::kFull);
  EXPECT_LT((jacobian.transpose() * seeds - back).norm(), 1e-10 * back.norm());

  Eigen::MatrixXd again = Eigen::MatrixXd::Zero(jacobian.rows(), jacobian.cols());
  const auto keep_again = [&](int frame, const Eigen::VectorXd&, const Eigen::VectorXd& residuals,
                              const Eigen::MatrixXd& own) {
    again.middleRows(observation.first_row(frame), residuals.size()) = own;
  };
  model_.PushForward(rollout, point_, {all, {}}, keep_again, Precision::kFull);
  EXPECT_LT((again - jacobian).norm(), 1e-11 * jacobian.norm()) << "along the rollout that is kept";

  for (Eigen::Index i = 0; i < point_.size(); ++i) {
    Eigen::VectorXd above = point_, below = point_;
    const double step = 1e-5;
    above[i] += step;
    below[i] -= step;
    const Eigen::VectorXd difference =
        (observation.Residuals(PredictionAt(above)) - observation.Residuals(PredictionAt(below))) / (2.0 * step);
    EXPECT_LT((difference - jacobian.col(i)).norm(), 1e-6 * jacobian.col(i).norm()) << Names()[i];
  }
}

TEST_P(AssimilatedModelTest, ThreadsChangeNothingAndCheckpointsLittle) {
  Eigen::MatrixXd predicted;
  const Rollout kept = model_.Simulate(point_, {}, {}, &predicted);
  model_.SetNumThreads(2);
  EXPECT_EQ((PredictionAt(point_) - predicted).cwiseAbs().maxCoeff(), 0.0);
  Eigen::MatrixXd again;
  RolloutStorage storage;
  storage.memory_limit = 1;
  const Rollout rollout = model_.Simulate(point_, {}, storage, &again);
  ASSERT_TRUE(rollout.ok());
  EXPECT_GT(rollout.checkpoint_interval, 0);
  EXPECT_LT((again - predicted).cwiseAbs().maxCoeff(), 1e-10);
  const std::vector<int> first = {0};
  const Eigen::MatrixXd seeds = Eigen::MatrixXd::Ones(model_.observation().num_residuals(), 1);
  const auto gradient = [&](const Rollout& of) {
    return model_.PullBack(of, predicted, {}, point_, first, seeds, {}, Precision::kFull)(0, 0);
  };
  EXPECT_NEAR(gradient(rollout) / gradient(kept), 1.0, 1e-8);
}

TEST(AssimilatedCostTest, IsZeroAtTheTruthWhateverTheMemory) {
  MotionOptions options;
  options.true_values = {{"mu", 0.35}, {"k_stretch", 90.0}};
  options.sigma = 1e-3;
  const RecordedMotion motion = MakeMotion(SphereScene(), options);
  std::vector<ParameterBlock> blocks = MakeBlocks(motion.scene, {"mu", "k_stretch"});
  const Eigen::VectorXd truth =
      (Eigen::VectorXd(2) << blocks[0].ToCoordinate(0.35), blocks[1].ToCoordinate(90.0)).finished();
  double at_start_before = 0.0;
  for (const double memory : {0.0, 0.2, 0.01}) {
    RolloutCostOptions cost_options;
    cost_options.assimilation = {memory, 0.0};
    const RolloutCost cost(motion, blocks, cost_options);
    double at_truth = 0.0, at_start = 0.0;
    ASSERT_TRUE(cost.EvaluateGradient(truth, &at_truth, nullptr));
    ASSERT_TRUE(cost.EvaluateGradient(StartOf(blocks), &at_start, nullptr));
    EXPECT_LT(at_truth, 1e-8 * at_start);
    if (memory > 0.0) {
      EXPECT_LT(at_start, at_start_before) << "the state is drawn to the recording";
    }
    at_start_before = at_start;
  }
}

TEST(AssimilatedCostTest, TellsWhoCannotBeCorrected) {
  const RecordedMotion motion = MakeMotion(SphereScene(), {});
  const RecordingModel plain(motion, MakeBlocks(motion.scene, {"mu"}));
  EXPECT_EQ(plain.WhyNotAssimilated(), "");
  std::vector<ParameterBlock> blocks = MakeBlocks(motion.scene, {"mu"});
  blocks.push_back(MakeParameterBlock("shift.x", motion, {}));
  RecordingModel shifted(motion, blocks);
  EXPECT_EQ(shifted.WhyNotAssimilated(), "has a frame of reference that is fitted");
  EXPECT_THROW(shifted.Assimilate({0.1, 0.0}, {}), std::logic_error);
  blocks.back() = MakeParameterBlock("time_offset", motion, {});
  EXPECT_EQ(RecordingModel(motion, blocks).WhyNotAssimilated(), "has a clock that is fitted");
}

}  // namespace
}  // namespace clothid::recording_correction_test
