// The axes of its own in which the formulas of a shape are written.
#ifndef CLOTHID_SIM_OBSTACLE_SHAPE_FRAME_H_
#define CLOTHID_SIM_OBSTACLE_SHAPE_FRAME_H_

#include <Eigen/Core>

#include "sim/obstacle/obstacle.h"

namespace clothid {

struct ShapeFrame {
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();    // m
  Eigen::Matrix3d axes = Eigen::Matrix3d::Identity();  // in columns, orthonormal

  // The third axis is the unit vector `axis`; the others lie anywhere across it.
  static ShapeFrame About(const Eigen::Vector3d& origin, const Eigen::Vector3d& axis);

  Eigen::Vector3d ToLocal(const Eigen::Vector3d& position) const { return axes.transpose() * (position - origin); }
  SurfacePoint ToWorld(const SurfacePoint& local) const;
};

}  // namespace clothid

#endif  // CLOTHID_SIM_OBSTACLE_SHAPE_FRAME_H_
