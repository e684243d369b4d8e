#include "sim/obstacle/shape_frame.h"

#include <Eigen/Geometry>

namespace clothid {

ShapeFrame ShapeFrame::About(const Eigen::Vector3d& origin, const Eigen::Vector3d& axis) {
  ShapeFrame frame;
  frame.origin = origin;
  frame.axes.col(0) = axis.unitOrthogonal();
  frame.axes.col(1) = axis.cross(frame.axes.col(0));
  frame.axes.col(2) = axis;
  return frame;
}

SurfacePoint ShapeFrame::ToWorld(const SurfacePoint& local) const {
  SurfacePoint result;
  result.gap = local.gap;
  result.normal = axes * local.normal;
  result.normal_gradient = axes * local.normal_gradient * axes.transpose();
  return result;
}

}  // namespace clothid
