#include "sim/scene/scene.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "sim/base/error.h"

namespace clothid {
namespace {

// A duration of a whole number of steps, computed in floating point, must not gain a step by rounding.
constexpr double kStepRounding = 1e-9;

// Collects the prefix of the messages of one scene.
class Checker {
 public:
  explicit Checker(const std::string& source) : source_(source) {}

  void Expect(bool condition, const std::string& key, const std::string& expected) const {
    if (!condition) throw Error(ErrorKind::kBadData, source_ + ": key '" + key + "': expected " + expected);
  }
  void ExpectPositive(double value, const std::string& key) const {
    Expect(std::isfinite(value) && value > 0.0, key, "a finite number > 0");
  }
  void ExpectNotNegative(double value, const std::string& key) const {
    Expect(std::isfinite(value) && value >= 0.0, key, "a finite number >= 0");
  }
  void ExpectFinite(const Eigen::VectorXd& values, const std::string& key) const {
    Expect(values.allFinite(), key, "finite numbers");
  }

 private:
  const std::string& source_;
};

void ValidateNumbers(const Scene& scene, const Checker& check) {
  check.ExpectPositive(scene.time_step, "time_step");
  check.ExpectPositive(scene.duration, "duration");
  check.Expect(scene.duration / scene.time_step <= kMaxSceneSteps, "duration",
               "at most " + std::to_string(kMaxSceneSteps) + " time steps");
  check.Expect(scene.num_steps() > 0, "duration", "at least a billionth of a time step");
  check.Expect(std::isfinite(scene.start_time), "start_time", "a finite number");
  check.ExpectFinite(scene.gravity, "gravity");
  check.ExpectFinite(scene.node_force, "node_force");
  check.ExpectFinite(scene.wind.mean, "wind.mean");
  check.ExpectFinite(scene.wind.gust, "wind.gust");
  check.Expect(std::isfinite(scene.wind.frequency), "wind.frequency", "a finite number");
  check.ExpectFinite(scene.wind.wave_vector, "wind.wave_vector");
  check.ExpectNotNegative(scene.touch, "touch");
  check.ExpectNotNegative(scene.depenetration_speed, "depenetration_speed");
  check.Expect(std::abs(scene.bending.poisson) < 1.0, "materials.bend_poisson", "a number between -1 and 1");
  check.Expect(scene.bending.law == BendingLaw::kPatches || scene.bending.poisson == 0.0, "materials.bend_poisson",
               "0, or bending by patches");
}

void ValidateSolver(const SolverOptions& solver, const Checker& check) {
  const auto is_tolerance = [](double value) { return value > 0.0 && value < 1.0; };
  check.Expect(is_tolerance(solver.step_tolerance), "solver.step_tolerance", "a number between 0 and 1");
  check.Expect(is_tolerance(solver.adjoint_tolerance), "solver.adjoint_tolerance", "a number between 0 and 1");
  check.Expect(solver.max_newton_iterations >= 1, "solver.max_newton_iterations", "an integer >= 1");
  check.Expect(solver.max_substep_halvings >= 0 && solver.max_substep_halvings <= 20, "solver.max_substep_halvings",
               "an integer from 0 to 20");
}

void ValidateState(const Scene& scene, const Checker& check) {
  const Eigen::Index size = 3 * static_cast<Eigen::Index>(scene.mesh.num_nodes());
  const std::string triple =
      "three finite numbers for each of the " + std::to_string(scene.mesh.num_nodes()) + " nodes";
  check.Expect(scene.initial_positions.size() == size && scene.initial_positions.allFinite(), "initial.positions",
               triple);
  check.Expect(scene.initial_velocities.size() == size && scene.initial_velocities.allFinite(), "initial.velocity",
               triple);
}

void ValidateHandles(const Scene& scene, const Checker& check) {
  const int num_nodes = scene.mesh.num_nodes();
  std::set<int> seen;
  for (const int node : scene.handles.nodes) {
    check.Expect(node >= 0 && node < num_nodes, "handles",
                 "nodes from 0 to " + std::to_string(num_nodes - 1) + ", found " + std::to_string(node));
    check.Expect(seen.insert(node).second, "handles", "every node once, found " + std::to_string(node) + " twice");
  }
  check.Expect(static_cast<int>(seen.size()) < num_nodes, "handles", "at least one node that is not a handle");
  const HandlePath& path = scene.handles.path;
  check.Expect(path.times().size() == 0 || path.num_handles() == static_cast<int>(scene.handles.nodes.size()),
               "handles.path", "a path for each of the " + std::to_string(scene.handles.nodes.size()) + " handles");
}

void ValidateObstacles(const Scene& scene, const Checker& check) {
  check.Expect(scene.obstacles.size() <= kMaxObstacles, "obstacles", "at most " + std::to_string(kMaxObstacles));
  std::set<std::string> names;
  for (std::size_t i = 0; i < scene.obstacles.size(); ++i) {
    const SceneObstacle& obstacle = scene.obstacles[i];
    const std::string key = "obstacles[" + std::to_string(i) + "]";
    check.Expect(obstacle.shape != nullptr, key, "a shape");
    check.Expect(!obstacle.name.empty() && names.insert(obstacle.name).second, key + ".name",
                 "a name that no other obstacle has");
    check.ExpectNotNegative(obstacle.friction_coefficient, key + ".mu");
    check.ExpectNotNegative(obstacle.contact_distance, key + ".contact_distance");
  }
}

// Absent values (NaN) compare as in order with everything.
void ValidateRange(const ParameterRange& range, const std::string& key, const Checker& check) {
  const auto check_value = [&](double value, const char* name) {
    check.Expect(std::isnan(value) || (std::isfinite(value) && value >= 0.0), key + name, "a finite number >= 0");
  };
  check_value(range.nominal, ".nominal");
  check_value(range.lower_bound, ".lower");
  check_value(range.upper_bound, ".upper");
  check.Expect(!(range.lower_bound >= range.upper_bound), key, "lower < upper");
  check.Expect(!(range.nominal < range.lower_bound) && !(range.nominal > range.upper_bound), key,
               "lower <= nominal <= upper");
}

void ValidateRanges(const Scene& scene, const Checker& check) {
  const std::vector<std::string> names = scene.obstacle_names();
  for (const auto& [name, range] : scene.parameters) {
    try {
      ParseParameter(name, names);
    } catch (const Error& error) {
      check.Expect(false, "parameters", std::string("known names: ") + error.what());
    }
    ValidateRange(range, "parameters." + name, check);
  }
}

}  // namespace

const char* IntegratorName(Integrator integrator) { return integrator == Integrator::kSdirk2 ? "sdirk2" : "euler"; }

int Scene::num_steps() const { return std::max(0, static_cast<int>(std::ceil(duration / time_step - kStepRounding))); }

std::vector<std::string> Scene::obstacle_names() const {
  std::vector<std::string> names;
  for (const SceneObstacle& obstacle : obstacles) names.push_back(obstacle.name);
  return names;
}

Parameters Scene::nominal_parameters() const {
  Parameters result;
  result.material = material;
  for (const SceneObstacle& obstacle : obstacles) {
    result.friction_coefficients.push_back(obstacle.friction_coefficient);
  }
  // In the order of the map "mu" comes before every "mu.NAME", so the special name overrides the general one.
  const std::vector<std::string> names = obstacle_names();
  for (const auto& [name, range] : parameters) {
    if (!std::isnan(range.nominal)) SetParameter(ParseParameter(name, names), range.nominal, &result);
  }
  return result;
}

bool Scene::has_bending() const {
  return material.bending_stiffness > 0.0 || nominal_parameters().material.bending_stiffness > 0.0;
}

bool Scene::has_drag() const { return material.drag > 0.0 || nominal_parameters().material.drag > 0.0; }

bool Scene::has_damping() const { return material.damping > 0.0 || nominal_parameters().material.damping > 0.0; }

void ValidateScene(const Scene& scene, const std::string& source) {
  const Checker check(source);
  ValidateNumbers(scene, check);
  ValidateSolver(scene.solver, check);
  ValidateMesh(scene.mesh, source);
  ValidateState(scene, check);
  ValidateHandles(scene, check);
  ValidateObstacles(scene, check);
  ValidateRanges(scene, check);
  ValidateParameters(scene.nominal_parameters(), scene, source);
}

void ValidateParameters(const Parameters& parameters, const Scene& scene, const std::string& source) {
  const auto expect = [&](double value, bool zero_allowed, const std::string& name) {
    if (std::isfinite(value) && (value > 0.0 || (zero_allowed && value == 0.0))) return;
    throw Error(ErrorKind::kBadData, source + ": parameter '" + name + "' is " + std::to_string(value) +
                                         "; expected a finite number " + (zero_allowed ? ">= 0" : "> 0"));
  };
  if (parameters.friction_coefficients.size() != scene.obstacles.size()) {
    throw Error(ErrorKind::kBadData, source + ": " + std::to_string(parameters.friction_coefficients.size()) +
                                         " friction coefficients for " + std::to_string(scene.obstacles.size()) +
                                         " obstacles");
  }
  expect(parameters.material.density, false, "density");
  expect(parameters.material.stretch_stiffness, false, "k_stretch");
  expect(parameters.material.bending_stiffness, true, "k_bend");
  expect(parameters.material.drag, true, "drag");
  expect(parameters.material.damping, true, "damping");
  const auto expect_absent = [&](double value, const std::string& name) {
    if (value == 0.0) return;
    throw Error(ErrorKind::kBadData, source + ": parameter '" + name + "' is " + std::to_string(value) +
                                         ", but the scene was set up without it; expected 0, or a scene that gives it");
  };
  if (!scene.has_bending()) expect_absent(parameters.material.bending_stiffness, "k_bend");
  if (!scene.has_drag()) expect_absent(parameters.material.drag, "drag");
  if (!scene.has_damping()) expect_absent(parameters.material.damping, "damping");
  for (std::size_t i = 0; i < scene.obstacles.size(); ++i) {
    expect(parameters.friction_coefficients[i], true, "mu." + scene.obstacles[i].name);
  }
}

}  // namespace clothid
