// What a scene and its parameters have to be (scene.h).
#include <algorithm>
#include <cmath>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "sim/base/error.h"
#include "sim/scene/pieces.h"
#include "sim/scene/scene.h"

namespace clothid {
namespace {

// Of the size of a cloth at rest, in shares of what the scene says.
constexpr double kLeastSize = 0.1, kMostSize = 10.0;
// What a field may make of a constant: a factor of 1e26 or its inverse.
constexpr double kMaxLogFactor = 60.0;

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
  check.ExpectNotNegative(scene.touch, "touch");
  check.ExpectNotNegative(scene.depenetration_speed, "depenetration_speed");
  check.Expect(std::abs(scene.bending.poisson) < 1.0, "materials.bend_poisson", "a number between -1 and 1");
  check.Expect(scene.bending.law == BendingLaw::kPatches || scene.bending.poisson == 0.0, "materials.bend_poisson",
               "0, or bending by patches");
  check.Expect(scene.bending.law == BendingLaw::kPatches || !scene.bending.orthotropic, "materials.bending",
               "bending by patches where it is orthotropic");
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
  const std::size_t num_clamped = scene.handles.clamped.size();
  check.Expect(scene.handles.slopes.num_handles() == static_cast<int>(num_clamped), "handles.slopes",
               "a slope for each of the " + std::to_string(num_clamped) + " clamped edges");
  for (const ClampedEdge& edge : scene.handles.clamped) {
    const bool are_handles = seen.count(edge.nodes[0]) + seen.count(edge.nodes[1]) == 2;
    check.Expect(are_handles && edge.face >= 0 && edge.face < scene.mesh.num_faces(), "handles.clamped",
                 "edges of the cloth between handles");
  }
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

void ValidateSelfContact(const Scene& scene, const Checker& check) {
  if (!scene.self_contact) return;
  check.ExpectNotNegative(scene.self_contact->friction_coefficient, "self_contact.mu");
  check.ExpectPositive(scene.self_contact->thickness, "self_contact.thickness");
  check.Expect(scene.contact_mode == ContactMode::kGap, "self_contact", "contact by \"gap\"");
  for (const SceneObstacle& obstacle : scene.obstacles) {
    check.Expect(obstacle.name != "self", "obstacles", "another name than \"self\", which is the cloth's");
  }
}

// Absent values (NaN) compare as in order with everything.
void ValidateRange(const ParameterRange& range, ParameterDomain domain, const std::string& key, const Checker& check) {
  const ParameterDomain bounds = domain == ParameterDomain::kPositive ? ParameterDomain::kNotNegative : domain;
  const auto check_value = [&](double value, const char* name) {
    check.Expect(std::isnan(value) || IsInDomain(bounds, value), key + name, DomainWords(bounds));
  };
  check_value(range.nominal, ".nominal");
  check_value(range.lower_bound, ".lower");
  check_value(range.upper_bound, ".upper");
  check.Expect(!(range.lower_bound >= range.upper_bound), key, "lower < upper");
  check.Expect(!(range.nominal < range.lower_bound) && !(range.nominal > range.upper_bound), key,
               "lower <= nominal <= upper");
}

void ValidatePrior(const ParameterRange& range, ParameterKind kind, const std::string& key, const Checker& check) {
  const ParameterPrior& prior = range.prior;
  if (!prior.is_given() && std::isnan(prior.spread)) return;
  const ParameterDomain domain = IsLogarithmic(kind) ? ParameterDomain::kPositive : RowOf(kind).domain;
  check.Expect(IsInDomain(domain, prior.center), key + ".center", DomainWords(domain));
  const double least = IsLogarithmic(kind) ? 1.0 : 0.0;
  check.Expect(std::isfinite(prior.spread) && prior.spread > least, key + ".spread",
               IsLogarithmic(kind) ? "a factor > 1" : "a standard deviation > 0");
  check.Expect(!range.frozen, key, "none of a parameter that is frozen");
}

void ValidateRanges(const Scene& scene, const Checker& check) {
  for (const auto& [name, range] : scene.parameters) {
    ParameterId id;
    try {
      id = ParseParameter(name, scene);
    } catch (const Error& error) {
      check.Expect(false, "parameters", std::string("known names: ") + error.what());
    }
    ValidateRange(range, RowOf(id.kind).domain, "parameters." + name, check);
    ValidatePrior(range, id.kind, "parameters." + name + ".prior", check);
  }
}

// Refuses `value` of a parameter.
[[noreturn]] void Refuse(const std::string& source, const std::string& name, double value,
                         const std::string& expected) {
  throw Error(ErrorKind::kBadData, source + ": parameter '" + name + "' is " + std::to_string(value) + expected);
}

void ValidateMaterial(const Parameters& parameters, const Scene& scene, const std::string& source) {
  for (const ParameterKind kind : MaterialKinds()) {
    const double value = parameters.material.*RowOf(kind).constant;
    const std::string name = ParameterName({kind}, {});
    if (scene.has(kind) && !IsInDomain(RowOf(kind).domain, value)) {
      Refuse(source, name, value, std::string("; expected ") + DomainWords(RowOf(kind).domain));
    }
    if (scene.has_term(kind) || value == 0.0 || kind == ParameterKind::kStretchStiffness) continue;
    Refuse(source, name, value, ", but the scene was set up without it; expected 0, or a scene that gives it");
  }
}

void ValidateFriction(const Parameters& parameters, const Scene& scene, const std::string& source) {
  if (parameters.friction_coefficients.size() != scene.obstacles.size()) {
    throw Error(ErrorKind::kBadData, source + ": " + std::to_string(parameters.friction_coefficients.size()) +
                                         " friction coefficients for " + std::to_string(scene.obstacles.size()) +
                                         " obstacles");
  }
  const auto expect_friction = [&](double mu, const std::string& name) {
    if (!IsInDomain(ParameterDomain::kNotNegative, mu)) Refuse(source, name, mu, "; expected a finite number >= 0");
  };
  for (std::size_t i = 0; i < scene.obstacles.size(); ++i) {
    expect_friction(parameters.friction_coefficients[i], "mu." + scene.obstacles[i].name);
  }
  expect_friction(parameters.self_friction, ParameterName({ParameterKind::kSelfFriction}, {}));
}

void ValidatePlacements(const Parameters& parameters, const Scene& scene, const std::string& source) {
  const std::vector<Placement>& placements = parameters.placements;
  bool fit = placements.empty() || placements.size() == scene.obstacles.size();
  for (std::size_t i = 0; fit && i < placements.size(); ++i) {
    fit = (scene.obstacles[i].moves() || placements[i] == Placement()) && std::isfinite(placements[i].time_offset) &&
          placements[i].shift.allFinite() && placements[i].turn.allFinite();
  }
  if (!fit) throw Error(ErrorKind::kBadData, source + ": expected finite placements of obstacles that move");
}

void ValidateFactors(const Parameters& parameters, const Scene& scene, const std::string& source) {
  if (parameters.fields == nullptr) return;
  bool fit = parameters.fields->size() == scene.fields.size();
  for (std::size_t i = 0; fit && i < scene.fields.size(); ++i) {
    const FieldFactors& field = (*parameters.fields)[i];
    fit = field.kind == scene.fields[i].kind && field.log_factors.size() == scene.mesh.num_faces() &&
          field.log_factors.allFinite() && field.log_factors.cwiseAbs().maxCoeff() <= kMaxLogFactor;
  }
  if (fit) return;
  throw Error(ErrorKind::kBadData,
              source + ": expected the fields of the scene, a factor of 1e-26 to 1e26 per triangle");
}

// Fields of a membrane with warp and weft: E stays bounded from below at every triangle.
void ValidateMembraneFields(const Scene& scene, const Checker& check) {
  const Material& material = scene.material;
  double warp = material.warp_stiffness, weft = material.weft_stiffness;  // the least
  for (const GridField& field : scene.fields) {
    const ParameterRow& row = RowOf(field.kind);
    if (row.need != ParameterNeed::kOrthotropicMembrane) continue;
    check.Expect(scene.pieces.empty(), std::string("fields.") + row.name, "none in a scene with pieces");
    if (field.kind == ParameterKind::kWarpStiffness) warp = field.values.minCoeff();
    if (field.kind == ParameterKind::kWeftStiffness) weft = field.values.minCoeff();
  }
  check.Expect(scene.fields.empty() || !scene.has(ParameterKind::kPoissonStiffness) ||
                   material.poisson_stiffness * material.poisson_stiffness < warp * weft,
               "fields", "k_poisson^2 < k_warp k_weft where these are least");
}

}  // namespace

void ValidateScene(const Scene& scene, const std::string& source) {
  const Checker check(source);
  ValidateNumbers(scene, check);
  ValidateWind(scene.wind, source);
  ValidateSolver(scene.solver, check);
  ValidateMesh(scene.mesh, source);
  if (scene.has_warp()) ValidateWarp(scene.warp, scene.mesh, source);
  ValidateState(scene, check);
  if (!scene.fields.empty()) ValidateFields(scene.fields, scene.mesh, source);
  for (const GridField& field : scene.fields) {
    const std::string name = ParameterName({field.kind}, {});
    check.Expect(scene.has(field.kind), "fields." + name, "none, as the law of the scene has no such constant");
  }
  ValidateMembraneFields(scene, check);
  ValidatePieces(scene, source);
  ValidateHandles(scene, check);
  ValidateObstacles(scene, check);
  ValidateSelfContact(scene, check);
  ValidateRanges(scene, check);
  if (scene.nominal_parameters().size != Parameters().size) FrontAxes(scene.mesh, source);
  ValidateParameters(scene.nominal_parameters(), scene, source);
}

void ValidateDomains(const Parameters& parameters, const Scene& scene, const std::string& source) {
  ValidateFriction(parameters, scene, source);
  ValidateMaterial(parameters, scene, source);
  ValidatePlacements(parameters, scene, source);
  for (const ParameterId id : ParametersOf(ParameterTerm::kSize)) {
    const double factor = GetParameter(parameters, id);
    if (factor >= kLeastSize && factor <= kMostSize) continue;
    Refuse(source, ParameterName(id, {}), factor, "; expected a factor from 0.1 to 10");
  }
  ValidateFactors(parameters, scene, source);
  ValidatePieceMaterials(parameters, scene, source);
  ValidateWind(parameters.wind, source);
  if (parameters.wind.profile.times != scene.wind.profile.times) {
    throw Error(ErrorKind::kBadData, source + ": expected a wind with the times of the scene's profile");
  }
}

namespace {

std::string Indefinite(const Material& material, const Scene& scene) {
  const auto compare = [](const std::string& coupling, double value, const std::string& names, double product) {
    std::ostringstream text;
    text << coupling << "^2 must be below " << names << ", and is " << value * value << ", not below " << product;
    return text.str();
  };
  if (scene.membrane != MembraneLaw::kArap) {
    const double poisson = material.poisson_stiffness, product = material.warp_stiffness * material.weft_stiffness;
    if (!(poisson * poisson < product)) return compare("k_poisson", poisson, "k_warp k_weft", product);
  }
  if (scene.bending.orthotropic) {
    const double coupling = 0.5 * scene.bending.poisson * (material.warp_bending + material.weft_bending);
    const double product = material.warp_bending * material.weft_bending;
    if (!(coupling * coupling < product)) {
      return compare("(bend_poisson (bend_warp + bend_weft)/2)", coupling, "bend_warp bend_weft", product);
    }
  }
  return "";
}

}  // namespace

std::string Indefinite(const Parameters& parameters, const Scene& scene) {
  std::string problem = parameters.pieces.empty() ? Indefinite(parameters.material, scene) : "";
  for (std::size_t i = 0; i < parameters.pieces.size() && problem.empty(); ++i) {
    problem = Indefinite(parameters.pieces[i], scene);
    if (!problem.empty() && i < scene.mesh.piece_names.size()) {
      problem = "in piece '" + scene.mesh.piece_names[i] + "' " + problem;
    }
  }
  return problem;
}

void ValidateParameters(const Parameters& parameters, const Scene& scene, const std::string& source) {
  ValidateDomains(parameters, scene, source);
  const std::string problem = Indefinite(parameters, scene);
  if (!problem.empty()) throw Error(ErrorKind::kBadData, source + ": " + problem);
}

}  // namespace clothid
