// adjoint = sensitivity = central finite differences where the cloth touches itself.
#include <gtest/gtest.h>

#include <Eigen/Core>
#include <cmath>
#include <memory>

#include "sim/obstacle/obstacle.h"
#include "tests/sim/derivative/gradient_case.h"
#include "tests/sim/plain_scenes.h"
#include "tests/sim/self_contact_scenes.h"

namespace clothid::self_contact_derivative_test {
namespace {

class SelfContactDerivativeTest : public testing::TestWithParam<Integrator> {};

// The upper layer falls by a millimetre onto the lower one and slides off it.
Scene SlidingLayers(Integrator integrator) {
  Scene scene = LayersOnASlope(2, 0.44, 0.3, integrator, 0.005);
  for (int node = static_cast<int>(scene.handles.nodes.size()); node < scene.mesh.num_nodes(); ++node) {
    scene.initial_positions[3 * node + 2] += 0.001;
    scene.initial_velocities[3 * node] = 0.05;
  }
  scene.duration = 0.1;
  return scene;
}

TEST_P(SelfContactDerivativeTest, OfALayerThatFallsAndSlides) {
  const GradientCase gradient(SlidingLayers(GetParam()));
  EXPECT_TRUE(gradient.HasInfluence("mu.self"));
  ExpectAgreement(gradient, 1e-5);
}

// Two layers fall on a table: the lower one lies on it, the upper one on both.
TEST_P(SelfContactDerivativeTest, OfTwoLayersOnATable) {
  GridOptions lower = SquareGrid(6, 0.1), upper = SquareGrid(5, 0.1);
  lower.origin = {0.0, 0.0, 0.0005};
  upper.origin = {0.017, 0.011, 0.0042};
  Scene scene;
  scene.mesh = JoinedMesh({MakeGrid(lower), MakeGrid(upper)});
  scene.initial_positions = scene.mesh.rest_positions.reshaped();
  scene.initial_velocities = Eigen::VectorXd::Zero(scene.initial_positions.size());
  for (int node = 36; node < scene.mesh.num_nodes(); ++node) scene.initial_velocities[3 * node] = 0.2;
  scene.obstacles.push_back({"table", std::make_shared<Plane>(Eigen::Vector3d::Zero(), Eigen::Vector3d::UnitZ()), 0.2});
  scene.integrator = GetParam();
  scene.time_step = 0.005;
  scene.duration = 0.03;
  scene.material.bending_stiffness = 1e-5;
  scene.self_contact = SelfContact{0.4, 0.003};
  scene.solver.adjoint_tolerance = 1e-14;
  const GradientCase gradient(scene);
  EXPECT_TRUE(gradient.HasInfluence("mu.self"));
  EXPECT_TRUE(gradient.HasInfluence("mu"));
  ExpectAgreement(gradient, 1e-5);
}

INSTANTIATE_TEST_SUITE_P(Integrators, SelfContactDerivativeTest,
                         testing::Values(Integrator::kEuler, Integrator::kSdirk2),
                         [](const auto& test) { return IntegratorName(test.param); });

}  // namespace
}  // namespace clothid::self_contact_derivative_test
