// Drag by direction, added mass, wind and pressure in a rollout with contact, damping and handles that move: adjoint =
// sensitivity = central finite differences, for their parameters, the start and the handles' offsets.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <string>
#include <tuple>
#include <vector>

#include "sim/derivative/adjoint.h"
#include "sim/derivative/sensitivity.h"
#include "sim/rollout/simulator.h"
#include "tests/sim/derivative/same_branches.h"
#include "tests/sim/shipped_scenes.h"

namespace clothid::air_derivative_test {
namespace {

constexpr int kNumKnots = 3;

using AirParam = std::tuple<Integrator, ContactMode, AirLaw>;

void MoveHandles(Scene* scene) {
  const std::vector<int>& nodes = scene->handles.nodes;
  Eigen::MatrixXd knots(3 * static_cast<Eigen::Index>(nodes.size()), 2);
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    const Eigen::Vector3d start = scene->initial_positions.segment<3>(3 * nodes[i]);
    knots.middleRows<3>(3 * static_cast<Eigen::Index>(i)) << start, start + Eigen::Vector3d(0.01, 0.02, 0.01);
  }
  scene->handles.path = HandlePath(Eigen::Vector2d(scene->start_time, scene->start_time + scene->duration), knots);
}

// The draped cloth with all terms of the air in a gusty wind.
Scene AirScene(const AirParam& param) {
  Scene scene = ShippedScene("drape", 6);
  std::tie(scene.integrator, scene.contact_mode, scene.air_law) = param;
  scene.duration = 0.4;
  scene.material.bending_stiffness = 1e-4;
  scene.material.drag = 0.05;
  scene.material.damping = 0.02;
  scene.material.normal_drag = 0.3;
  scene.material.tangential_drag = 0.08;
  scene.material.added_mass = 0.05;
  scene.material.pressure = 0.4;
  scene.wind.mean = {0.4, 0.3, -0.2};
  scene.wind.gust = {0.3, -0.4, 0.2};
  scene.wind.frequency = 9.0;
  scene.wind.phase = 0.4;
  scene.wind.wave_vector = {3.0, 2.0, 1.0};
  scene.wind.shear = {0.9, -0.48, 0.18};
  scene.wind.profile.times = Eigen::Vector3d(0.0, 0.2, 0.4);
  scene.wind.profile.velocities.resize(3, 3);
  scene.wind.profile.velocities << 0.1, -0.2, 0.3, 0.0, 0.2, 0.1, 0.1, 0.1, -0.3;
  scene.solver.step_tolerance = 1e-12;
  MoveHandles(&scene);
  return scene;
}

class AirCase {
 public:
  explicit AirCase(const AirParam& param)
      : scene_(AirScene(param)), simulator_(scene_), parameters_(scene_.nominal_parameters()) {
    for (const char* name :
         {"drag_normal",  "drag_tangential", "added_mass",     "drag",       "density",     "wind.x",
          "wind.y",       "wind.z",          "wind.x.1",       "wind.y.2",   "wind.z.3",    "gust.x",
          "gust.y",       "gust.z",          "gust.frequency", "gust.phase", "gust.wave.x", "gust.wave.y",
          "wind.shear.x", "wind.shear.y",    "pressure"}) {
      directions_.parameters.push_back(ParseParameter(name, scene_));
      names_.emplace_back(name);
    }
    MakeStartDirections();
    rollout_ = Perturbed(0, 0.0);
    EXPECT_TRUE(rollout_.ok()) << rollout_.failure->ToString();
    target_ = 0.95 * rollout_.initial_positions + Eigen::VectorXd::Constant(rollout_.initial_positions.size(), 0.02);
  }

  int num_directions() const { return static_cast<int>(names_.size()); }
  const std::string& name(int i) const { return names_[i]; }
  const Rollout& rollout() const { return rollout_; }

  Eigen::VectorXd Adjoint() {
    const RolloutGradient gradient = PullBack(
        rollout_, directions_.parameters, 1,
        [&](int step, Eigen::MatrixXd* seed) { seed->col(0) += rollout_.positions(step) - target_; }, &simulator_);
    Eigen::MatrixXd start = directions_.initial_positions;
    for (const int node : scene_.handles.nodes) start.middleRows<3>(3 * node).setZero();
    Eigen::VectorXd derivatives(num_directions());
    derivatives << gradient.parameters, start.transpose() * gradient.initial_positions +
                                            directions_.initial_velocities.transpose() * gradient.initial_velocities +
                                            directions_.handle_offsets.transpose() * gradient.handle_offsets;
    return derivatives;
  }

  Eigen::VectorXd Sensitivity() {
    const HandlePath offsets = Offsets(values_);
    SensitivityOptions options;
    options.initial_positions = &rollout_.initial_positions;
    options.handle_offsets = &offsets;
    Eigen::VectorXd sum = Eigen::VectorXd::Zero(num_directions());
    const SensitivityResult result = PushForward(
        parameters_, scene_.num_steps(), directions_,
        [&](int, const Eigen::VectorXd& x, const Eigen::MatrixXd& dx) { sum += dx.transpose() * (x - target_); },
        &simulator_, nullptr, options);
    EXPECT_FALSE(result.failure.has_value());
    return sum;
  }

