// adjoint = sensitivity = central finite differences on obstacles that move, for the placement of their paths as well.
#include <gtest/gtest.h>

#include <Eigen/Core>
#include <cmath>
#include <memory>
#include <string>
#include <tuple>

#include "sim/obstacle/obstacle.h"
#include "tests/sim/derivative/gradient_case.h"
#include "tests/sim/moving_paths.h"
#include "tests/sim/shipped_scenes.h"

namespace clothid::moving_obstacle_derivative_test {
namespace {

using Param = std::tuple<std::string, ContactMode, Integrator>;

Eigen::Vector3d Wander(double t) { return {0.1 * std::sin(5.0 * t), 0.05 * t, 0.08 * (1.0 - std::cos(7.0 * t))}; }
Eigen::Vector3d Tumble(double t) { return {0.8 * std::sin(4.0 * t), 2.0 * t, -0.5 * t}; }

// `drape` or `slope`, whose obstacle moves about where it is: it wanders and tumbles about its own centre.
Scene MovingScene(const Param& param, int nodes) {
  Scene scene = ShippedScene(std::get<0>(param), nodes);
  scene.contact_mode = std::get<1>(param);
  scene.integrator = std::get<2>(param);
  scene.duration = std::min(scene.duration, 0.4);
  scene.solver.adjoint_tolerance = 1e-14;  // on the plane k_bend moves so little that 1e-12 shows
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

// Away from where placements are zero, so that nothing vanishes by chance.
Parameters Placed(const Scene& scene) {
  Parameters parameters = scene.nominal_parameters();
  parameters.placements = {{0.004, {0.002, -0.003, 0.001}, {0.05, -0.02, 0.03}}};
  return parameters;
}

class MovingObstacleDerivativeTest : public testing::TestWithParam<Param> {};

TEST_P(MovingObstacleDerivativeTest, AdjointEqualsSensitivityEqualsDifferences) {
  const Scene scene = MovingScene(GetParam(), 9);
  const GradientCase gradient(scene, Placed(scene));
  const std::string name = scene.obstacles[0].name;
  for (const char* part : {".time_offset", ".shift.x", ".shift.y", ".shift.z", ".turn.x", ".turn.y", ".turn.z"}) {
    EXPECT_TRUE(gradient.HasInfluence(name + part)) << part;
  }
  EXPECT_TRUE(gradient.HasInfluence("mu"));
  ExpectAgreement(gradient, std::get<0>(GetParam()) == "drape" ? 1e-5 : 1e-6);
}

INSTANTIATE_TEST_SUITE_P(Scenes, MovingObstacleDerivativeTest,
                         testing::Combine(testing::Values("drape", "slope"),
                                          testing::Values(ContactMode::kGap, ContactMode::kVelocity),
                                          testing::Values(Integrator::kEuler, Integrator::kSdirk2)),
                         [](const auto& test) {
                           return std::get<0>(test.param) +
                                  (std::get<1>(test.param) == ContactMode::kGap ? "Gap" : "Velocity") +
                                  IntegratorName(std::get<2>(test.param));
                         });

}  // namespace
}  // namespace clothid::moving_obstacle_derivative_test
