#include "sim/path/rigid_path.h"

#include <array>
#include <cmath>
#include <string>

#include "sim/base/row_error.h"
#include "sim/path/hermite.h"
#include "sim/path/rotation_vector.h"

namespace clothid {
namespace {

constexpr double kLengthError = 0.01;  // of a quaternion

[[noreturn]] void FailOnRow(Eigen::Index row, const std::string& message) {
  throw RowError(row, "row " + std::to_string(row) + ": " + message);
}

void ValidateRows(const Eigen::VectorXd& times, const Eigen::Matrix3Xd& positions, const Eigen::Matrix4Xd& rotations) {
  if (times.size() == 0 || positions.cols() != times.size() || rotations.cols() != times.size()) {
    throw Error(ErrorKind::kBadData, "expected at least one pose, and a position and a rotation at each time");
  }
  for (Eigen::Index i = 0; i < times.size(); ++i) {
    if (!std::isfinite(times[i]) || (i > 0 && !(times[i] > times[i - 1]))) {
      FailOnRow(i, "expected a finite time above the one before it");
    }
    if (!positions.col(i).allFinite()) FailOnRow(i, "expected a finite position");
    if (!(std::abs(rotations.col(i).norm() - 1.0) <= kLengthError)) {
      FailOnRow(
          i, "expected a quaternion qx, qy, qz, qw of length 1, and it has " + std::to_string(rotations.col(i).norm()));
    }
  }
}

// The sign of a rotation that is the nearer one to that before it.
Eigen::Matrix4Xd Aligned(const Eigen::Matrix4Xd& rotations) {
  Eigen::Matrix4Xd aligned = rotations.colwise().normalized();
  for (Eigen::Index i = 1; i < aligned.cols(); ++i) {
    if (aligned.col(i).dot(aligned.col(i - 1)) < 0.0) aligned.col(i) *= -1.0;
  }
  return aligned;
}

// How a factor exp(w b) of a product of rotations moves it: a = w db/ds and da/ds.
struct Factor {
  Eigen::Matrix3d rotation;
  Eigen::Vector3d rate, acceleration;

  Factor(const Eigen::Vector3d& vector, double share, double share_rate, double share_acceleration)
      : rotation(ExponentialOf(share * vector)), rate(share_rate * vector), acceleration(share_acceleration * vector) {}
};

}  // namespace

RigidPath::RigidPath(const Eigen::VectorXd& times, const Eigen::Matrix3Xd& positions, const Eigen::Matrix4Xd& rotations)
    : times_(times), positions_(positions) {
  ValidateRows(times, positions, rotations);
  slopes_ = ParabolaSlopes(times_, positions_);
  rotations_ = Aligned(rotations);
  // Slopes of a curve whose steps are the turns from row to row.
  Eigen::MatrixXd turned = Eigen::MatrixXd::Zero(3, times.size());
  for (Eigen::Index i = 1; i < times.size(); ++i) {
    const Eigen::Vector3d turn = LogarithmOf(Rotation(i - 1).conjugate() * Rotation(i));
    if (turn.norm() > kMostPathTurn) {
      FailOnRow(i, "the path jumps: it turns by " + std::to_string(turn.norm()) +
                       " rad from the row before; expected " + "at most " + std::to_string(kMostPathTurn));
    }
    const double speed = (positions_.col(i) - positions_.col(i - 1)).norm() / (times[i] - times[i - 1]);
    if (!(speed <= kMostPathSpeed)) {
      FailOnRow(i, "the path jumps: it has a speed of " + std::to_string(speed) +
                       " m/s from the row before; expected " + "at most " + std::to_string(kMostPathSpeed));
    }
    turned.col(i) = turned.col(i - 1) + turn;
  }
  angular_slopes_ = ParabolaSlopes(times_, turned);
}

PoseJet RigidPath::At(double time) const {
  PoseJet jet;
  jet.pose.col(3) = HermiteValue(times_, positions_, slopes_, time);
  jet.rate.col(3) = HermiteRate(times_, positions_, slopes_, time);
  jet.acceleration.col(3) = HermiteAcceleration(times_, positions_, slopes_, time);
  SetRotationAt(time, &jet);
  return jet;
}

// With P = E_1 E_2 E_3 and a_j = w_j db_j/ds, dP/ds = P [u_3]x, where u_1 = a_1 and u_{j+1} = E_{j+1}^T u_j + a_{j+1}.
void RigidPath::SetRotationAt(double time, PoseJet* jet) const {
  const Eigen::Index i = IntervalAt(times_, time);
  if (i < 0 || i + 1 >= times_.size()) {
    jet->pose.leftCols<3>() = Rotation(i < 0 ? 0 : i).toRotationMatrix();
    return;
  }
  const double interval = times_[i + 1] - times_[i], s = (time - times_[i]) / interval, r = 1.0 - s;
  const Eigen::Vector3d first = angular_slopes_.col(i) * (interval / 3.0);
  const Eigen::Vector3d third = angular_slopes_.col(i + 1) * (interval / 3.0);
  const Eigen::Vector3d second =
      LogarithmOf(ExponentialOf(-first) * Rotation(i).conjugate() * Rotation(i + 1) * ExponentialOf(-third));
  const std::array<Factor, 3> factors = {Factor(first, 1.0 - r * r * r, 3.0 * r * r, -6.0 * r),
                                         Factor(second, s * s * (3.0 - 2.0 * s), 6.0 * s * r, 6.0 - 12.0 * s),
                                         Factor(third, s * s * s, 3.0 * s * s, 6.0 * s)};
  Eigen::Matrix3d rotation = Rotation(i).toRotationMatrix();
  Eigen::Vector3d rate = Eigen::Vector3d::Zero(), acceleration = Eigen::Vector3d::Zero();
  for (const Factor& factor : factors) {
    rotation *= factor.rotation;
    const Eigen::Vector3d carried = factor.rotation.transpose() * rate;
    acceleration = factor.rotation.transpose() * acceleration - factor.rate.cross(carried) + factor.acceleration;
    rate = carried + factor.rate;
  }
  const Eigen::Matrix3d spin = CrossMatrix(rate / interval);
  jet->pose.leftCols<3>() = rotation;
  jet->rate.leftCols<3>() = rotation * spin;
  jet->acceleration.leftCols<3>() = rotation * (spin * spin + CrossMatrix(acceleration / (interval * interval)));
}

}  // namespace clothid
