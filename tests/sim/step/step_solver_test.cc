// Every step of the shipped scenes: the residual, and the contact conditions of Eq. (8) at every node.
#include "sim/step/step_solver.h"

#include <gtest/gtest.h>

#include <memory>
#include <tuple>

#include "sim/rollout/rollout.h"
#include "sim/rollout/simulator.h"
#include "sim/step/step_problem.h"
#include "tests/sim/shipped_scenes.h"

namespace clothid::step_solver_test {
namespace {

class StepOfShippedSceneTest : public ::testing::TestWithParam<std::tuple<std::string, int, ContactMode>> {};

// r from the momentum balance, u from the velocities: neither uses the contact law. A cloth at rest is measured by the
// speed that gravity gives it in a step, `fall_speed`.
void ExpectContactConditions(const StepProblem& problem, const StepPoint& point, double fall_speed) {
  double impulse_scale = 0.0;
  const double speed_scale = std::max(point.velocities.lpNorm<Eigen::Infinity>(), fall_speed);
  for (const ContactResponse& response : point.responses)
    impulse_scale = std::max(impulse_scale, response.impulse.norm());
  impulse_scale = std::max(impulse_scale, point.scale);
  for (size_t i = 0; i < problem.contacts().candidates().size(); ++i) {
    const ContactCandidate& candidate = problem.contacts().candidates()[i];
    const int index = static_cast<int>(i), row = 3 * problem.contacts().free_block(index);
    const Eigen::Vector3d& n = candidate.normal;
    const Eigen::Vector3d r = point.momentum_gradient.segment<3>(row), u = point.velocities.segment<3>(row);
    const double r_normal = n.dot(r), approach = n.dot(u) + candidate.gap_speed;
    const Eigen::Vector3d r_tangential = r - r_normal * n, u_tangential = u - n.dot(u) * n;
    EXPECT_GE(r_normal, -1e-9 * impulse_scale);
    EXPECT_GE(approach, -1e-9 * speed_scale);
    EXPECT_LE(std::min(r_normal / impulse_scale, approach / speed_scale), 1e-9);  // their product is zero
    EXPECT_LE(r_tangential.norm(), problem.friction_coefficient(index) * r_normal + 1e-9 * impulse_scale);
    EXPECT_LE(r_tangential.dot(u_tangential), 1e-9 * impulse_scale * speed_scale);
  }
}

TEST_P(StepOfShippedSceneTest, ConvergesToTheContactConditions) {
  const auto [name, nodes, mode] = GetParam();
  Scene scene = ShippedScene(name, nodes);
  scene.solver.step_tolerance = 1e-10;
  scene.contact_mode = mode;
  Simulator simulator(scene);
  const Rollout rollout = Simulate(scene.nominal_parameters(), scene.num_steps(), &simulator);
  ASSERT_TRUE(rollout.ok()) << rollout.failure->ToString();
  EXPECT_EQ(rollout.num_steps(), scene.num_steps());
  EXPECT_EQ(rollout.counts.failed_steps, 0);
  EXPECT_EQ(rollout.counts.substeps, 0);
  StepPoint point;
  for (size_t i = 0; i < rollout.records.size(); ++i) {
    const StepRecord& record = rollout.records[i];
    const Eigen::VectorXd& x = i == 0 ? rollout.initial_positions : rollout.records[i - 1].positions;
    const Eigen::VectorXd& v = i == 0 ? rollout.initial_velocities : rollout.records[i - 1].velocities;
    const StepProblem problem(simulator.model(), rollout.parameters, {x, v}, record.times(),
                              &simulator.step_workspace());
    problem.Evaluate(simulator.model().Gather(record.velocities), &point);
    // Scattering the velocities and gathering them again may cost a rounding.
    EXPECT_LE(point.relative_residual, 1.01 * std::max(1e-10, problem.RoundingFloor(point))) << "step " << i + 1;
    ExpectContactConditions(problem, point, scene.time_step * scene.gravity.norm());
  }
}

// A sheet that falls on a rough ball and folds over it: nodes between sticking and slipping, many at a time.
TEST(StepSolverTest, NodesInContactDoNotAlternate) {
  GridOptions grid;
  grid.nodes = {32, 32};
  grid.size = {1.0, 1.0};
  Scene scene;
  scene.integrator = Integrator::kEuler;
  scene.time_step = 0.01;
  scene.mesh = MakeGrid(grid);
  scene.initial_positions = scene.mesh.rest_positions.reshaped();
  scene.initial_velocities = Eigen::VectorXd::Zero(scene.initial_positions.size());
  scene.material.density = 0.2;
  scene.material.stretch_stiffness = 100.0;
  scene.material.bending_stiffness = 1e-3;
  SceneObstacle ball;
  ball.name = "ball";
  ball.friction_coefficient = 0.4;
  ball.shape = std::make_shared<Sphere>(Eigen::Vector3d(0.543, 0.521, -0.31), 0.3);
  scene.obstacles.push_back(ball);
  Simulator simulator(scene);
  const Rollout rollout = Simulate(scene.nominal_parameters(), 50, &simulator);
  ASSERT_TRUE(rollout.ok()) << rollout.failure->ToString();
  EXPECT_GT(rollout.counts.branch_switches, 10);
  EXPECT_LT(rollout.counts.newton_iterations, 355);  // 387 without sweeps over nodes in contact
}

std::string Label(const ::testing::TestParamInfo<StepOfShippedSceneTest::ParamType>& info) {
  const char* mode = std::get<2>(info.param) == ContactMode::kGap ? "Gap" : "Velocity";
  return std::get<0>(info.param) + std::to_string(std::get<1>(info.param)) + mode;
}

INSTANTIATE_TEST_SUITE_P(Scenes, StepOfShippedSceneTest,
                         ::testing::Combine(::testing::Values("drape", "slope", "wind"), ::testing::Values(12, 24, 48),
                                            ::testing::Values(ContactMode::kGap)),
                         Label);
INSTANTIATE_TEST_SUITE_P(VelocityMode, StepOfShippedSceneTest,
                         ::testing::Combine(::testing::Values("drape", "slope"), ::testing::Values(12),
                                            ::testing::Values(ContactMode::kVelocity)),
                         Label);

}  // namespace
}  // namespace clothid::step_solver_test
