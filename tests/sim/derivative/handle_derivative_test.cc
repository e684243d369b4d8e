// Offsets of the handles' path and the start that goes with them: adjoint = sensitivity = central finite differences,
// with contact, with obstacles or of the cloth with itself, bending, drag, internal damping and fields.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <random>
#include <stdexcept>
#include <string>
#include <utility>

#include "sim/derivative/adjoint.h"
#include "sim/derivative/sensitivity.h"
#include "sim/rollout/simulator.h"
#include "sim/scene/attached_handles.h"
#include "tests/sim/derivative/same_branches.h"
#include "tests/sim/nodal_correction.h"
#include "tests/sim/self_contact_scenes.h"
#include "tests/sim/shipped_scenes.h"

namespace clothid::handle_derivative_test {
namespace {

constexpr int kNumKnots = 3;

// All of them by `way` over the scene.
void MoveHandles(const Eigen::Vector3d& way, Scene* scene) {
  const std::vector<int>& nodes = scene->handles.nodes;
  Eigen::MatrixXd knots(3 * static_cast<Eigen::Index>(nodes.size()), 2);
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    const Eigen::Vector3d start = scene->initial_positions.segment<3>(3 * nodes[i]);
    knots.middleRows<3>(3 * static_cast<Eigen::Index>(i)) << start, start + way;
  }
  scene->handles.path = HandlePath(Eigen::Vector2d(scene->start_time, scene->start_time + scene->duration), knots);
}

// The draped cloth with all terms, its handles on the move.
Scene MovingScene(Integrator integrator) {
  Scene scene = ShippedScene("drape", 10);
  scene.integrator = integrator;
  // Two solves per step meet twice as many changes of contacts, between which differences have to fit.
  if (integrator == Integrator::kSdirk2) scene.duration = 0.45;
  scene.material.bending_stiffness = 1e-4;
  scene.material.drag = 0.05;
  scene.material.damping = 0.02;
  scene.solver.step_tolerance = 1e-12;
  scene.fields = {{ParameterKind::kStretchStiffness, Eigen::RowVector2d(60.0, 90.0)},
                  {ParameterKind::kBendingStiffness, Eigen::Vector2d(2e-4, 5e-5)}};
  MoveHandles({0.01, 0.02, 0.01}, &scene);
  return scene;
}

// A layer that falls by a millimetre onto another and slides on it. Most of the lower one is held and shaken.
Scene LayersScene(Integrator integrator) {
  Scene scene = LayersOnASlope(2, 0.44, 0.3, integrator, 0.005);
  std::vector<int> held;
  for (int node = 0; node < static_cast<int>(scene.handles.nodes.size()); ++node) {
    if (node % 4 != 1) held.push_back(node);
  }
  for (int node = static_cast<int>(scene.handles.nodes.size()); node < scene.mesh.num_nodes(); ++node) {
    scene.initial_positions[3 * node + 2] += 0.001;
    scene.initial_velocities[3 * node] = 0.05;
  }
  scene.handles.nodes = held;
  scene.material.damping = 0.02;
  scene.solver.step_tolerance = 1e-12;
  scene.solver.adjoint_tolerance = 1e-14;
  scene.duration = 0.1;
  MoveHandles({-0.004, 0.002, 0.003}, &scene);
  return scene;
}

class HandleCase {
 public:
  // `noise`, m, of the offsets and, times 50, of the directions. `correction`: of the rollout; may be null.
  explicit HandleCase(const Scene& scene, double noise = 0.002, std::shared_ptr<const Correction> correction = nullptr)
      : scene_(scene),
        simulator_(scene_),
        parameters_(scene_.nominal_parameters()),
        correction_(std::move(correction)) {
    std::mt19937_64 generator(5);
    std::normal_distribution<double> normal;
    const Eigen::Index num_handles = static_cast<Eigen::Index>(scene_.handles.nodes.size());
    values_ = Eigen::MatrixXd::NullaryExpr(3 * num_handles, kNumKnots, [&] { return noise * normal(generator); });
    directions_.initial_positions = Eigen::MatrixXd::NullaryExpr(scene_.initial_positions.size(), 2,
                                                                 [&] { return 50.0 * noise * normal(generator); });
    directions_.initial_positions.col(1).setZero();
    directions_.handle_offsets =
        Eigen::MatrixXd::NullaryExpr(values_.size(), 2, [&] { return 50.0 * noise * normal(generator); });
    directions_.handle_offsets.col(0).setZero();
    rollout_ = Perturbed(0, 0.0);
    EXPECT_TRUE(rollout_.ok()) << rollout_.failure->ToString();
  }

