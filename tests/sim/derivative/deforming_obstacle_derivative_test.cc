// adjoint = sensitivity = central finite differences on obstacles that deform, for the placement of their sequences as
// well.
#include <gtest/gtest.h>

#include <Eigen/Core>
#include <cmath>

#include "sim/matrix/dense.h"
#include "sim/obstacle/triangulated_surface.h"
#include "sim/path/rotation_vector.h"
#include "tests/sim/derivative/moving_obstacle_case.h"
#include "tests/sim/moving_surfaces.h"

namespace clothid::deforming_obstacle_derivative_test {
namespace {

using Eigen::Vector3d;

// Wanders, turns, and is bent and stretched by functions of the place.
Vector3d Bend(const Vector3d& p, double t) {
  const double swing = std::sin(5.0 * t);
  const Vector3d bent(p.x() + 0.4 * swing * p.y(), p.y() * (1.0 + 0.2 * swing) + 0.5 * swing * p.x() * p.x(),
                      p.z() + 0.3 * swing * p.x());
  return bent + Vector3d(0.1 * swing, 0.05 * t, 0.08 * (1.0 - std::cos(7.0 * t)));
}

// `drape` over a tilted cube with a contact distance, so that nodes slide over its edges and corners, or `slope` on the
// faces of a slab.
Scene DeformingScene(const MovingObstacleParam& param) {
  const bool is_drape = std::get<0>(param) == "drape";
  Scene scene = MovingObstacleScene(param, is_drape ? 11 : 9);
  SceneObstacle& obstacle = scene.obstacles[0];
  TriangleMesh mesh = is_drape ? CubeMesh(0.14) : SlabMesh(1.5, 0);
  Vector3d place = scene.obstacles[0].shape->Closest(Vector3d::Zero()).normal;
  Eigen::Matrix3d axes = ShortestTurn(Vector3d::UnitZ(), place);
  if (is_drape) {
    axes = ExponentialOf(Vector3d(0.24, 0.32, 0.04)).toRotationMatrix();
    place = Vector3d(0.03, 0.25, -0.35);
    obstacle.contact_distance = 0.02;
  } else {
    place *= -obstacle.shape->Closest(Vector3d::Zero()).gap;
  }
  const auto at = [&](const Vector3d& p, double t) -> Vector3d { return axes * Bend(p, t) + place; };
  Deform(mesh, -0.1, 0.9, 51, at, &obstacle);
  return scene;
}

class DeformingObstacleDerivativeTest : public testing::TestWithParam<MovingObstacleParam> {};

TEST_P(DeformingObstacleDerivativeTest, AdjointEqualsSensitivityEqualsDifferences) {
  ExpectMovingObstacleAgreement(DeformingScene(GetParam()), GetParam());
}

INSTANTIATE_TEST_SUITE_P(Scenes, DeformingObstacleDerivativeTest, MovingObstacleParams(), MovingObstacleName);

}  // namespace
}  // namespace clothid::deforming_obstacle_derivative_test
