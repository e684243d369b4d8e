// Clouds beside and without tracked points: rows, transpose, errors.
#include "datasets/observation/cloud_observation.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "datasets/observation/observation.h"
#include "datasets/observation/residual_derivative.h"
#include "tests/expect_error.h"

namespace clothid::cloud_observation_test {
namespace {

// A flat sheet of 3 x 3 nodes at rest, two nodes of which are tracked; frames on and between steps of 0.1 s. One frame
// has no cloud.
RecordedMotion MakeMotion(bool has_points) {
  RecordedMotion motion;
  motion.name = "test.bin";
  motion.scene.time_step = 0.1;
  motion.scene.mesh = MakeGrid({{3, 3}, {1.0, 1.0}});
  motion.scene.initial_positions = motion.scene.mesh.rest_positions.reshaped();
  motion.scene.initial_velocities = Eigen::VectorXd::Zero(27);
  motion.times = Eigen::Vector3d(0.0, 0.15, 0.2);
  if (has_points) {
    motion.points.resize(2);
    motion.points[1].nodes[0] = 8;
  }
  motion.positions = Eigen::MatrixXd::Constant(3 * motion.num_points(), 3, 0.5);
  motion.clouds = {Eigen::Matrix3Xd(3, 2), Eigen::Matrix3Xd(3, 0), Eigen::Matrix3Xd(3, 3)};
  motion.clouds[0] << 0.2, 0.7, 0.3, 0.6, 0.01, -0.02;
  motion.clouds[2] << 0.2, 0.7, 0.4, 0.3, 0.6, 0.9, 0.03, -0.02, 0.2;
  motion.cloud_sigma = 0.01;
  return motion;
}

// The sheet at rest, then crumpled.
Rollout MakeRollout(const Mesh& mesh) {
  std::srand(2);
  Rollout rollout;
  rollout.initial_positions = mesh.rest_positions.reshaped();
  for (int step = 0; step < 2; ++step) {
    StepRecord record;
    record.positions = rollout.initial_positions + 0.05 * Eigen::VectorXd::Random(27);
    rollout.records.push_back(record);
    rollout.last_record.push_back(step);
  }
  return rollout;
}

TEST(CloudObservationTest, PointsOfAFrameComeAfterItsTrackedOnes) {
  const RecordedMotion motion = MakeMotion(true);
  const Observation observation(motion);
  EXPECT_EQ(observation.num_residuals(), 3 * 6 + 5);
  EXPECT_EQ(observation.first_row(1), 8);
  EXPECT_EQ(observation.first_row(2), 14);
  EXPECT_EQ(observation.coordinates()[6].point, 2);
  EXPECT_EQ(observation.coordinates()[7].point, 3);
  EXPECT_EQ(observation.num_predicted(), 3 * (2 + 9));
  const Eigen::MatrixXd predicted = observation.Predict(MakeRollout(motion.scene.mesh));
  EXPECT_EQ(predicted.col(0).tail(27), motion.scene.mesh.rest_positions.reshaped());
  EXPECT_EQ(predicted.col(1).segment<3>(3), predicted.col(1).tail<3>());  // node 8
  const Eigen::VectorXd residuals = observation.Residuals(predicted);
  EXPECT_NEAR(residuals[6], 1.0, 1e-12);
  EXPECT_NEAR(residuals[7], -2.0, 1e-12);
}

TEST(CloudObservationTest, NodesAreInterpolatedInTimeAsPointsAre) {
  const RecordedMotion motion = MakeMotion(false);
  const Observation observation(motion);
  const Rollout rollout = MakeRollout(motion.scene.mesh);
  const Eigen::MatrixXd predicted = observation.Predict(rollout);
  EXPECT_EQ(predicted.rows(), 27);
  EXPECT_TRUE(predicted.col(1).isApprox(0.5 * (rollout.positions(1) + rollout.positions(2)), 1e-12));
}

TEST(CloudObservationTest, SeedsAreTheTransposeOfTheDerivative) {
  for (const bool has_points : {false, true}) {
    RecordedMotion motion = MakeMotion(has_points);
    motion.clouds[1] = motion.clouds[2];  // between two steps
    const Observation observation(motion);
    const Rollout rollout = MakeRollout(motion.scene.mesh);
    const Eigen::MatrixXd predicted = observation.Predict(rollout);
    std::srand(4);
    const Eigen::MatrixXd seeds = Eigen::MatrixXd::Random(observation.num_residuals(), 2);
    const Eigen::MatrixXd states = Eigen::MatrixXd::Random(27, 3);  // the change of every step
    Eigen::MatrixXd forward = Eigen::MatrixXd::Zero(2, 1), backward = forward;
    for (int i = 0; i < observation.num_frames(); ++i) {
      const FrameStencil& stencil = observation.stencils()[i];
      FrameStates own;
      for (int k = 0; k < stencil.size; ++k) own.emplace_back(states.col(stencil.first_step + k).data(), 27, 1);
      Eigen::MatrixXd columns(observation.num_predicted(), 2);
      columns << predicted.col(i), observation.PointsAt(stencil, own);
      Eigen::VectorXd residuals;
      Eigen::MatrixXd jacobian;
      observation.LinearizeFrame(i, columns, &residuals, &jacobian);
      const int first = observation.first_row(i);
      EXPECT_EQ(residuals, observation.Residuals(predicted).segment(first, residuals.size()));
      forward += seeds.middleRows(first, residuals.size()).transpose() * jacobian;
    }
    const ResidualDerivative derivative(&observation, predicted);
    for (int step = 0; step <= observation.num_steps(); ++step) {
      Eigen::MatrixXd gradient = Eigen::MatrixXd::Zero(27, 2);
      const auto [first, end] = FramesAt(step, observation.stencils());
      for (int frame = first; frame < end; ++frame) {
        derivative.AddFrameSeeds(frame, observation.stencils()[frame].weight(step), seeds, &gradient);
      }
      backward += gradient.transpose() * states.col(step);
    }
    EXPECT_LT((forward - backward).norm(), 1e-12 * forward.norm());
  }
}

void ExpectDerivativeIsDifference(const Observation& observation, const Eigen::MatrixXd& predicted,
                                  const ResidualDerivative& derivative) {
  std::srand(5);
  const double step = 1e-7;
  const Eigen::MatrixXd change = Eigen::MatrixXd::Random(predicted.rows(), predicted.cols());
  const Eigen::VectorXd difference =
      (observation.Residuals(predicted + step * change) - observation.Residuals(predicted - step * change)) /
      (2.0 * step);
  EXPECT_LT((derivative.Apply(change) - difference).norm(), 1e-6 * difference.norm());
}

// Whoever differentiates has said where: the rows of clouds come with the derivative, in every one of its forms.
TEST(CloudObservationTest, TheDerivativeIsThatAtItsPrediction) {
  for (const bool has_points : {false, true}) {
    const RecordedMotion motion = MakeMotion(has_points);
    const Observation observation(motion);
    const Eigen::MatrixXd predicted = observation.Predict(MakeRollout(motion.scene.mesh));
    const ResidualDerivative derivative(&observation, predicted);
    ExpectDerivativeIsDifference(observation, predicted, derivative);
    const Eigen::Vector3d shift(0.3, -0.5, 0.2);
    const Eigen::MatrixXd shifts = shift.replicate(predicted.rows() / 3, predicted.cols());
    const Eigen::VectorXd shifted = derivative.Apply(shifts);
    for (int row = 0; row < observation.num_residuals(); ++row) {
      EXPECT_NEAR(derivative.OfShift(row).dot(shift), shifted[row], 1e-12 * shifted.norm()) << row;
    }
  }
}

TEST(CloudObservationTest, ErrorsAreDistancesToTheSurface) {
  const RecordedMotion motion = MakeMotion(false);
  const Observation observation(motion);
  const Eigen::MatrixXd still = motion.scene.mesh.rest_positions.reshaped().replicate(1, 3);
  const PredictionError error = observation.Compare(still);
  EXPECT_EQ(error.cloud.num_points, 5.0);
  EXPECT_EQ(error.cloud.num_far, 1.0);  // 0.2 m are 20 sigma
  const double squares = 1e-4 + 4e-4 + 9e-4 + 4e-4 + 4e-2;
  EXPECT_NEAR(error.cloud.squared_distance, squares, 1e-14);
  EXPECT_NEAR(error.rmse(), std::sqrt(squares / 5.0), 1e-12);
  EXPECT_NEAR(error.rmse(), error.cloud.rmse(), 1e-15);
  EXPECT_TRUE(std::isnan(error.fit_percent()));
  EXPECT_GT(error.autocorrelation(), 0.0);  // at two nodes the sheet is off to the same side in both frames

  const Observation both(MakeMotion(true));
  const PredictionError sum = both.Compare(both.Predict(MakeRollout(motion.scene.mesh)));
  EXPECT_EQ(sum.num_coordinates, 18.0);
  EXPECT_NEAR(sum.rmse(), std::sqrt((sum.squared_error + sum.cloud.squared_distance) / (6.0 + 5.0)), 1e-14);
}

// The nodes of the sheet as another program saw them: one of the border, one of the surface, one a handle, one
// material.
RecordedMotion SlidingMotion() {
  RecordedMotion motion = MakeMotion(false);
  motion.clouds.clear();
  motion.cloud_sigma = 0.0;
  motion.scene.handles.nodes = {2};
  motion.points.resize(4);
  const int nodes[] = {1, 4, 2, 8};
  const PointKind kinds[] = {PointKind::kBorder, PointKind::kSurface, PointKind::kSurface, PointKind::kMaterial};
  for (int p = 0; p < 4; ++p) {
    motion.points[p].nodes[0] = nodes[p];
    motion.points[p].kind = kinds[p];
  }
  motion.sigma = Eigen::Vector4d(0.01, 0.02, 0.03, 0.04);
  motion.positions.resize(12, 3);
  for (int i = 0; i < 3; ++i) {
    motion.positions.col(i) << 0.45, -0.03, 0.02, 0.61, 0.52, -0.04, 0.3, 0.3, 0.3, 0.98, 1.01, 0.02;
  }
  motion.positions(3, 1) = std::numeric_limits<double>::quiet_NaN();
  return motion;
}

TEST(CloudObservationTest, PointsThatAreNotMaterialHaveDistances) {
  const RecordedMotion motion = SlidingMotion();
  const Observation observation(motion);
  EXPECT_TRUE(observation.sigma_is_known());
  EXPECT_EQ(observation.num_residuals(), 6 + 5 + 6);  // 3 of node 8, 2 of the border, 1 of the surface, but in frame 1
  EXPECT_EQ(observation.num_predicted(), 3 * (4 + 9));
  const Eigen::VectorXd still = motion.scene.mesh.rest_positions.reshaped();
  Eigen::MatrixXd predicted(39, 3);
  for (int i = 0; i < 3; ++i) {
    predicted.col(i) << still.segment<3>(3), still.segment<3>(12), still.segment<3>(6), still.segment<3>(24), still;
  }
  const Eigen::VectorXd residuals = observation.Residuals(predicted);
  EXPECT_NEAR(residuals[3], 2.0, 1e-12);  // height of the point of the border, though it is 3 sigma beyond
  EXPECT_NEAR(residuals[4], 3.0, 1e-12);  // along the cloth
  EXPECT_NEAR(residuals[5], -2.0, 1e-12);
  EXPECT_EQ(observation.sigma(observation.coordinates()[4]), 0.01);
  EXPECT_EQ(observation.sigma(observation.coordinates()[5]), 0.02);
  EXPECT_TRUE(observation.is_border_row(observation.coordinates()[4]));
  EXPECT_FALSE(observation.is_border_row(observation.coordinates()[3]));
  const PredictionError error = observation.Compare(predicted);
  EXPECT_EQ(error.num_coordinates, 9.0);
  EXPECT_EQ(error.cloud.num_points, 5.0);
  EXPECT_NEAR(error.cloud.squared_distance, 3 * 4e-4 + 2 * 16e-4, 1e-14);
  EXPECT_NEAR(error.cloud.border_rmse(), 0.03, 1e-12);
  const double border_node = 0.05 * 0.05 + 0.03 * 0.03 + 4e-4, inner_node = 0.11 * 0.11 + 4e-4 + 16e-4;
  EXPECT_NEAR(error.cloud.node_rmse(), std::sqrt((3 * border_node + 2 * inner_node) / 5.0), 1e-12);
}

TEST(CloudObservationTest, TheDerivativeOfPointsThatAreNotMaterialIsExact) {
  const RecordedMotion motion = SlidingMotion();
  const Observation observation(motion);
  const Eigen::MatrixXd predicted = observation.Predict(MakeRollout(motion.scene.mesh));
  ExpectDerivativeIsDifference(observation, predicted, ResidualDerivative(&observation, predicted));
}

TEST(CloudObservationTest, RefusesPointsOfABorderThatIsNotThere) {
  RecordedMotion motion = SlidingMotion();
  motion.scene.mesh.rest_positions = Eigen::Matrix3Xd::Zero(3, 9);
  motion.scene.mesh.rest_positions.leftCols(4) << 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1;
  motion.scene.mesh.rest_positions.rightCols(5) << 5, 6, 5, 5, 6, 0, 0, 1, 0, 0, 0, 0, 0, 1, 1;
  motion.scene.mesh.faces.resize(3, 10);
  motion.scene.mesh.faces << 0, 0, 0, 1, 4, 4, 4, 5, 5, 6, 1, 2, 3, 3, 6, 5, 7, 6, 8, 7, 2, 3, 1, 2, 5, 8, 6, 8, 7, 8;
  EXPECT_THROW(Observation{motion}, Error);
}

TEST(CloudObservationTest, SigmaIsKnownWhereItIsOfAllPoints) {
  RecordedMotion motion = MakeMotion(true);
  EXPECT_FALSE(Observation(motion).sigma_is_known());
  motion.sigma = Eigen::Vector2d(0.1, 0.2);
  EXPECT_TRUE(Observation(motion).sigma_is_known());
  motion.cloud_sigma = 0.0;
  EXPECT_FALSE(Observation(motion).sigma_is_known());
  EXPECT_NEAR(Observation(motion).clouds().cloud_sigma(), 1e-3, 1e-12);  // of the size of the cloth
  motion = MakeMotion(false);
  EXPECT_TRUE(Observation(motion).sigma_is_known());
}

TEST(CloudObservationTest, RefusesCloudsWithoutPoints) {
  RecordedMotion motion = MakeMotion(false);
  for (Eigen::Matrix3Xd& cloud : motion.clouds) cloud.resize(3, 0);
  ExpectError([&] { Observation{motion}; }, ErrorKind::kBadData, {"test.bin"});
}

}  // namespace
}  // namespace clothid::cloud_observation_test
