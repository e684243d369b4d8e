// Paths of rigid bodies: what lies between their rows, how fast, and how a placement moves them.
#include "sim/path/rigid_path.h"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <string>

#include "sim/path/number_table.h"
#include "sim/path/placement.h"
#include "sim/path/pose_csv.h"
#include "sim/path/rotation_vector.h"
#include "tests/expect_error.h"
#include "tests/temporary_folder.h"

namespace clothid {
namespace {

const Eigen::Vector3d kAxis = Eigen::Vector3d(0.3, -0.5, 0.8).normalized();

Eigen::Vector4d Coefficients(const Eigen::Quaterniond& rotation) { return rotation.coeffs(); }

// Poses at uneven times of a body that turns about `kAxis` by `angle(t)` and whose origin is at `place(t)`.
template <typename Angle, typename Place>
RigidPath Sampled(const Angle& angle, const Place& place, int count) {
  Eigen::VectorXd times(count);
  Eigen::Matrix3Xd positions(3, count);
  Eigen::Matrix4Xd rotations(4, count);
  for (int i = 0; i < count; ++i) {
    times[i] = 0.1 * i + 0.02 * std::sin(3.0 * i);
    positions.col(i) = place(times[i]);
    rotations.col(i) = (i % 3 == 1 ? -1.0 : 1.0) * Coefficients(ExponentialOf(angle(times[i]) * kAxis));
  }
  return RigidPath(times, positions, rotations);
}

// A path that turns about changing axes.
RigidPath Tumbling() {
  const int count = 12;
  Eigen::VectorXd times(count);
  Eigen::Matrix3Xd positions(3, count);
  Eigen::Matrix4Xd rotations(4, count);
  for (int i = 0; i < count; ++i) {
    const double t = times[i] = 0.05 * i + 0.01 * std::sin(2.0 * i);
    positions.col(i) << 0.2 * std::sin(3.0 * t), 0.1 * std::cos(5.0 * t), 0.3 * t * t;
    rotations.col(i) = Coefficients(ExponentialOf({2.0 * t, std::sin(4.0 * t), -0.5 * t}) * ExponentialOf({0, t, 0}));
  }
  return RigidPath(times, positions, rotations);
}

TEST(RigidPathTest, ASteadyMotionIsMetExactly) {
  const Eigen::Vector3d velocity(0.4, -0.1, 0.2);
  const RigidPath path =
      Sampled([](double t) { return 3.0 * t; }, [&](double t) { return Eigen::Vector3d(t * velocity); }, 8);
  for (double t = 0.01; t < 0.6; t += 0.013) {
    const PoseJet jet = path.At(t);
    const Eigen::Matrix3d rotation = ExponentialOf(3.0 * t * kAxis).toRotationMatrix();
    EXPECT_LE((jet.pose.leftCols<3>() - rotation).norm(), 1e-13) << t;
    EXPECT_LE((jet.rate.leftCols<3>() - CrossMatrix(3.0 * kAxis) * rotation).norm(), 1e-12) << t;
    EXPECT_LE(jet.acceleration.leftCols<3>().norm() - 9.0 * std::sqrt(2.0), 1e-10) << t;
    EXPECT_LE((jet.pose.col(3) - t * velocity).norm() + (jet.rate.col(3) - velocity).norm(), 1e-13) << t;
  }
}

TEST(RigidPathTest, PassesThroughItsRowsAndStandsStillOutside) {
  const RigidPath path = Tumbling();
  for (Eigen::Index i = 0; i < path.times().size(); ++i) {
    const PoseJet jet = path.At(path.times()[i]);
    EXPECT_LE((jet.pose.col(3) - path.positions().col(i)).norm(), 1e-14);
    const Eigen::Quaterniond rotation(Eigen::Vector4d(path.rotations().col(i)));
    EXPECT_LE((jet.pose.leftCols<3>() - rotation.toRotationMatrix()).norm(), 1e-13);
  }
  for (const double t : {path.times()[0] - 0.1, path.times().tail(1)[0] + 0.1}) {
    EXPECT_EQ(path.At(t).rate, AffineMap(AffineMap::Zero()));
    EXPECT_EQ(path.At(t).acceleration, AffineMap(AffineMap::Zero()));
  }
}

TEST(RigidPathTest, RatesAreDerivativesAndDoNotJump) {
  const RigidPath path = Tumbling();
  constexpr double kStep = 1e-5;
  for (double t = path.times()[0] + 0.004; t < path.times().tail(1)[0]; t += 0.0173) {
    const PoseJet plus = path.At(t + kStep), minus = path.At(t - kStep), jet = path.At(t);
    EXPECT_LE(((plus.pose - minus.pose) / (2.0 * kStep) - jet.rate).norm(), 1e-7 * (1.0 + jet.rate.norm())) << t;
    EXPECT_LE(((plus.rate - minus.rate) / (2.0 * kStep) - jet.acceleration).norm(),
              1e-6 * (1.0 + jet.acceleration.norm()))
        << t;
  }
  for (Eigen::Index i = 1; i + 1 < path.times().size(); ++i) {
    const double t = path.times()[i];
    EXPECT_LE((path.At(t).rate - path.At(t - 1e-12).rate).norm(), 1e-9) << i;
  }
}

TEST(RigidPathTest, RefusesWhatIsNone) {
  const Eigen::Vector2d times(0.0, 0.1);
  const Eigen::Matrix3Xd still = Eigen::Matrix3Xd::Zero(3, 2);
  Eigen::Matrix4Xd rotations = Eigen::Vector4d::UnitW().replicate(1, 2);
  const auto expect = [&](const Eigen::VectorXd& t, const Eigen::Matrix3Xd& x, const char* message) {
    ExpectError([&] { RigidPath(t, x, rotations); }, ErrorKind::kBadData, {message});
  };
  expect(Eigen::Vector2d(0.1, 0.1), still, "row 1: expected a finite time above the one before it");
  Eigen::Matrix3Xd far = still;
  far(0, 1) = 6.0;
  expect(times, far, "row 1: the path jumps: it has a speed of 60");
  rotations.col(1) *= 2.0;
  expect(times, still, "row 1: expected a quaternion");
  rotations.col(1) = Coefficients(ExponentialOf({2.0, 0.0, 0.0}));
  expect(times, still, "row 1: the path jumps: it turns by 2");
}

TEST(RigidPathTest, IsReadFromItsOwnText) {
  const TemporaryFolder folder;
  const std::string name = folder.File("path.csv");
  const RigidPath path = Tumbling();
  std::ofstream(name) << NumberTable("time,x,y,z,qx,qy,qz,qw", TableOfPath(path));
  const RigidPath read = ReadPoseCsv(name);
  EXPECT_EQ(read.times(), path.times());
  EXPECT_EQ(read.positions(), path.positions());
  EXPECT_LE((read.rotations() - path.rotations()).norm(), 1e-15);
  std::ofstream(name) << "time,x,y,z\n0,0,0,0\n";
  ExpectError([&] { ReadPoseCsv(name); }, ErrorKind::kBadData, {"path.csv:1: column 'qx'", "as in 'time,x,y,z,qx,qy,qz,qw'"});
  std::ofstream(name) << "time,x,y,z,qx,qy,qz,qw\n\n0,0,0,0,0,0,0,1\n1,900,0,0,0,0,0,1\n";
  ExpectError([&] { ReadPoseCsv(name); }, ErrorKind::kBadData, {"path.csv:4: row 1: the path jumps"});
}

TEST(PlacementTest, MovesThePathAsItSays) {
  const RigidPath path = Tumbling();
  Placement placement;
  placement.shift << 0.01, 0.02, -0.03;
  EXPECT_LE((PlacedPose(path, placement, 0.2).pose.col(3) - path.At(0.2).pose.col(3) - placement.shift).norm(), 1e-15);
  placement = {};
  placement.turn << 0.1, -0.2, 0.3;
  const AffineMap first = PlacedPose(path, placement, path.times()[0]).pose;  // about its first place
  EXPECT_LE((first.col(3) - path.positions().col(0)).norm(), 1e-15);
  placement = {};
  placement.time_offset = 0.05;
  EXPECT_EQ(PlacedPose(path, placement, 0.2).pose, path.At(0.25).pose);
}

TEST(PlacementTest, ChangesAreDerivatives) {
  const RigidPath path = Tumbling();
  Placement placement{0.013, {0.01, -0.02, 0.03}, {0.4, -0.3, 0.2}};
  double* const values[] = {&placement.time_offset, &placement.shift[0], &placement.shift[1], &placement.shift[2],
                            &placement.turn[0],     &placement.turn[1],  &placement.turn[2]};
  constexpr double kStep = 1e-6;
  for (int part = 0; part < 7; ++part) {
    const PoseJet change = PlacedPoseChange(path, placement, static_cast<PlacementPart>(part), 0.21);
    const double value = *values[part];
    *values[part] = value + kStep;
    const PoseJet plus = PlacedPose(path, placement, 0.21);
    *values[part] = value - kStep;
    const PoseJet minus = PlacedPose(path, placement, 0.21);
    *values[part] = value;
    EXPECT_LE(((plus.pose - minus.pose) / (2.0 * kStep) - change.pose).norm(), 1e-8) << part;
    EXPECT_LE(((plus.rate - minus.rate) / (2.0 * kStep) - change.rate).norm(), 1e-6) << part;
  }
}

}  // namespace
}  // namespace clothid
