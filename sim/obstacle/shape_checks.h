// Checks of the numbers that shapes are made of.
#ifndef CLOTHID_SIM_OBSTACLE_SHAPE_CHECKS_H_
#define CLOTHID_SIM_OBSTACLE_SHAPE_CHECKS_H_

#include <Eigen/Core>

namespace clothid {

// Nearer to a centre, an axis or an edge than this share of a shape's size there is no direction to speak of.
inline constexpr double kSingular = 1e-12;

// The argument where it is what a shape can be made of. Throw `Error` (kBadData): `message` is all that it says.
double CheckedLength(double length, const char* message);  // m, > 0, finite
Eigen::Vector3d CheckedPoint(const Eigen::Vector3d& point);
Eigen::Vector3d CheckedDirection(const Eigen::Vector3d& direction, const char* message);  // normalised

}  // namespace clothid

#endif  // CLOTHID_SIM_OBSTACLE_SHAPE_CHECKS_H_