  // Along direction `i`, at both its ends.
  Rollout Perturbed(int i, double step) {
    const HandlePath offsets = Offsets(values_ + step * Reshaped(i));
    const Eigen::VectorXd positions = StartWith(offsets, step * directions_.initial_positions.col(i));
    RolloutOptions options;
    options.initial_positions = &positions;
    options.handle_offsets = &offsets;
    options.correction = correction_;
    return Simulate(parameters_, scene_.num_steps(), &simulator_, nullptr, options);
  }

  Eigen::Vector2d Adjoint() {
    const RolloutGradient gradient = PullBack(
        rollout_, {}, 1, [&](int step, Eigen::MatrixXd* seed) { seed->col(0) += rollout_.positions(step); },
        &simulator_);
    Eigen::MatrixXd start = directions_.initial_positions;
    for (const int node : scene_.handles.nodes) start.middleRows<3>(3 * node).setZero();
    return start.transpose() * gradient.initial_positions +
           directions_.handle_offsets.transpose() * gradient.handle_offsets;
  }

  Eigen::Vector2d Sensitivity() {
    const HandlePath offsets = Offsets(values_);
    SensitivityOptions options;
    options.initial_positions = &rollout_.initial_positions;
    options.handle_offsets = &offsets;
    options.correction = correction_;
    Eigen::Vector2d sum = Eigen::Vector2d::Zero();
    const SensitivityResult result = PushForward(
        parameters_, scene_.num_steps(), directions_,
        [&](int, const Eigen::VectorXd& x, const Eigen::MatrixXd& dx) { sum += dx.transpose() * x; }, &simulator_,
        nullptr, options);
    EXPECT_FALSE(result.failure.has_value());
    return sum;
  }

  static double Cost(const Rollout& rollout) {
    double cost = 0.0;
    for (int step = 0; step <= rollout.num_steps(); ++step) cost += 0.5 * rollout.positions(step).squaredNorm();
    return cost;
  }

  const Rollout& rollout() const { return rollout_; }
  const SensitivityDirections& directions() const { return directions_; }
  Simulator& simulator() { return simulator_; }
  const Scene& scene() const { return scene_; }

 private:
  HandlePath Offsets(const Eigen::MatrixXd& values) const {
    const double start = scene_.start_time, duration = scene_.duration;
    return HandlePath(Eigen::Vector3d(start, start + 0.4 * duration, start + duration), values);
  }
  // Column `i` of the directions, in the shape of the offsets' values.
  Eigen::MatrixXd Reshaped(int i) const {
    return directions_.handle_offsets.col(i).reshaped(values_.rows(), values_.cols());
  }
  Eigen::VectorXd StartWith(const HandlePath& offsets, const Eigen::VectorXd& change) const {
    Eigen::VectorXd positions = scene_.initial_positions + change;
    const Eigen::VectorXd handles = scene_.handles.path.At(scene_.start_time) + offsets.At(scene_.start_time);
    for (std::size_t i = 0; i < scene_.handles.nodes.size(); ++i) {
      positions.segment<3>(3 * scene_.handles.nodes[i]) = handles.segment<3>(3 * static_cast<Eigen::Index>(i));
    }
    return positions;
  }

