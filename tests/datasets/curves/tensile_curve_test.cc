#include "datasets/curves/tensile_curve.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <string>
#include <vector>

#include "datasets/curves/tensile_recording.h"
#include "datasets/motion/motion_file.h"
#include "sim/base/error.h"
#include "sim/scene/warp.h"
#include "tests/expect_error.h"

namespace clothid::tensile_curve_test {
namespace {

constexpr double kWidth = 0.05, kLength = 0.2, kStiffness = 300.0, kStiffening = 6.0;
constexpr double kMostPulled = 0.25;  // strain

double ForceAt(double strain) { return kWidth * kStiffness * std::expm1(kStiffening * strain) / kStiffening; }

// Readings at an even speed from the elongation `from` to `to`, m, of a cloth with this slack.
void Pull(double from, double to, int count, double slack, CurveTable* table) {
  const Eigen::Index start = table->forces.size();
  table->elongations.conservativeResize(start + count);
  table->forces.conservativeResize(start + count);
  for (int i = 0; i < count; ++i) {
    const double elongation = from + (to - from) * i / (count - 1.0);
    table->elongations[start + i] = elongation;
    table->forces[start + i] = elongation > slack ? ForceAt((elongation - slack) / (kLength + slack)) : 0.0;
  }
}

class TensileCurveTest : public testing::Test {
 protected:
  TensileCurveTest() {
    table_.name = "c.csv";
    options_.width = kWidth;
    options_.length = kLength;
  }

  void Add(double from, double to, int count, double slack = 0.0) { Pull(from, to, count, slack, &table_); }

  void ExpectLaw(const TensileCurve& curve, double relative) const {
    for (Eigen::Index i = 0; i < curve.strains.size(); ++i) {
      EXPECT_NEAR(curve.forces[i], ForceAt(curve.strains[i]), relative * ForceAt(kMostPulled)) << curve.strains[i];
    }
  }

  void ExpectRefused(ErrorKind kind, const char* expected) const {
    ExpectError([&] { MakeTensileCurve(table_, options_); }, kind, {expected});
  }

