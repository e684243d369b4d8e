// The force that a model lacks is told from corrections of its rollouts.
#include "identify/checks/correction_check.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "identify/fit/fit.h"
#include "tests/costs/synthetic_motion.h"

namespace clothid::correction_check_test {
namespace {

const Eigen::VectorXd kTimes = Eigen::VectorXd::LinSpaced(6, 0.0, 0.05);

// Mass per area of three nodes, the first of them a handle.
Eigen::VectorXd Mass() { return Eigen::Vector3d(0.0, 0.2, 0.2); }

TEST(CorrectionCheckTest, AForceThatLastsIsItsSize) {
  Eigen::MatrixXd changes = Eigen::MatrixXd::Zero(9, 6);
  changes.rightCols(5).row(4).setConstant(0.03);  // m/s in 10 ms, node 1 along y
  const MissingForce missing = ForceOfChanges(changes, kTimes, Mass(), 10.0);
  EXPECT_NEAR(missing.forces(4, 3), 0.6, 1e-12);
  EXPECT_NEAR(missing.size, 0.6 / std::sqrt(2.0), 1e-12) << "of two nodes that move";
  EXPECT_NEAR(missing.largest_at_node, 0.6, 1e-12);
  EXPECT_EQ(missing.node, 1);
  EXPECT_NEAR(missing.weight, 2.0, 1e-12);
  EXPECT_NEAR(missing.share(), missing.size / 2.0, 1e-12);
}

TEST(CorrectionCheckTest, ThePlaceAndTheTimeOfTheLargestAreTold) {
  Eigen::MatrixXd changes = Eigen::MatrixXd::Zero(9, 6);
  changes.col(3).tail(3).setConstant(0.02);
  changes.col(4).tail(3).setConstant(0.02);
  const MissingForce missing = ForceOfChanges(changes, kTimes, Mass(), 10.0);
  EXPECT_EQ(missing.frame, 4) << "the second of two in which it acts";
  EXPECT_EQ(missing.node, 2);
  EXPECT_NEAR(missing.time, 0.04, 1e-12);
}

TEST(CorrectionCheckTest, NoiseIsNoForce) {
  Eigen::MatrixXd changes = Eigen::MatrixXd::Zero(9, 6);
  for (int i = 1; i < 6; ++i) changes.col(i).tail(6).setConstant(i % 2 == 0 ? 0.03 : -0.03);
  EXPECT_EQ(ForceOfChanges(changes, kTimes, Mass(), 10.0).size, 0.0);
  EXPECT_EQ(ForceOfChanges(changes.leftCols(1), kTimes.head(1), Mass(), 10.0).size, 0.0);
  EXPECT_EQ(ForceOfChanges(changes, kTimes, Eigen::Vector3d::Zero(), 10.0).size, 0.0);
}

// A cloth that falls, free to follow, and is pushed with .2 kg/m^2 times 1.5 m/s^2 along x: a model that knows nothing
// of it lacks that force everywhere.
TEST(CorrectionCheckTest, ThePushThatASceneLacksIsFound) {
  const Scene scene = ClothScene(5, 100);
  Scene pushed = scene;
  pushed.gravity.x() = 1.5;
  MotionOptions made;
  made.sigma = 1e-3;
  RecordedMotion motion = MakeMotion(pushed, made);
  motion.scene = scene;
  FitOptions options;
  options.parameters = {"k_stretch"};
  options.assimilate = {AssimilationOption::Kind::kMemory, {0.05, std::nullopt}};
  FitProblem problem({motion}, options);
  FitSummary summary;
  summary.coordinates = problem.StartCoordinates();
  summary.assimilation = problem.assimilation();
  const std::vector<CorrectionCheck> checks = CheckCorrections({motion}, problem, summary, {});
  ASSERT_EQ(checks.size(), 1u);
  const MissingForce& missing = checks.front().missing_force;
  const auto forces = missing.forces.rightCols(50).reshaped(3, 25 * 50);
  const Eigen::Vector3d mean = forces.rowwise().mean();
  EXPECT_NEAR(mean.x(), 0.3, 0.03);
  EXPECT_NEAR(mean.y(), 0.0, 0.03);
  EXPECT_NEAR(mean.z(), 0.0, 0.03);
  EXPECT_NEAR(missing.size, 0.3, 0.03);
  EXPECT_NEAR(missing.weight, 0.2 * 9.81, 0.01);
  EXPECT_GT(checks.front().innovations.autocorrelation(), 0.5);
}

// A push that turns around every 50 ms: a memory of 1 s averages it away, one of .09 s less.
TEST(CorrectionCheckTest, AMemoryOfATenthOfASecondTellsWhatLasts) {
  Scene scene = ClothScene(5, 100);
  scene.material.drag = 0.5;
  Scene gusty = scene;
  gusty.wind.gust = Eigen::Vector3d(2.0, 0.0, 0.0);
  gusty.wind.frequency = 60.0;
  MotionOptions made;
  made.sigma = 1e-3;
  RecordedMotion motion = MakeMotion(gusty, made);
  motion.scene = scene;
  FitOptions options;
  options.parameters = {"k_stretch"};
  const FitProblem problem({motion}, options);
  FitSummary summary;
  summary.coordinates = problem.StartCoordinates();
  const auto lasting = [&](double end, const std::vector<double>& tried) {
    summary.assimilation = {end};
    summary.memory_trials.clear();
    for (const double memory : tried) summary.memory_trials.emplace_back().memory = memory;
    return CheckCorrections({motion}, problem, summary, {})[0].missing_force.lasting;
  };
  const LastingForce slow = lasting(1.0, {}), fast = lasting(0.09, {}), of_many = lasting(1.0, {0.02, 0.09, 1.0});
  EXPECT_GT(fast.size, 2.0 * slow.size);
  EXPECT_EQ(of_many.size, fast.size);
  EXPECT_EQ(of_many.time, fast.time);
}

TEST(CorrectionCheckTest, NothingIsToldWithoutCorrections) {
  const RecordedMotion motion = MakeMotion(SwingScene(), {});
  FitOptions options;
  options.parameters = {"k_stretch"};
  FitProblem problem({motion}, options);
  FitSummary summary;
  summary.coordinates = problem.StartCoordinates();
  EXPECT_TRUE(CheckCorrections({motion}, problem, summary, {}).empty());
}

}  // namespace
}  // namespace clothid::correction_check_test
