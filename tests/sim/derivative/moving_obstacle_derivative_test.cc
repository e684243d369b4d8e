// adjoint = sensitivity = central finite differences on obstacles that move, for the placement of their paths as well.
#include <gtest/gtest.h>

#include <Eigen/Core>
#include <cmath>
#include <memory>

#include "sim/obstacle/obstacle.h"
#include "tests/sim/derivative/moving_obstacle_case.h"
#include "tests/sim/moving_paths.h"

namespace clothid::moving_obstacle_derivative_test {
namespace {

Eigen::Vector3d Wander(double t) { return {0.1 * std::sin(5.0 * t), 0.05 * t, 0.08 * (1.0 - std::cos(7.0 * t))}; }
Eigen::Vector3d Tumble(double t) { return {0.8 * std::sin(4.0 * t), 2.0 * t, -0.5 * t}; }

// `drape` or `slope`, whose obstacle moves about where it is: it wanders and tumbles about its own centre.
Scene MovingScene(const MovingObstacleParam& param) {
  Scene scene = MovingObstacleScene(param, 9);
  SceneObstacle& obstacle = scene.obstacles[0];
  if (const auto* ball = dynamic_cast<const Sphere*>(obstacle.shape.get())) {
    const Eigen::Vector3d centre = ball->center();
    obstacle.shape =
        std::make_shared<Capsule>(Eigen::Vector3d(-0.05, 0.0, 0.0), Eigen::Vector3d(0.05, 0.02, 0.0), ball->radius());
    obstacle.path = PathThrough(
        0.0, 1.0, 51, [=](double t) { return Eigen::Vector3d(centre + Wander(t)); }, Tumble);
  } else {
    obstacle.path = PathThrough(0.0, 1.0, 51, Wander, [](double t) { return Eigen::Vector3d(0.1 * Tumble(t)); });
  }
  return scene;
}

class MovingObstacleDerivativeTest : public testing::TestWithParam<MovingObstacleParam> {};

TEST_P(MovingObstacleDerivativeTest, AdjointEqualsSensitivityEqualsDifferences) {
  ExpectMovingObstacleAgreement(MovingScene(GetParam()), GetParam());
}

INSTANTIATE_TEST_SUITE_P(Scenes, MovingObstacleDerivativeTest, MovingObstacleParams(), MovingObstacleName);

}  // namespace
}  // namespace clothid::moving_obstacle_derivative_test
