#include "sim/rollout/sized_scene.h"

#include "sim/scene/material_field.h"

namespace clothid {

Scene SizedScene(const Scene& scene, const std::array<double, 2>& size) {
  const Eigen::Matrix<double, 3, 2> axes = FrontAxes(scene.mesh, "size.x and size.y");
  Eigen::Matrix3d change = Eigen::Matrix3d::Zero();
  for (int i = 0; i < 2; ++i) change += (size[i] - 1.0) * axes.col(i) * axes.col(i).transpose();
  Scene sized = scene;
  if (scene.mesh.has_corner_rest()) {
    const Eigen::Vector2d middle = scene.mesh.corner_rest.rowwise().mean();
    Eigen::Matrix2Xd& places = sized.mesh.corner_rest;
    places += (change.topLeftCorner<2, 2>() * (places.colwise() - middle)).eval();
    return sized;
  }
  Eigen::Matrix3Xd& positions = sized.mesh.rest_positions;
  const Eigen::Vector3d middle = positions.rowwise().mean();
  positions += (change * (positions.colwise() - middle)).eval();
  return sized;
}

}  // namespace clothid
