// Forces at handles in the cost: adjoint = sensitivity = central differences, in every term of the force.
#include <gtest/gtest.h>

#include <memory>

#include "costs/full_residual_cost.h"
#include "costs/rollout_cost.h"
#include "sim/base/error.h"
#include "tests/costs/start/forget_start.h"
#include "tests/costs/synthetic_forces.h"
#include "tests/sim/self_contact_scenes.h"

namespace clothid::force_cost_test {
namespace {

struct Case {
  const char* name;
  Integrator integrator;
  ContactMode contact_mode;
  double damping;
  bool has_ball;
  std::vector<std::string> parameters;
  bool touches_itself = false;
  bool has_every_force = false;
};

void PrintTo(const Case& of, std::ostream* out) { *out << of.name; }

// A layer slides on a held one, which is shaken gently.
Scene TouchingScene(Integrator integrator) {
  Scene scene = LayersOnASlope(2, 0.44, 0.28, integrator, 0.01);
  scene.solver.adjoint_tolerance = 1e-14;
  scene.material.bending_stiffness = 0.0;  // at rest it is not flat
  scene.duration = 0.2;
  const Eigen::VectorXd times = Eigen::VectorXd::LinSpaced(21, 0.0, scene.duration);
  const std::vector<int>& nodes = scene.handles.nodes;
  Eigen::MatrixXd path(3 * static_cast<Eigen::Index>(nodes.size()), times.size());
  for (Eigen::Index k = 0; k < times.size(); ++k) {
    const Eigen::Vector3d shift(0.002 * (1.0 - std::cos(20.0 * times[k])), 0.0,
                                0.001 * (1.0 - std::cos(30.0 * times[k])));
    for (std::size_t i = 0; i < nodes.size(); ++i) {
      path.col(k).segment<3>(3 * static_cast<Eigen::Index>(i)) =
          scene.initial_positions.segment<3>(3 * nodes[i]) + shift;
    }
  }
  scene.handles.path = HandlePath(times, path);
  return scene;
}

// Drag by direction, a rest shape that is curved, links at a handle and beside it.
void AddEveryForce(Scene* scene) {
  scene->material.normal_drag = 0.4;
  scene->material.tangential_drag = 0.15;
  scene->wind.mean = {0.2, 0.5, -0.1};
  scene->bending.law = BendingLaw::kPatches;
  scene->mesh.links = {{1, {7, 8}, 0.3, 2.0, 0.0}, {6, {12, 12}, 0.0, 3.0, 0.1}};
  for (int node = 0; node < scene->mesh.num_nodes(); ++node) {
    const double along = scene->mesh.rest_positions(0, node);
    scene->mesh.rest_positions(2, node) += 0.5 * along * along;
  }
}

// Two grippers, the second with a component that its sensor does not have, and readings left out.
RecordedMotion ForceMotion(const Case& of) {
  Scene scene = of.touches_itself ? TouchingScene(of.integrator) : of.has_ball ? SphereScene() : SwingScene();
  if (!of.has_ball && !of.touches_itself) scene.handles.nodes = {0, 1, 3, 4};
  scene.integrator = of.integrator;
  scene.contact_mode = of.contact_mode;
  scene.material.damping = of.damping;
  if (of.has_every_force) AddEveryForce(&scene);
  scene.solver.step_tolerance = 1e-12;
  if (!of.touches_itself) scene = Shaken(scene);
  MotionOptions motion_options;
  motion_options.true_values = {{"k_stretch", 90.0}};
  motion_options.frame_interval = 0.0125;
  motion_options.noise = 1e-3;
  motion_options.sigma = 1e-3;
  RecordedMotion motion = MakeMotion(scene, motion_options);
  ForceOptions options;
  options.true_values = motion_options.true_values;
  options.groups = {{0, 1}, {4, 3}};
  if (of.touches_itself) options.groups = {{24, 25, 45}, {46, 66}};
  options.noise = options.sigma;
  AddForces(options, &motion);
  motion.forces.values.row(3).setConstant(std::nan(""));
  motion.forces.values.col(7).setConstant(std::nan(""));
  return motion;
}

std::vector<ParameterBlock> BlocksOf(const RecordedMotion& motion, const std::vector<std::string>& names) {
  std::vector<ParameterBlock> blocks;
  for (const std::string& name : names) blocks.push_back(MakeParameterBlock(name, motion, {}));
  return blocks;
}

class ForceCostTest : public testing::TestWithParam<Case> {
 protected:
  ForceCostTest() : motion_(ForceMotion(GetParam())), blocks_(BlocksOf(motion_, GetParam().parameters)) {
    at_ = StartOf(blocks_);
    for (int i = 0; i < at_.size(); ++i) {
      if (blocks_[i].is_signed) at_[i] += 0.05;
    }
  }

