// adjoint = sensitivity = central finite differences where the cloth touches itself.
#include <gtest/gtest.h>

#include <Eigen/Core>
#include <cmath>
#include <cstddef>
#include <memory>
#include <vector>

#include "sim/obstacle/obstacle.h"
#include "tests/expect_error.h"
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

// Rollouts with and without factors that they keep, and the sweeps over them.
struct Sweeps {
  Sweeps(std::size_t factor_memory, bool use_kept_factors, Simulator* simulator) {
    const Parameters parameters = simulator->scene().nominal_parameters();
    const std::vector<ParameterId> ids = {{ParameterKind::kSelfFriction}, {ParameterKind::kStretchStiffness}};
    RolloutOptions options;
    options.factor_memory = factor_memory;
    rollout = Simulate(parameters, simulator->scene().num_steps(), simulator, nullptr, options);
    EXPECT_TRUE(rollout.ok());
    SensitivityDirections directions;
    directions.parameters = ids;
    PushForward(
        rollout, directions, [&](int, const Eigen::VectorXd&, const Eigen::MatrixXd& columns) { forward = columns; },
        simulator);
    AdjointOptions adjoint;
    adjoint.use_kept_factors = use_kept_factors;
    const auto add = [](int step, Eigen::MatrixXd* columns) { columns->array() += step; };
    reverse = PullBack(rollout, ids, 1, add, simulator, adjoint);
  }

  Rollout rollout;
  Eigen::MatrixXd forward;
  RolloutGradient reverse;
};

// Every solve ends with a factor of its contacts, which takes the place of one that a sweep would make.
TEST_P(SelfContactDerivativeTest, FactorsThatAreKeptServe) {
  Scene scene = SlidingLayers(GetParam());
  scene.duration = 0.05;
  Simulator simulator(scene);
  constexpr std::size_t kPlenty = std::size_t{1} << 30;  // bytes
  const Sweeps kept(kPlenty, true, &simulator), own(kPlenty, false, &simulator), none(0, true, &simulator);
  int num_with_pairs = 0;
  for (const StepRecord& record : kept.rollout.records) {
    EXPECT_NE(record.factor, nullptr);
    num_with_pairs += !record.contacts.pairs.empty();
  }
  EXPECT_GT(num_with_pairs, 2);
  for (const StepRecord& record : none.rollout.records) EXPECT_EQ(record.factor, nullptr);
  EXPECT_EQ(kept.reverse.work.phases.factorization, 0.0);
  EXPECT_GT(own.reverse.work.phases.factorization, 0.0);
  EXPECT_EQ(kept.rollout.positions(1), own.rollout.positions(1));
  EXPECT_LE((kept.reverse.parameters - own.reverse.parameters).norm(), 1e-9 * own.reverse.parameters.norm());
  EXPECT_LE((none.reverse.parameters - own.reverse.parameters).norm(), 1e-6 * own.reverse.parameters.norm());
  EXPECT_LE((kept.forward - none.forward).norm(), 1e-6 * none.forward.norm());
}

// The sweep that runs beside its rollout takes the factors that the steps have at hand.
TEST_P(SelfContactDerivativeTest, ASweepBesideItsRolloutIsThatOverIt) {
  Scene scene = SlidingLayers(GetParam());
  scene.duration = 0.05;
  Simulator simulator(scene);
  const Sweeps over(0, true, &simulator);
  SensitivityDirections directions;
  directions.parameters = {{ParameterKind::kSelfFriction}, {ParameterKind::kStretchStiffness}};
  Eigen::VectorXd end;
  Eigen::MatrixXd beside;
  PushForward(
      scene.nominal_parameters(), scene.num_steps(), directions,
      [&](int, const Eigen::VectorXd& positions, const Eigen::MatrixXd& columns) {
        end = positions;
        beside = columns;
      },
      &simulator);
  EXPECT_EQ(end, over.rollout.positions(scene.num_steps()));
  EXPECT_LE((beside - over.forward).norm(), 1e-9 * over.forward.norm());
}

TEST_P(SelfContactDerivativeTest, OtherAdjointMethodsNameTheOneThatServes) {
  Scene scene = SlidingLayers(GetParam());
  scene.duration = 0.05;
  Simulator simulator(scene);
  const Rollout rollout = Simulate(scene.nominal_parameters(), scene.num_steps(), &simulator);
  ASSERT_TRUE(rollout.ok());
  const auto add = [](int, Eigen::MatrixXd* columns) { columns->array() += 1.0; };
  AdjointOptions options;
  for (const AdjointMethod method : {AdjointMethod::kLu, AdjointMethod::kFixedPoint, AdjointMethod::kSystemGmres}) {
    options.method = method;
    ExpectError([&] { PullBack(rollout, {{ParameterKind::kSelfFriction}}, 1, add, &simulator, options); },
                ErrorKind::kUsage, {"contacts of the cloth with itself", "reduced"});
  }
}

INSTANTIATE_TEST_SUITE_P(Integrators, SelfContactDerivativeTest,
                         testing::Values(Integrator::kEuler, Integrator::kSdirk2),
                         [](const auto& test) { return IntegratorName(test.param); });

}  // namespace
}  // namespace clothid::self_contact_derivative_test
