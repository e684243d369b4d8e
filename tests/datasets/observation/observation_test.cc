// The map from trajectories to predicted points, its transpose, and which coordinates carry a residual.
#include "datasets/observation/observation.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "datasets/observation/residual_derivative.h"
#include "tests/expect_error.h"

namespace clothid::observation_test {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr int kNumSteps = 10;

// Two triangles (4 nodes), steps of 0.1 s, frames on and between steps.
RecordedMotion MakeMotion() {
  RecordedMotion motion;
  motion.name = "test.bin";
  motion.scene.time_step = 0.1;
  motion.scene.start_time = 2.0;
  motion.scene.mesh = MakeGrid({{2, 2}, {1.0, 0.25}});
  motion.scene.initial_positions = motion.scene.mesh.rest_positions.reshaped();
  motion.scene.initial_velocities = Eigen::VectorXd::Zero(12);
  motion.times = Eigen::VectorXd(4);
  motion.times << 2.0, 2.3, 2.325, 3.0;
  for (int node = 0; node < 4; ++node) {
    ObservedPoint point;
    point.nodes[0] = node;
    motion.points.push_back(point);
  }
  ObservedPoint inside;
  inside.num_nodes = 3;
  for (int k = 0; k < 3; ++k) {
    inside.nodes[k] = k + 1;
    inside.weights[k] = 0.2 + 0.1 * k;
  }
  inside.weights[0] = 1.0 - inside.weights[1] - inside.weights[2];
  motion.points.push_back(inside);
  std::srand(1);
  motion.positions = Eigen::MatrixXd::Random(15, 4);
  return motion;
}

// A trajectory of arbitrary positions.
Rollout MakeRollout() {
  std::srand(2);
  Rollout rollout;
  rollout.initial_positions = Eigen::VectorXd::Random(12);
  for (int step = 0; step < kNumSteps; ++step) {
    StepRecord record;
    record.positions = Eigen::VectorXd::Random(12);
    rollout.records.push_back(record);
    rollout.last_record.push_back(step);
  }
  return rollout;
}

TEST(ObservationTest, PredictsNodesLinearlyInTime) {
  const Observation observation(MakeMotion());
  const Rollout rollout = MakeRollout();
  EXPECT_EQ(observation.num_steps(), kNumSteps);
  const Eigen::MatrixXd predicted = observation.Predict(rollout);
  EXPECT_EQ(predicted.col(0).head(12), rollout.initial_positions);
  EXPECT_TRUE(predicted.col(1).head(12).isApprox(rollout.positions(3), 1e-15));
  const Eigen::VectorXd between = 0.75 * rollout.positions(3) + 0.25 * rollout.positions(4);
  EXPECT_TRUE(predicted.col(2).head(12).isApprox(between, 1e-12));
  EXPECT_EQ(predicted.col(3).head(12), rollout.positions(10));
}

TEST(ObservationTest, PredictsPointsOnTriangles) {
  const RecordedMotion motion = MakeMotion();
  const Eigen::MatrixXd predicted = Observation(motion).Predict(MakeRollout());
  Eigen::Vector3d expected = Eigen::Vector3d::Zero();
  for (int k = 0; k < 3; ++k) {
    expected += motion.points[4].weights[k] * predicted.block<3, 1>(3 * motion.points[4].nodes[k], 2);
  }
  EXPECT_TRUE((predicted.block<3, 1>(12, 2)).isApprox(expected, 1e-14));
}

TEST(ObservationTest, LeavesOutWhatIsNotSeenAndHandles) {
  RecordedMotion motion = MakeMotion();
  motion.scene.handles.nodes = {1, 2, 3};  // the point on the triangle hangs on handles alone
  motion.positions(2, 1) = kNaN;
  const Observation observation(motion);
  EXPECT_EQ(observation.num_residuals(), 3 * 4 - 1);
  for (const SeenCoordinate& seen : observation.coordinates()) {
    EXPECT_EQ(seen.point, 0);
    EXPECT_FALSE(seen.frame == 1 && seen.axis == 2);
  }
  EXPECT_EQ(observation.first_row(2) - observation.first_row(1), 2);
  EXPECT_TRUE(observation.Residuals(observation.Predict(MakeRollout())).allFinite());
}

TEST(ObservationTest, WhitensBySigma) {
  RecordedMotion motion = MakeMotion();
  const Eigen::MatrixXd predicted = motion.positions.array() + 0.01;
  const Observation without(motion);
  EXPECT_FALSE(without.sigma_is_known());
  EXPECT_NEAR(without.sigma(0), 1e-3 * 0.5, 1e-18);  // the rest area is 0.25 m^2
  EXPECT_TRUE(without.Residuals(predicted).isApproxToConstant(0.01 / 5e-4, 1e-9));

  motion.sigma = Eigen::VectorXd::LinSpaced(5, 0.1, 0.5);
  const Observation with(motion);
  EXPECT_TRUE(with.sigma_is_known());
  const Eigen::VectorXd residuals = with.Residuals(predicted);
  EXPECT_NEAR(residuals[0], 0.01 / 0.1, 1e-12);
  EXPECT_NEAR(residuals[14], 0.01 / 0.5, 1e-12);
}

TEST(ObservationTest, SeedsAreTheTranspose) {
  RecordedMotion motion = MakeMotion();
  motion.positions(4, 2) = kNaN;
  motion.scene.handles.nodes = {3};
  const Observation observation(motion);
  const Rollout rollout = MakeRollout();
  const Eigen::MatrixXd seeds = Eigen::MatrixXd::Random(observation.num_residuals(), 2);
  const Eigen::VectorXd forward = seeds.transpose() * observation.Whiten(observation.Predict(rollout));
  const ResidualDerivative derivative(&observation, observation.Predict(rollout));
  Eigen::VectorXd backward = Eigen::VectorXd::Zero(2);
  for (int step = 0; step <= kNumSteps; ++step) {
    Eigen::MatrixXd gradient = Eigen::MatrixXd::Zero(12, 2);
    const auto [first, end] = FramesAt(step, observation.stencils());
    for (int frame = first; frame < end; ++frame) {
      derivative.AddFrameSeeds(frame, observation.stencils()[frame].weight(step), seeds, &gradient);
    }
    backward += gradient.transpose() * rollout.positions(step);
  }
  EXPECT_TRUE(backward.isApprox(forward, 1e-12)) << backward.transpose() << " != " << forward.transpose();
}

TEST(ObservationTest, SamplerGivesThePredictionStepByStep) {
  const Observation observation(MakeMotion());
  const Rollout rollout = MakeRollout();
  const Eigen::MatrixXd predicted = observation.Predict(rollout);
  int num_frames = 0;
  FrameSampler sampler(&observation.stencils(), [&](int frame, const FrameStates& states) {
    EXPECT_EQ(frame, num_frames++);
    const Eigen::MatrixXd points = observation.PointsAt(observation.stencils()[frame], states);
    EXPECT_EQ(points.col(0), predicted.col(frame));
    EXPECT_TRUE(points.col(1).isApprox(-2.0 * predicted.col(frame), 1e-14));
    const Eigen::MatrixXd whitened = observation.WhitenFrame(frame, points);
    EXPECT_EQ(whitened.col(0), observation.Whiten(predicted).segment(observation.first_row(frame), whitened.rows()));
  });
  for (int step = 0; step <= kNumSteps; ++step) {
    Eigen::MatrixXd state(12, 2);
    state << rollout.positions(step), -2.0 * rollout.positions(step);
    sampler.AddStep(step, state);
  }
  EXPECT_EQ(num_frames, observation.num_frames());
}

TEST(ObservationTest, ComparesInMetres) {
  const RecordedMotion motion = MakeMotion();
  const Observation observation(motion);
  EXPECT_EQ(observation.Compare(motion.positions).rmse(), 0.0);
  EXPECT_EQ(observation.Compare(motion.positions).fit_percent(), 100.0);
  Eigen::MatrixXd shifted = motion.positions;
  for (int p = 0; p < motion.num_points(); ++p) shifted.row(3 * p + 1).array() += 0.02;
  EXPECT_NEAR(observation.Compare(shifted).rmse(), 0.02, 1e-15);
  // Predicting the mean explains nothing of the motion.
  const Eigen::MatrixXd mean = motion.positions.rowwise().mean().replicate(1, motion.num_frames());
  EXPECT_NEAR(observation.Compare(mean).fit_percent(), 0.0, 1e-10);
  // An error that lasts is correlated with itself, one that changes its sign at every frame is the opposite.
  EXPECT_NEAR(observation.Compare(shifted).autocorrelation(), 1.0, 1e-12);
  Eigen::MatrixXd alternating = motion.positions;
  for (int i = 0; i < motion.num_frames(); ++i) alternating.col(i).array() += i % 2 == 0 ? 0.01 : -0.01;
  EXPECT_NEAR(observation.Compare(alternating).autocorrelation(), -1.0, 1e-12);
  EXPECT_TRUE(std::isnan(observation.Compare(motion.positions).autocorrelation()));
  // Errors of recordings add up by their number of coordinates.
  PredictionError sum = observation.Compare(shifted);
  sum += observation.Compare(motion.positions);
  EXPECT_NEAR(sum.rmse(), 0.02 / std::sqrt(2.0), 1e-15);
}

TEST(ObservationTest, RefusesWhatCannotBeFitted) {
  RecordedMotion early = MakeMotion();
  early.times[0] = 1.9;
  ExpectError([&] { Observation{early}; }, ErrorKind::kBadData, {"test.bin", "times[0]"});
  RecordedMotion unseen = MakeMotion();
  unseen.positions.setConstant(kNaN);
  ExpectError([&] { Observation{unseen}; }, ErrorKind::kBadData, {"test.bin", "positions"});
  RecordedMotion held = MakeMotion();
  held.scene.handles.nodes = {0, 1, 2, 3};
  ExpectError([&] { Observation{held}; }, ErrorKind::kBadData, {"test.bin", "positions"});
  for (double sigma : {0.0, -1.0, kNaN, std::numeric_limits<double>::infinity()}) {
    RecordedMotion unsure = MakeMotion();
    unsure.sigma = Eigen::VectorXd::Constant(5, 1.0);
    unsure.sigma[3] = sigma;
    ExpectError([&] { Observation{unsure}; }, ErrorKind::kBadData, {"test.bin", "sigma[3]"});
  }
}

}  // namespace
}  // namespace clothid::observation_test