  CurveTable table_;
  TensileCurveOptions options_;
};

TEST_F(TensileCurveTest, KeepsTheLawOfAPlainCurve) {
  Add(0.0, kMostPulled * kLength, 1001);
  const TensileCurve curve = MakeTensileCurve(table_, options_);
  EXPECT_NEAR(curve.slack, 0.0, 3e-4 * kLength);
  EXPECT_NEAR(curve.length, kLength, 3e-4 * kLength);
  EXPECT_EQ(curve.strains.size(), 60);
  EXPECT_NEAR(curve.strains[59], kMostPulled, 3e-3);
  EXPECT_NEAR(curve.preload, kPreloadShare * ForceAt(kMostPulled), 1e-3 * ForceAt(kMostPulled));
  EXPECT_EQ(curve.num_slack + curve.num_thinned, 1001);
  EXPECT_EQ(curve.num_after + curve.num_outside, 0);
  EXPECT_TRUE(curve.is_sigma_estimated);
  EXPECT_NEAR(curve.force_sigma, kLeastSigmaShare * ForceAt(kMostPulled), 1e-5 * ForceAt(kMostPulled));
  ExpectLaw(curve, 2e-3);
}

TEST_F(TensileCurveTest, CutsSlackAndLengthensTheSpecimenByIt) {
  const double slack = 0.004, rest = kLength + slack;
  Add(0.0, slack + kMostPulled * rest, 1001, slack);
  const TensileCurve curve = MakeTensileCurve(table_, options_);
  EXPECT_NEAR(curve.slack, slack, 6e-4 * kLength);
  EXPECT_NEAR(curve.length, rest, 6e-4 * kLength);
  EXPECT_NEAR(curve.num_slack, 1000.0 * slack / table_.elongations[1000], 20.0);
  ExpectLaw(curve, 3e-3);
  // The line through more of the curve leads farther beside its start.
  options_.preload = 0.06 * ForceAt(kMostPulled);
  EXPECT_NEAR(MakeTensileCurve(table_, options_).slack, slack + 5e-3 * kLength, 2e-3 * kLength);
}

TEST_F(TensileCurveTest, ACurveThatStartsUnderLoadHasNoSlack) {
  Add(0.01, kMostPulled * kLength, 500);
  const TensileCurve curve = MakeTensileCurve(table_, options_);
  EXPECT_EQ(curve.slack, 0.0);
  EXPECT_EQ(curve.num_slack, 0);
  EXPECT_DOUBLE_EQ(curve.length, kLength);
  ExpectLaw(curve, 2e-3);
}

TEST_F(TensileCurveTest, TellsLoadingFromWhatFollows) {
  const double most = kMostPulled * kLength;
  Add(0.0, most, 500);
  const TensileCurve loading = MakeTensileCurve(table_, options_);
  Add(0.999 * most, 0.0, 300);
  TensileCurve curve = MakeTensileCurve(table_, options_);
  EXPECT_EQ(curve.num_after, 300);
  EXPECT_FALSE(curve.returns_to_more);
  EXPECT_EQ(curve.strains, loading.strains);
  // Pulled farther in a second loading, and brought to the start before the first.
  Add(0.0, 1.2 * most, 500);
  curve = MakeTensileCurve(table_, options_);
  EXPECT_EQ(curve.num_after, 800);
  EXPECT_TRUE(curve.returns_to_more);
  CurveTable brought;
  brought.name = "c.csv";
  Pull(0.01, 0.0, 20, 0.0, &brought);
  brought.forces.setZero();
  Pull(0.0, most, 500, 0.0, &brought);
  EXPECT_NEAR(MakeTensileCurve(brought, options_).strains.tail<1>()[0], loading.strains.tail<1>()[0], 1e-3);
}

TEST_F(TensileCurveTest, EstimatesSigmaAndAveragesNoise) {
  Add(0.0, kMostPulled * kLength, 1201);
  const double noise = 0.004 * ForceAt(kMostPulled);
  std::mt19937_64 generator(1);
  std::normal_distribution<double> normal;
  for (double& force : table_.forces) force += noise * normal(generator);
  const TensileCurve curve = MakeTensileCurve(table_, options_);
  EXPECT_NEAR(curve.force_sigma, noise / std::sqrt(20.0), 0.35 * noise / std::sqrt(20.0));
  EXPECT_NEAR(curve.slack, 0.0, 2e-3 * kLength);
  options_.force_sigma = 0.25;
  EXPECT_EQ(MakeTensileCurve(table_, options_).force_sigma, 0.25);
}

TEST_F(TensileCurveTest, KeepsARangeOfStrain) {
  Add(0.0, kMostPulled * kLength, 1001);
  options_.least_strain = 0.05;
  options_.most_strain = 0.15;
  options_.max_readings = 20;
  const TensileCurve curve = MakeTensileCurve(table_, options_);
  EXPECT_EQ(curve.strains.size(), 20);
  EXPECT_GT(curve.strains[0], 0.05);
  EXPECT_LT(curve.strains[19], 0.15);
  EXPECT_EQ(curve.num_slack + curve.num_outside + curve.num_thinned, 1001);
  EXPECT_NEAR(curve.num_thinned, 400.0, 4.0);
}

TEST_F(TensileCurveTest, ConvertsStrainsWidthsAndGauges) {
  Add(0.0, kMostPulled * kLength, 1001);
  const TensileCurve plain = MakeTensileCurve(table_, options_);
  CurveTable table = table_;
  table.elongations /= kLength;
  table.forces /= kWidth;
  table.is_strain = table.is_per_width = true;
  const TensileCurve same = MakeTensileCurve(table, options_);
  EXPECT_LT((same.strains - plain.strains).cwiseAbs().maxCoeff(), 1e-12);
  EXPECT_LT((same.forces - plain.forces).cwiseAbs().maxCoeff(), 1e-12);
  EXPECT_NEAR(same.length, plain.length, 1e-12);
  // An extensometer over a quarter of the specimen.
  table_.elongations *= 0.25;
  options_.gauge_length = 0.25 * kLength;
  const TensileCurve quarter = MakeTensileCurve(table_, options_);
  EXPECT_LT((quarter.strains - plain.strains).cwiseAbs().maxCoeff(), 1e-12);
  EXPECT_NEAR(quarter.length, plain.length, 1e-12);
  // What the table tells stands in for what is not given.
  table.width = kWidth;
  table.gauge_length = kLength;
  options_ = {};
  EXPECT_EQ(MakeTensileCurve(table, options_).strains, same.strains);
}

TEST_F(TensileCurveTest, RefusesCurvesThatAreNone) {
  Add(0.0, 0.0, 50);
  ExpectRefused(ErrorKind::kBadData, "c.csv: expected an elongation that grows");
  table_ = {};
  table_.name = "c.csv";
  Add(0.0, kMostPulled * kLength, 101);
  const CurveTable good = table_;
  table_.forces *= -1.0;
  ExpectRefused(ErrorKind::kBadData, "tension is positive");
  table_ = good;
  table_.elongations *= 1e3;
  ExpectRefused(ErrorKind::kBadData, "is a unit off?");
  table_ = good;
  options_.preload = 100.0;
  ExpectRefused(ErrorKind::kBadData, "expected more than the preload, 100 N");
  options_.preload = 0.0;
  options_.least_strain = 0.24;
  ExpectRefused(ErrorKind::kBadData, "expected at least 8 readings of the loading");
  options_.least_strain = 0.5;
  ExpectRefused(ErrorKind::kBadData, "found 0");
  options_.least_strain = 0.0;
  table_.elongations.conservativeResize(6);
  table_.forces.conservativeResize(6);
  ExpectRefused(ErrorKind::kBadData, "expected at least 8 readings");
  table_ = good;
  options_.width = 0.0;
  ExpectRefused(ErrorKind::kUsage, "c.csv: does not tell the width");
  options_.width = kWidth;
  options_.length = 0.0;
  ExpectRefused(ErrorKind::kUsage, "c.csv: does not tell the length");
  options_.length = -1.0;
  ExpectRefused(ErrorKind::kUsage, "length: expected a number > 0");
}

TEST_F(TensileCurveTest, BecomesARecordingOfAStrip) {
  Add(0.0, kMostPulled * kLength, 1001);
  const TensileCurve curve = MakeTensileCurve(table_, options_);
  TensileStrip strip;
  strip.nodes = {3, 5};
  for (const PullDirection direction : {PullDirection::kWarp, PullDirection::kWeft}) {
    strip.direction = direction;
    const MotionTensors tensors = RecordTensileTest(curve, strip, "curve");
    const RecordedMotion motion = InterpretMotion(tensors, "curve");
    EXPECT_EQ(motion.scene.gravity, Eigen::Vector3d::Zero());
    EXPECT_EQ(motion.start_source, StartSource::kScene);
    EXPECT_EQ(motion.scene.handles.nodes, (std::vector<int>{0, 1, 2, 12, 13, 14}));
    EXPECT_EQ(motion.forces.groups, (std::vector<std::vector<int>>{{12, 13, 14}}));
    EXPECT_EQ(motion.forces.values.row(2).transpose(), curve.forces);
    EXPECT_TRUE(motion.forces.values.topRows(2).array().isNaN().all());
    EXPECT_TRUE(motion.positions.array().isNaN().all());
    // The clamp is where the strain of every reading is.
    for (int i = 0; i < motion.forces.num_readings(); ++i) {
      const Eigen::VectorXd held = motion.scene.handles.path.At(motion.forces.times[i]);
      EXPECT_NEAR(held[3 * 4 + 2], curve.length * (1.0 + curve.strains[i]), 1e-12);
      EXPECT_EQ(held[2], 0.0);
    }
    const bool is_warp = direction == PullDirection::kWarp;
    EXPECT_EQ(ParametersOfPull(strip), is_warp ? "k_warp,stiffening_warp" : "k_weft,stiffening_weft");
    EXPECT_DOUBLE_EQ(motion.scene.material.warp_stiffness, 1000.0);  // of 300 (exp(1.5) - 1)/1.5
    EXPECT_EQ(motion.scene.material.weft_stiffening, 3.0);
  }
  strip.direction = PullDirection::kBias;
  EXPECT_EQ(ParametersOfPull(strip), "k_shear");
  const Scene scene = InterpretMotion(RecordTensileTest(curve, strip, "curve"), "curve").scene;
  const Eigen::Vector3d warp = WarpDirections(scene.warp, scene.mesh).col(0);
  EXPECT_NEAR(std::abs(warp.x()), std::sqrt(0.5), 1e-12);
  EXPECT_NEAR(std::abs(warp.z()), std::sqrt(0.5), 1e-12);
  EXPECT_EQ(UsualNodes(curve, PullDirection::kWarp), (std::array<int, 2>{9, 9}));
  EXPECT_EQ(UsualNodes(curve, PullDirection::kBias), (std::array<int, 2>{9, 33}));
  EXPECT_LT(InertiaAtClamp(curve), 1e-5 * ForceAt(kMostPulled));
  strip.direction = PullDirection::kWeft;
  strip.membrane = MembraneLaw::kOrthotropic;
  EXPECT_EQ(ParametersOfPull(strip), "k_weft");
  EXPECT_EQ(InterpretMotion(RecordTensileTest(curve, strip, "curve"), "curve").scene.material.weft_stiffening, 0.0);
  strip.membrane = MembraneLaw::kArap;
  ExpectError([&] { RecordTensileTest(curve, strip, "curve"); }, ErrorKind::kUsage, {"membrane"});
}

// Marks that were 30 mm apart on a cloth that contracts by 0.4 of its strain and more, with the noise of a camera.
TEST_F(TensileCurveTest, ReadsContraction) {
  const double slack = 0.002, rest = kLength + slack;
  Add(0.0, slack + kMostPulled * rest, 2001, slack);
  std::mt19937_64 generator(5);
  std::normal_distribution<double> noise(0.0, 2e-5);
  const auto width_at = [](double strain) { return 0.03 * (1.0 - 0.4 * strain - 0.2 * strain * strain); };
  table_.widths.resize(table_.elongations.size());
  for (Eigen::Index i = 0; i < table_.widths.size(); ++i) {
    const double strain = std::max(0.0, (table_.elongations[i] - slack) / rest);
    table_.widths[i] = width_at(strain) + noise(generator);
  }
  const TensileCurve curve = MakeTensileCurve(table_, options_);
  ASSERT_EQ(curve.widths.size(), curve.strains.size());
  EXPECT_NEAR(curve.rest_width, 0.03, 3e-5);
  EXPECT_NEAR(curve.width_sigma, 5e-5, 1e-6) << "a thousandth of the specimen is the least";
  for (Eigen::Index i = 0; i < curve.strains.size(); ++i) {
    EXPECT_NEAR(curve.widths[i], width_at(curve.strains[i]), 4e-5);
  }

  TensileStrip strip;
  strip.nodes = {9, 9};
  const RecordedMotion motion = InterpretMotion(RecordTensileTest(curve, strip, "curve"), "curve");
  ASSERT_EQ(motion.num_points(), 1);
  EXPECT_EQ(motion.times.size(), curve.strains.size() + 1);
  EXPECT_EQ(motion.positions.row(0).tail(curve.strains.size()).transpose(), 0.5 * curve.widths);
  EXPECT_TRUE(motion.positions.bottomRows(2).array().isNaN().all());
  Eigen::Vector3d place = Eigen::Vector3d::Zero();
  const ObservedPoint& point = motion.points.front();
  for (int k = 0; k < point.num_nodes; ++k) {
    place += point.weights[k] * motion.scene.mesh.rest_positions.col(point.nodes[k]);
  }
  EXPECT_NEAR(place.x(), 0.5 * curve.rest_width, 1e-12);
  EXPECT_NEAR(place.z(), 0.5 * curve.length, 1e-12);
  EXPECT_EQ(ParametersOfPull(strip, /*has_widths=*/true), "k_warp,stiffening_warp,k_poisson");

  table_.is_width_strain = true;
  table_.widths = table_.widths.array() / 0.03 - 1.0;
  EXPECT_NEAR(MakeTensileCurve(table_, options_).rest_width, kWidth, 1e-3 * kWidth);
  table_.is_width_strain = false;
  ExpectRefused(ErrorKind::kBadData, "c.csv: its width at rest is ");
}

}  // namespace
}  // namespace clothid::tensile_curve_test