  // The smallest relative error over step sizes at which both sides keep the branches of every contact, up to the first
  // that is within `tolerance`.
  double DifferenceError(int i, double derivative, double tolerance) {
    double best = 1.0;
    for (const double step : {1e-5, 1e-4, 3e-6, 1e-6, 1e-3, 3e-7}) {
      const Rollout plus = Perturbed(i, step), minus = Perturbed(i, -step);
      if (!HaveSameBranches(rollout_, plus) || !HaveSameBranches(rollout_, minus)) continue;
      const double difference = (Cost(plus) - Cost(minus)) / (2.0 * step);
      best = std::min(best, std::abs(difference - derivative) / std::abs(derivative));
      if (best <= tolerance) break;
    }
    return best;
  }

 private:
  // After the parameters: x_0, v_0, and the offsets of the handles with the start that goes with them.
  void MakeStartDirections() {
    names_.insert(names_.end(), {"x_0", "v_0", "offsets"});
    std::mt19937_64 generator(5);
    std::normal_distribution<double> normal;
    const auto random = [&](Eigen::Index rows, int column) {
      Eigen::MatrixXd columns = Eigen::MatrixXd::Zero(rows, 3);
      for (double& value : columns.col(column)) value = 0.05 + 0.1 * normal(generator);
      return columns;
    };
    const Eigen::Index num_handles = static_cast<Eigen::Index>(scene_.handles.nodes.size());
    values_ = Eigen::MatrixXd::NullaryExpr(3 * num_handles, kNumKnots, [&] { return 0.002 * normal(generator); });
    directions_.initial_positions = random(scene_.initial_positions.size(), 0);
    directions_.initial_velocities = random(scene_.initial_positions.size(), 1);
    for (const int node : scene_.handles.nodes) directions_.initial_velocities.middleRows<3>(3 * node).setZero();
    directions_.handle_offsets = random(values_.size(), 2);
  }

  Rollout Perturbed(int i, double step) {
    Parameters parameters = parameters_;
    Eigen::VectorXd start = Eigen::VectorXd::Zero(3);
    const int num_parameters = static_cast<int>(directions_.parameters.size());
    if (i < num_parameters) {
      SetParameter(directions_.parameters[i], GetParameter(parameters_, directions_.parameters[i]) + step, &parameters);
    } else {
      start[i - num_parameters] = step;
    }
    const HandlePath offsets =
        Offsets(values_ + (directions_.handle_offsets * start).reshaped(values_.rows(), values_.cols()));
    const Eigen::VectorXd positions = StartWith(offsets, directions_.initial_positions * start);
    const Eigen::VectorXd velocities = scene_.initial_velocities + directions_.initial_velocities * start;
    RolloutOptions options;
    options.initial_positions = &positions;
    options.initial_velocities = &velocities;
    options.handle_offsets = &offsets;
    return Simulate(parameters, scene_.num_steps(), &simulator_, nullptr, options);
  }

  HandlePath Offsets(const Eigen::MatrixXd& values) const {
    const double start = scene_.start_time, duration = scene_.duration;
    return HandlePath(Eigen::Vector3d(start, start + 0.4 * duration, start + duration), values);
  }

  Eigen::VectorXd StartWith(const HandlePath& offsets, const Eigen::VectorXd& change) const {
    Eigen::VectorXd positions = scene_.initial_positions + change;
    const Eigen::VectorXd handles = scene_.handles.path.At(scene_.start_time) + offsets.At(scene_.start_time);
    for (std::size_t i = 0; i < scene_.handles.nodes.size(); ++i) {
      positions.segment<3>(3 * scene_.handles.nodes[i]) = handles.segment<3>(3 * static_cast<Eigen::Index>(i));
    }
    return positions;
  }

  double Cost(const Rollout& rollout) const {
    double cost = 0.0;
    for (int step = 0; step <= rollout.num_steps(); ++step) {
      cost += 0.5 * (rollout.positions(step) - target_).squaredNorm();
    }
    return cost;
  }

  Scene scene_;
  Simulator simulator_;
  Parameters parameters_;
  Eigen::MatrixXd values_;  // [3H x kNumKnots]
  SensitivityDirections directions_;
  std::vector<std::string> names_;  // of the directions
  Rollout rollout_;
  Eigen::VectorXd target_;
};

class AirDerivativeTest : public ::testing::TestWithParam<AirParam> {};

TEST_P(AirDerivativeTest, AdjointEqualsSensitivityEqualsDifferences) {
  AirCase air(GetParam());
  ASSERT_FALSE(air.rollout().records.back().contacts.empty());
  const Eigen::VectorXd adjoint = air.Adjoint(), sensitivity = air.Sensitivity();
  for (int i = 0; i < air.num_directions(); ++i) {
    ASSERT_NE(adjoint[i], 0.0) << air.name(i);
    EXPECT_NEAR(adjoint[i], sensitivity[i], 1e-10 * std::abs(adjoint[i])) << air.name(i);
    EXPECT_LE(air.DifferenceError(i, adjoint[i], 1e-6), 1e-6) << air.name(i);
  }
}

std::string CaseName(const ::testing::TestParamInfo<AirParam>& info) {
  const auto [integrator, mode, law] = info.param;
  return std::string(IntegratorName(integrator)) + (mode == ContactMode::kGap ? "Gap" : "Velocity") +
         (law == AirLaw::kLinear ? "Linear" : "Quadratic");
}

INSTANTIATE_TEST_SUITE_P(Air, AirDerivativeTest,
                         ::testing::Combine(::testing::Values(Integrator::kEuler, Integrator::kSdirk2),
                                            ::testing::Values(ContactMode::kGap, ContactMode::kVelocity),
                                            ::testing::Values(AirLaw::kLinear, AirLaw::kQuadratic)),
                         CaseName);

}  // namespace
}  // namespace clothid::air_derivative_test
