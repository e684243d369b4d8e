// A cloth that is curved at rest.
#ifndef CLOTHID_TESTS_SIM_CURVED_REST_H_
#define CLOTHID_TESTS_SIM_CURVED_REST_H_

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "sim/scene/scene.h"

namespace clothid {

// `scene` with its flat mesh bent to a parabola along the first edge, from which it starts, and bending by patches.
inline Scene CurvedAtRest(Scene scene) {
  Eigen::Matrix3Xd& rest = scene.mesh.rest_positions;
  const Eigen::Vector3i face = scene.mesh.faces.col(0);
  const Eigen::Vector3d first = (rest.col(face[1]) - rest.col(face[0])).normalized();
  const Eigen::Vector3d normal = first.cross(rest.col(face[2]) - rest.col(face[0])).normalized();
  const Eigen::Vector3d middle = rest.rowwise().mean();
  const double curvature = 0.5 / ClothSize(scene.mesh);
  for (auto x : rest.colwise()) {
    const double along = first.dot(x - middle);
    x += 0.5 * curvature * along * along * normal;
  }
  scene.initial_positions = rest.reshaped();
  scene.bending.law = BendingLaw::kPatches;
  scene.bending.poisson = 0.2;
  return scene;
}

}  // namespace clothid

#endif  // CLOTHID_TESTS_SIM_CURVED_REST_H_
