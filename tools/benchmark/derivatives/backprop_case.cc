#include "tools/benchmark/derivatives/backprop_case.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "sim/base/error.h"

namespace clothid {
namespace {

constexpr double kLeastInfluence = 1e-8;  // |theta dC/dtheta| relative to C; rounding is far below
constexpr int kMostSteps = 20, kLeastSteps = 4, kNodesTimesSteps = 240;

constexpr std::size_t kFactorMemory = std::size_t{4} << 30;  // bytes

// `step_tolerance`: absent for the scene's.
Rollout SimulateCase(const BackpropCaseName& name, int num_steps, Simulator* simulator,
                     std::optional<double> step_tolerance = std::nullopt) {
  RolloutOptions options;
  options.step_tolerance = step_tolerance;
  options.factor_memory = kFactorMemory;
  Rollout rollout = Simulate(simulator->scene().nominal_parameters(), num_steps, simulator, nullptr, options);
  if (!rollout.ok()) throw Error(ErrorKind::kBadData, name.ToString() + ": " + rollout.failure->ToString());
  return rollout;
}

Scene WarmScene(const BackpropCaseName& name) {
  const BackpropSetting setting = FindBackpropSetting(name.setting);
  Scene scene = MakeBenchmarkScene(name.scene, name.nodes, setting.stretch_stiffness, setting.time_step);
  Simulator simulator(scene);
  const int num_steps = static_cast<int>(std::lround(kWarmUpSeconds / setting.time_step));
  const StepRecord last = SimulateCase(name, num_steps, &simulator).records.back();
  scene.initial_positions = last.positions;
  scene.initial_velocities = last.velocities;
  scene.start_time = last.time;
  return scene;
}

}  // namespace

std::vector<std::string> BackpropSettingNames() {
  std::vector<std::string> names;
  for (const BackpropSetting& setting : kBackpropSettings) names.push_back(setting.name);
  return names;
}

BackpropSetting FindBackpropSetting(const std::string& name) {
  RequireKnown({name}, BackpropSettingNames(), "--settings");
  return *std::find_if(kBackpropSettings.begin(), kBackpropSettings.end(),
                       [&name](const BackpropSetting& setting) { return setting.name == name; });
}

std::string BackpropCaseName::ToString() const {
  return scene + ", " + setting + ", " + std::to_string(nodes) + " x " + std::to_string(nodes) + " nodes";
}

double GradientErrors::Worst() const {
  double worst = x_0;
  for (const double error : {k_stretch, density, mu}) {
    if (!std::isnan(error)) worst = std::max(worst, error);
  }
  return worst;
}

BackpropCase::BackpropCase(BackpropCaseName name)
    : name_(std::move(name)),
      simulator_(WarmScene(name_)),
      ids_({{ParameterKind::kStretchStiffness}, {ParameterKind::kDensity}}) {
  if (!simulator_.scene().obstacles.empty()) ids_.push_back({ParameterKind::kFriction});
  SetRollout(SimulateCase(name_, name_.num_steps, &simulator_));
}

void BackpropCase::SetRollout(Rollout rollout) {
  rollout_ = std::move(rollout);
  cost_ = 0.0;
  for (int step = 1; step <= name_.num_steps; ++step) {
    cost_ += 0.5 * (rollout_.positions(step) - rollout_.initial_positions).squaredNorm();
  }
}

void BackpropCase::SimulateAgain() { SimulateCase(name_, name_.num_steps, &simulator_, rollout_.step_tolerance); }

void BackpropCase::SetStepTolerance(double tolerance) {
  SetRollout(SimulateCase(name_, name_.num_steps, &simulator_, tolerance));
}

RolloutGradient BackpropCase::Differentiate(const AdjointOptions& options, int num_columns) {
  const auto seed = [this](int step, Eigen::MatrixXd* gradient) {
    const Eigen::VectorXd distance = rollout_.positions(step) - rollout_.initial_positions;
    for (Eigen::Index j = 0; j < gradient->cols(); ++j) {
      gradient->col(j) += std::cos(static_cast<double>(j) * step) * distance;
    }
  };
  return PullBack(rollout_, ids_, num_columns, seed, &simulator_, options);
}

double BackpropCase::ParameterError(int index, const RolloutGradient& gradient,
                                    const RolloutGradient& reference) const {
  const double expected = reference.parameters(index, 0);
  if (std::abs(GetParameter(rollout_.parameters, ids_[index]) * expected) <= kLeastInfluence * cost_) return kNoNumber;
  return std::abs(gradient.parameters(index, 0) - expected) / std::abs(expected);
}

GradientErrors BackpropCase::Compare(const RolloutGradient& gradient, const RolloutGradient& reference) const {
  GradientErrors errors;
  errors.k_stretch = ParameterError(0, gradient, reference);
  errors.density = ParameterError(1, gradient, reference);
  errors.mu = ids_.size() > 2 ? ParameterError(2, gradient, reference) : kNoNumber;
  errors.x_0 = (gradient.initial_positions.col(0) - reference.initial_positions.col(0)).norm() /
               reference.initial_positions.col(0).norm();
  return errors;
}

void BackpropCaseOptions::Validate() const {
  RequireKnown(scenes, kBenchmarkScenes, "--scene");
  RequireKnown(settings, BackpropSettingNames(), "--settings");
  ExpectUsage(!nodes.empty(), "--nodes: expected at least one number");
  for (const int n : nodes) ExpectUsage(n >= 2, "--nodes: expected numbers >= 2");
  ExpectUsage(num_steps >= 0, "--steps: expected a number >= 1");
}

void ForEachCase(const BackpropCaseOptions& options, const std::function<void(BackpropCase*)>& visit) {
  const int num_cases = static_cast<int>(options.scenes.size() * options.settings.size() * options.nodes.size());
  int num_done = 0;
  for (const std::string& scene : options.scenes) {
    for (const std::string& setting : options.settings) {
      for (const int nodes : options.nodes) {
        const int num_steps =
            options.num_steps > 0 ? options.num_steps : std::clamp(kNodesTimesSteps / nodes, kLeastSteps, kMostSteps);
        BackpropCase backprop({scene, setting, nodes, num_steps});
        visit(&backprop);
        if (options.on_progress) options.on_progress(backprop.name().ToString(), ++num_done, num_cases);
      }
    }
  }
}

}  // namespace clothid
