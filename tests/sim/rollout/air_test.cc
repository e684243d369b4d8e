// A cloth in the air against closed forms: terminal velocities, added mass, and the order of SDIRK2.
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "sim/rollout/rollout.h"
#include "sim/rollout/simulator.h"
#include "tests/sim/order_of_convergence.h"
#include "tests/sim/plain_scenes.h"
#include "tests/sim/shipped_scenes.h"

namespace clothid::air_test {
namespace {

constexpr double kGravity = 9.81;  // m/s^2
constexpr double kDensity = 0.2;   // kg/m^2

// The largest distance of a node's velocity after `step` steps from `velocity`.
double VelocityError(const Rollout& rollout, int step, const Eigen::Vector3d& velocity) {
  const Eigen::VectorXd& velocities = rollout.records[rollout.last_record[step - 1]].velocities;
  return (velocities.reshaped(3, velocities.size() / 3).colwise() - velocity).colwise().norm().maxCoeff();
}

// Falls flat, or on its edge.
Scene FallingScene(AirLaw law, bool flat) {
  GridOptions grid = SquareGrid(4, 0.3);
  if (!flat) grid.axes = {Eigen::Vector3d::UnitX(), Eigen::Vector3d::UnitZ()};
  Scene scene = ClothScene(grid, 0.01);
  scene.material.density = kDensity;
  scene.air_law = law;
  return scene;
}

struct FallCase {
  AirLaw law;
  bool flat;
};

class FallTest : public ::testing::TestWithParam<FallCase> {};

// Backward Euler in closed form: rho (v - v_n) = h (rho g - c v), or h (rho g - c v^2); the other constant of drag has
// no part in it. In the end rho g = c v, or c v^2.
TEST_P(FallTest, MeetsTheDiscreteFormulaAndTheTerminalVelocity) {
  const auto [law, flat] = GetParam();
  Scene scene = FallingScene(law, flat);
  const double c = 0.5, h = scene.time_step;
  scene.material.normal_drag = flat ? c : 3.0;
  scene.material.tangential_drag = flat ? 3.0 : c;
  constexpr int kNumSteps = 600;
  const Rollout rollout = SimulateNominal(scene, kNumSteps);
  double speed = 0.0;
  for (int step = 1; step <= kNumSteps; ++step) {
    const double b = h * c / kDensity, driven = speed + h * kGravity;
    speed = law == AirLaw::kLinear ? driven / (1.0 + b) : (std::sqrt(1.0 + 4.0 * b * driven) - 1.0) / (2.0 * b);
    if (step % 60 == 1) {
      EXPECT_LE(VelocityError(rollout, step, {0.0, 0.0, -speed}), 1e-9 * speed) << step;
    }
  }
  const double terminal = kDensity * kGravity / c;
  const double expected = law == AirLaw::kLinear ? terminal : std::sqrt(terminal);
  EXPECT_LE(VelocityError(rollout, kNumSteps, {0.0, 0.0, -expected}), 1e-5 * expected);
}

INSTANTIATE_TEST_SUITE_P(Laws, FallTest,
                         ::testing::Values(FallCase{AirLaw::kLinear, true}, FallCase{AirLaw::kLinear, false},
                                           FallCase{AirLaw::kQuadratic, true}, FallCase{AirLaw::kQuadratic, false}),
                         [](const auto& test) {
                           return std::string(test.param.law == AirLaw::kLinear ? "Linear" : "Quadratic") +
                                  (test.param.flat ? "Flat" : "OnEdge");
                         });

// Inertia without weight: the cloth starts to fall with g rho/(rho + m_a), with either integrator.
TEST(AddedMassTest, SlowsTheStartOfAFall) {
  for (const Integrator integrator : {Integrator::kEuler, Integrator::kSdirk2}) {
    Scene scene = FallingScene(AirLaw::kLinear, true);
    scene.integrator = integrator;
    scene.material.added_mass = 0.3;
    const Rollout rollout = SimulateNominal(scene, 10);
    const double speed = 10.0 * scene.time_step * kGravity * kDensity / (kDensity + 0.3);
    EXPECT_LE(VelocityError(rollout, 10, {0.0, 0.0, -speed}), 1e-10 * speed) << IntegratorName(integrator);
  }
}

// Where nothing has weight, added mass is mass.
TEST(AddedMassTest, IsMassWithoutGravity) {
  Scene light = ShippedScene("wind", 6);
  light.gravity.setZero();
  Scene heavy = light;
  const double density = light.nominal_parameters().material.density;
  light.parameters["density"].nominal = 0.4 * density;
  light.material.added_mass = 0.6 * density;
  heavy.parameters["density"].nominal = density;
  const Rollout a = SimulateNominal(light, 20), b = SimulateNominal(heavy, 20);
  EXPECT_LE((a.positions(20) - b.positions(20)).norm(), 1e-7 * b.positions(20).norm());
}

// Held by corners that move, in gusts of a quadratic drag that is stronger across the cloth.
Scene SailScene() {
  Scene scene = ShippedScene("wind", 6);
  scene.duration = 0.3;
  scene.material.drag = 0.0;
  scene.parameters.erase("drag");
  scene.air_law = AirLaw::kQuadratic;
  scene.material.normal_drag = 0.6;
  scene.material.tangential_drag = 0.05;
  scene.material.added_mass = 0.05;
  scene.handles.nodes = {0, 5};
  Eigen::MatrixXd path(6, 3);
  for (int i = 0; i < 2; ++i) {
    const Eigen::Vector3d start = scene.initial_positions.segment<3>(3 * scene.handles.nodes[i]);
    path.middleRows<3>(3 * i) << start, start + Eigen::Vector3d(0.0, 0.03, 0.01),
        start + Eigen::Vector3d(0.0, 0.0, 0.04);
  }
  const double begin = scene.start_time;
  scene.handles.path = HandlePath(Eigen::Vector3d(begin, begin + 0.15, begin + 0.3), path);
  return scene;
}

TEST(SailTest, IsOfSecondOrderWithMovingHandles) {
  EXPECT_GE(Order(SailScene(), Integrator::kSdirk2, 8), 1.9);
  EXPECT_LE(Order(SailScene(), Integrator::kEuler, 4), 1.2);
}

}  // namespace
}  // namespace clothid::air_test