  Scene scene_;
  Simulator simulator_;
  Parameters parameters_;
  std::shared_ptr<const Correction> correction_;
  Eigen::MatrixXd values_;  // [3H x kNumKnots]
  SensitivityDirections directions_;
  Rollout rollout_;
};

class HandleDerivativeTest : public ::testing::TestWithParam<Integrator> {};

void ExpectThreeWaysAgree(HandleCase& handles) {
  const Eigen::Vector2d adjoint = handles.Adjoint(), sensitivity = handles.Sensitivity();
  for (int i = 0; i < 2; ++i) {
    EXPECT_NEAR(adjoint[i], sensitivity[i], 1e-10 * std::abs(adjoint[i])) << i;
    double best = 1.0;
    for (const double step : {1e-4, 1e-5, 1e-6, 1e-7}) {
      if (best <= 1e-5) break;
      const Rollout plus = handles.Perturbed(i, step), minus = handles.Perturbed(i, -step);
      if (!HaveSameBranches(handles.rollout(), plus) || !HaveSameBranches(handles.rollout(), minus)) continue;
      const double difference = (HandleCase::Cost(plus) - HandleCase::Cost(minus)) / (2.0 * step);
      best = std::min(best, std::abs(difference - adjoint[i]) / std::abs(adjoint[i]));
    }
    EXPECT_LE(best, 1e-5) << i;
  }
}

TEST_P(HandleDerivativeTest, AdjointEqualsSensitivityEqualsDifferences) {
  HandleCase handles(MovingScene(GetParam()));
  ASSERT_FALSE(handles.rollout().records.back().contacts.empty());
  ExpectThreeWaysAgree(handles);
}

// The slope of a clamp stays as it is.
TEST_P(HandleDerivativeTest, OfAClampedRow) {
  Scene scene = MovingScene(GetParam());
  scene.duration = 0.2;
  ClampHandles({{scene.handles.nodes}}, &scene);
  HandleCase handles(scene);
  ExpectThreeWaysAgree(handles);
}

// Where predictions follow handles, so does what corrects them.
TEST_P(HandleDerivativeTest, OfCorrectedRollouts) {
  const Scene scene = MovingScene(GetParam());
  Parameters true_parameters = scene.nominal_parameters();
  for (double& mu : true_parameters.friction_coefficients) mu *= 0.7;
  HandleCase handles(scene, 0.002, CorrectionTowards(scene, true_parameters, /*interval=*/4, {}));
  ASSERT_FALSE(handles.rollout().records.back().contacts.empty());
  ExpectThreeWaysAgree(handles);
}

// Handles are among the nodes of the pairs in contact, those of an impact, too.
TEST_P(HandleDerivativeTest, OfPairsThatTouchThem) {
  HandleCase handles(LayersScene(GetParam()), 1e-4);
  const std::vector<PairContactRecord>& pairs = handles.rollout().records.back().contacts.pairs;
  ASSERT_TRUE(std::any_of(pairs.begin(), pairs.end(), [&](const PairContactRecord& pair) {
    const std::vector<int>& held = handles.scene().handles.nodes;
    return std::find(held.begin(), held.end(), pair.features.nodes[1]) != held.end();
  }));
  ExpectThreeWaysAgree(handles);
}

// A checkpointed rollout makes its steps again, with the offsets.
TEST_P(HandleDerivativeTest, CheckpointsRememberTheOffsets) {
  HandleCase handles(MovingScene(GetParam()));
  const HandlePath& offsets = handles.rollout().handle_offsets;
  RolloutOptions options;
  options.initial_positions = &handles.rollout().initial_positions;
  options.handle_offsets = &offsets;
  options.checkpoint_interval = 7;
  const Rollout again = Simulate(handles.scene().nominal_parameters(), handles.scene().num_steps(),
                                 &handles.simulator(), nullptr, options);
  const auto seed = [&](int, Eigen::MatrixXd* gradient) { gradient->setOnes(); };
  const RolloutGradient all = PullBack(handles.rollout(), {}, 1, seed, &handles.simulator());
  const RolloutGradient some = PullBack(again, {}, 1, seed, &handles.simulator());
  // Each segment starts its solver afresh: equal up to the tolerance of the steps.
  const double size = all.handle_offsets.norm();
  ASSERT_GT(size, 0.0);
  EXPECT_LE((all.handle_offsets - some.handle_offsets).norm(), 1e-6 * size);
  EXPECT_LE((all.initial_positions - some.initial_positions).norm(), 1e-6 * all.initial_positions.norm());
}

INSTANTIATE_TEST_SUITE_P(Integrators, HandleDerivativeTest, ::testing::Values(Integrator::kEuler, Integrator::kSdirk2),
                         [](const auto& test) { return std::string(IntegratorName(test.param)); });

TEST(HandleOffsetsTest, OffsetsNeedAPathOfAsManyHandles) {
  Scene scene = ShippedScene("drape", 6);  // handles that stand still
  Simulator simulator(scene);
  const HandlePath offsets(Eigen::VectorXd::Zero(1), Eigen::MatrixXd::Zero(3, 1));
  RolloutOptions options;
  options.handle_offsets = &offsets;
  EXPECT_THROW(Simulate(scene.nominal_parameters(), 1, &simulator, nullptr, options), std::logic_error);
}

TEST(HandleOffsetsTest, KnotWeightsAreTheDerivativeOfThePath) {
  const Eigen::Vector4d times(0.0, 0.3, 0.5, 1.2);
  const Eigen::MatrixXd positions = Eigen::MatrixXd::Random(6, 4);
  const HandlePath path(times, positions);
  for (const double time : {-1.0, 0.0, 0.1, 0.3, 0.45, 1.0, 1.2, 2.0}) {
    EXPECT_LE((path.At(time) - positions * path.KnotWeights(time)).norm(), 1e-14) << time;
  }
}

}  // namespace
}  // namespace clothid::handle_derivative_test