  Eigen::VectorXd Gradient(const RolloutCostOptions& options, double* cost) const {
    const RolloutCost of(motion_, blocks_, options);
    Eigen::VectorXd gradient;
    EXPECT_TRUE(of.EvaluateGradient(at_, cost, &gradient)) << of.last_failure();
    return gradient;
  }

  static RolloutCostOptions With(JacobianMethod method, const char* loss = "none") {
    RolloutCostOptions options;
    options.jacobian = method;
    options.loss = ParseRobustLoss(loss);
    return options;
  }

  RecordedMotion motion_;
  std::vector<ParameterBlock> blocks_;
  Eigen::VectorXd at_;
};

TEST_P(ForceCostTest, AdjointIsTheSensitivity) {
  for (const char* loss : {"none", "huber:2"}) {
    double adjoint_cost = 0.0, cost = 0.0;
    const Eigen::VectorXd adjoint = Gradient(With(JacobianMethod::kAdjoint, loss), &adjoint_cost);
    const Eigen::VectorXd forward = Gradient(With(JacobianMethod::kSensitivity, loss), &cost);
    EXPECT_NEAR(adjoint_cost, cost, 1e-12 * cost);
    for (Eigen::Index i = 0; i < forward.size(); ++i) {
      EXPECT_NEAR(adjoint[i], forward[i], 1e-10 * std::max(std::abs(forward[i]), 1e-3 * forward.norm()))
          << blocks_[i].name;
    }
  }
}

TEST_P(ForceCostTest, CheckpointsChangeNothing) {
  RolloutCostOptions options = With(JacobianMethod::kAdjoint);
  double cost = 0.0, limited_cost = 0.0;
  const Eigen::VectorXd gradient = Gradient(options, &cost);
  options.memory_limit = 0;
  const Eigen::VectorXd limited = Gradient(options, &limited_cost);
  EXPECT_NEAR(cost, limited_cost, 1e-8 * cost);
  EXPECT_LE((gradient - limited).norm(), 1e-7 * gradient.norm());
}

TEST_P(ForceCostTest, JacobianIsThatOfCentralDifferences) {
  const FullResidualCost cost(motion_, blocks_);
  const auto residuals_at = [&](const Eigen::VectorXd& at, Eigen::MatrixXd* jacobian) {
    std::vector<const double*> parameters;
    std::vector<double*> columns;
    for (Eigen::Index i = 0; i < at.size(); ++i) {
      parameters.push_back(&at[i]);
      if (jacobian != nullptr) columns.push_back(jacobian->col(i).data());
    }
    Eigen::VectorXd residuals(cost.num_residuals());
    EXPECT_TRUE(cost.Evaluate(parameters.data(), residuals.data(), jacobian != nullptr ? columns.data() : nullptr))
        << cost.last_failure();
    return residuals;
  };
  Eigen::MatrixXd jacobian(cost.num_residuals(), at_.size());
  residuals_at(at_, &jacobian);
  const Eigen::Index num_forces = Observation(motion_).forces().num_residuals();
  ASSERT_EQ(num_forces, 32 * 5);
  for (Eigen::Index i = 0; i < at_.size(); ++i) {
    double error = 1.0, force_error = 1.0;
    for (const double step : {2e-5, 2e-6}) {
      Eigen::VectorXd up = at_, down = at_;
      up[i] += step;
      down[i] -= step;
      const Eigen::VectorXd difference = (residuals_at(up, nullptr) - residuals_at(down, nullptr)) / (2.0 * step);
      const Eigen::VectorXd missed = jacobian.col(i) - difference;
      error = std::min(error, missed.norm() / jacobian.col(i).norm());
      force_error = std::min(force_error, missed.tail(num_forces).norm() / jacobian.col(i).norm());
    }
    EXPECT_LE(force_error, 1e-6) << blocks_[i].name;
    EXPECT_LE(error, 1e-6) << blocks_[i].name;
  }
}

// What Ceres gets: rows of a forward sweep, and of forward differences.
TEST_P(ForceCostTest, NumericRowsAreThoseOfSensitivities) {
  Eigen::MatrixXd grams[2];
  for (const JacobianMethod method : {JacobianMethod::kSensitivity, JacobianMethod::kNumeric}) {
    const RolloutCost cost(motion_, blocks_, With(method));
    std::vector<const double*> parameters;
    std::vector<double*> columns;
    Eigen::MatrixXd jacobian(cost.num_residuals(), at_.size());
    for (Eigen::Index i = 0; i < at_.size(); ++i) {
      parameters.push_back(&at_[i]);
      columns.push_back(jacobian.col(i).data());
    }
    Eigen::VectorXd residuals(cost.num_residuals());
    ASSERT_TRUE(cost.Evaluate(parameters.data(), residuals.data(), columns.data())) << cost.last_failure();
    grams[method == JacobianMethod::kNumeric ? 1 : 0] = jacobian.transpose() * jacobian;
  }
  EXPECT_LE((grams[0] - grams[1]).norm(), 1e-3 * grams[0].norm());
}

INSTANTIATE_TEST_SUITE_P(
    All, ForceCostTest,
    testing::Values(
        Case{"Euler",
             Integrator::kEuler,
             ContactMode::kGap,
             0.0,
             false,
             {"k_stretch", "k_bend", "density", "drag", "force_bias.z", "force_bias2.y"}},
        Case{"DampedEuler",
             Integrator::kEuler,
             ContactMode::kGap,
             0.05,
             false,
             {"k_stretch", "density", "damping", "v0.y"}},
        Case{"DampedSdirk2",
             Integrator::kSdirk2,
             ContactMode::kGap,
             0.05,
             false,
             {"k_stretch", "k_bend", "density", "drag", "damping", "time_offset", "shift.x", "v0.z", "force_bias2.z"}},
        Case{"Gap", Integrator::kSdirk2, ContactMode::kGap, 0.02, true, {"mu", "k_stretch", "density"}},
        Case{"Velocity", Integrator::kEuler, ContactMode::kVelocity, 0.0, true, {"mu", "k_stretch", "density", "drag"}},
        Case{"TouchingEuler",
             Integrator::kEuler,
             ContactMode::kGap,
             0.0,
             false,
             {"mu.self", "k_stretch", "density", "handle_shift1.x", "handle_shift2.z"},
             true},
        Case{"TouchingSdirk2",
             Integrator::kSdirk2,
             ContactMode::kGap,
             0.02,
             false,
             {"mu.self", "k_stretch", "density", "handle_shift1.x", "handle_shift2.z"},
             true},
        Case{"EveryForceEuler",
             Integrator::kEuler,
             ContactMode::kGap,
             0.0,
             false,
             {"k_bend", "drag_normal", "drag_tangential", "wind.y", "size.x", "size.y"},
             false,
             true},
        Case{"EveryForceSdirk2",
             Integrator::kSdirk2,
             ContactMode::kGap,
             0.02,
             false,
             {"k_stretch", "density", "drag_normal", "size.x", "handle_shift1.x", "v0.z"},
             false,
             true}),
    [](const auto& named) { return named.param.name; });

TEST(ForceBiasTest, WantsForcesAlongItsAxis) {
  RecordedMotion motion = ForceMotion({"", Integrator::kEuler, ContactMode::kGap, 0.0, false, {}});
  EXPECT_NO_THROW(BlocksOf(motion, {"force_bias.x", "force_bias2.y"}));
  EXPECT_THROW(BlocksOf(motion, {"force_bias2.x"}), Error);  // was not measured
  EXPECT_THROW(BlocksOf(motion, {"force_bias3.x"}), Error);
  motion.forces = ForceReadings();
  EXPECT_THROW(BlocksOf(motion, {"force_bias.x"}), Error);
}

TEST(ForceBiasTest, HasNamesPerGroupAndAxis) {
  EXPECT_EQ(ExpandAlignmentNames({"force_bias", "force_bias12"}),
            (std::vector<std::string>{"force_bias.x", "force_bias.y", "force_bias.z", "force_bias12.x",
                                      "force_bias12.y", "force_bias12.z"}));
  EXPECT_EQ(FindParameter("force_bias12.y"), (ParameterId{ParameterKind::kForceBias, 1, 11}));
  for (const char* name : {"force_bias", "force_bias1.x", "force_bias02.x", "force_bias-2.x", "force_bias2", "force.x",
                           "force_bias.w", "force_bias99999.x"}) {
    EXPECT_FALSE(FindParameter(name)) << name;
  }
}

// Unknowns of a start move the handles, too, and with them the forces there.
TEST(ForceStartTest, GradientsCountWithAnUnknownStart) {
  Scene scene = SphereScene();
  scene.material.damping = 0.01;
  scene.solver.step_tolerance = 1e-12;
  MotionOptions motion_options;
  motion_options.noise = motion_options.sigma = 1e-3;
  RecordedMotion motion = ForgetStart(StartSource::kMoving, MakeMotion(scene, motion_options));
  ForceOptions options;
  options.true_values = {{"k_stretch", 90.0}};
  options.noise = options.sigma = 0.01;
  AddForces(options, &motion);
  const RolloutCost cost(motion, MakeBlocks(motion.scene, {"k_stretch", "density"}), {});
  const int num_unknowns = cost.model().num_start_unknowns();
  Eigen::VectorXd at(2 + num_unknowns);
  at.head(2) = StartOf(cost.model().blocks());
  std::srand(3);
  at.tail(num_unknowns) = 2e-4 * Eigen::VectorXd::Random(num_unknowns);
  double value = 0.0;
  Eigen::VectorXd gradient, residuals;
  Eigen::MatrixXd jacobian;
  ASSERT_TRUE(cost.EvaluateGradient(at, &value, &gradient)) << cost.last_failure();
  ASSERT_TRUE(cost.Linearize(at, Eigen::MatrixXd::Identity(num_unknowns, num_unknowns), &jacobian, &residuals));
  EXPECT_NEAR(value, 0.5 * residuals.squaredNorm(), 1e-9 * value);
  EXPECT_LE((jacobian.transpose() * residuals - gradient).norm(), 1e-2 * gradient.norm());
  for (Eigen::Index i = 0; i < at.size(); i += 9) {
    double best = 1.0;
    for (const double step : {1e-6, 1e-7, 1e-5}) {
      double costs[2] = {0.0, 0.0};
      for (const int side : {0, 1}) {
        Eigen::VectorXd moved = at;
        moved[i] += side == 0 ? -step : step;
        ASSERT_TRUE(cost.EvaluateGradient(moved, &costs[side], nullptr));
      }
      best = std::min(best, std::abs((costs[1] - costs[0]) / (2.0 * step) - gradient[i]) / gradient.norm());
    }
    EXPECT_LE(best, 1e-5 * std::abs(gradient[i]) / gradient.norm() + 1e-7) << i;
  }
  const Eigen::MatrixXd follow = 1e-3 * Eigen::MatrixXd::Random(num_unknowns, 2);
  Eigen::MatrixXd along, scores;
  ASSERT_TRUE(cost.Linearize(at, follow, &along, &residuals, &scores));
  Eigen::VectorXd expected(4);
  expected << gradient.head(2), follow.transpose() * gradient.tail(num_unknowns);
  EXPECT_LE((along.transpose() * residuals - expected).norm(), 1e-5 * expected.norm());
}

// A gauge and the path of its clamp, and nothing else that is seen.
TEST(ForceCostOnlyTest, CountsForcesWithoutPositions) {
  RecordedMotion motion = ForceMotion({"", Integrator::kSdirk2, ContactMode::kGap, 0.0, false, {}});
  motion.positions.setConstant(std::nan(""));
  const std::vector<ParameterBlock> blocks = BlocksOf(motion, {"k_stretch", "density"});
  RolloutCostOptions options;
  options.starts_with_sensitivities = true;
  const RolloutCost cost(motion, blocks, options);
  double value = 0.0;
  Eigen::VectorXd gradient;
  ASSERT_TRUE(cost.EvaluateGradient(StartOf(blocks), &value, &gradient)) << cost.last_failure();
  EXPECT_GT(value, 100.0);
  EXPECT_GT(gradient.cwiseAbs().minCoeff(), 1.0);
  motion.forces = ForceReadings();
  EXPECT_THROW(Observation{motion}, Error);
}

}  // namespace
}  // namespace clothid::force_cost_test
