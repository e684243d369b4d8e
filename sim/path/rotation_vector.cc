#include "sim/path/rotation_vector.h"

#include <cmath>

namespace clothid {
namespace {

// Below this angle the series of the coefficients are exact to rounding, which their closed forms are not.
constexpr double kSmallAngle = 1e-2;

// sin(a)/a, (1 - cos(a))/a^2 and (a - sin(a))/a^3.
struct Coefficients {
  double first = 1.0, second = 0.5, third = 1.0 / 6.0;
};

Coefficients CoefficientsOf(double angle) {
  const double square = angle * angle;
  if (angle < kSmallAngle) {
    return {1.0 - square / 6.0 * (1.0 - square / 20.0), 0.5 - square / 24.0 * (1.0 - square / 30.0),
            1.0 / 6.0 - square / 120.0 * (1.0 - square / 42.0)};
  }
  const double half_sine = std::sin(0.5 * angle);
  return {std::sin(angle) / angle, 2.0 * half_sine * half_sine / square, (angle - std::sin(angle)) / (angle * square)};
}

}  // namespace

Eigen::Matrix3d CrossMatrix(const Eigen::Vector3d& v) {
  Eigen::Matrix3d cross;
  cross << 0.0, -v[2], v[1], v[2], 0.0, -v[0], -v[1], v[0], 0.0;
  return cross;
}

RotationByVector::RotationByVector(const Eigen::Vector3d& vector) {
  const Coefficients coefficients = CoefficientsOf(vector.norm());
  const Eigen::Matrix3d cross = CrossMatrix(vector), square = cross * cross, identity = Eigen::Matrix3d::Identity();
  rotation = identity + coefficients.first * cross + coefficients.second * square;
  left_jacobian = identity + coefficients.second * cross + coefficients.third * square;
}

}  // namespace clothid
