#include "sim/obstacle/shape_checks.h"

#include <cmath>

#include "sim/base/error.h"

namespace clothid {

double CheckedLength(double length, const char* message) {
  if (!(length > 0.0) || !std::isfinite(length)) throw Error(ErrorKind::kBadData, message);
  return length;
}

Eigen::Vector3d CheckedPoint(const Eigen::Vector3d& point) {
  if (!point.allFinite()) throw Error(ErrorKind::kBadData, "an obstacle's position must be finite");
  return point;
}

Eigen::Vector3d CheckedDirection(const Eigen::Vector3d& direction, const char* message) {
  return direction / CheckedLength(direction.stableNorm(), message);
}

}  // namespace clothid
