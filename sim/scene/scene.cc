#include "sim/scene/scene.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <optional>
#include <set>
#include <sstream>
#include <utility>

#include "sim/base/error.h"
#include "sim/obstacle/affine_motion.h"
#include "sim/obstacle/surface_sequence.h"
#include "sim/obstacle/triangulated_surface.h"

namespace clothid {
namespace {

// A duration of a whole number of steps, computed in floating point, must not gain a step by rounding.
constexpr double kStepRounding = 1e-9;

void SetFields(const Scene& scene, Parameters* parameters) {
  auto fields = std::make_shared<std::vector<FieldFactors>>();
  for (const GridField& grid : scene.fields) {
    double level = 0.0;
    fields->push_back(FieldOverTriangles(grid, scene.mesh, &level));
    SetParameter({grid.kind}, level, parameters);
  }
  parameters->fields = std::move(fields);
}

// Whether a constant of `term` has a value other than 0, before or after what `parameters` say.
bool HasConstantOf(ParameterTerm term, const Scene& scene) {
  const Material nominal = scene.nominal_parameters().material;
  return std::any_of(MaterialKinds().begin(), MaterialKinds().end(), [&](ParameterKind kind) {
    const ParameterRow& row = RowOf(kind);
    return row.term == term && (scene.material.*row.constant != 0.0 || nominal.*row.constant != 0.0);
  });
}

}  // namespace

const char* IntegratorName(Integrator integrator) { return integrator == Integrator::kSdirk2 ? "sdirk2" : "euler"; }

bool IsLogarithmic(ParameterKind kind) { return !IsFriction(kind) && RowOf(kind).domain != ParameterDomain::kAny; }

int Scene::num_steps() const { return std::max(0, static_cast<int>(std::ceil(duration / time_step - kStepRounding))); }

std::vector<std::string> Scene::obstacle_names() const {
  std::vector<std::string> names;
  for (const SceneObstacle& obstacle : obstacles) names.push_back(obstacle.name);
  return names;
}

Parameters Scene::nominal_parameters() const {
  Parameters result;
  result.material = material;
  result.pieces = pieces;
  result.wind = wind;
  for (const SceneObstacle& obstacle : obstacles) {
    result.friction_coefficients.push_back(obstacle.friction_coefficient);
  }
  if (self_contact) result.self_friction = self_contact->friction_coefficient;
  if (!fields.empty()) SetFields(*this, &result);
  // In the order of the map "mu" comes before every "mu.NAME", so the special name overrides the general one; likewise
  // "k_stretch" and "k_stretch.NAME".
  const std::vector<std::string> names = obstacle_names();
  for (const auto& [name, range] : parameters) {
    if (!std::isnan(range.nominal)) SetParameter(ParseParameter(name, names, mesh.piece_names), range.nominal, &result);
  }
  return result;
}

void Scene::SetMaterials(const Parameters& parameters_of_both) {
  material = parameters_of_both.material;
  pieces = parameters_of_both.pieces;
}

bool Scene::has_bending() const { return bending.orthotropic || HasConstantOf(ParameterTerm::kBending, *this); }

bool Scene::has_drag() const { return HasConstantOf(ParameterTerm::kDrag, *this); }

bool Scene::has_directional_drag() const { return HasConstantOf(ParameterTerm::kDirectionalDrag, *this); }

bool Scene::has_damping() const { return HasConstantOf(ParameterTerm::kDamping, *this); }

bool Scene::has_moving_obstacles() const {
  return std::any_of(obstacles.begin(), obstacles.end(),
                     [](const SceneObstacle& obstacle) { return obstacle.moves(); });
}

std::shared_ptr<const Obstacle> SceneObstacle::ShapeAt(double time) const {
  if (path != nullptr) return std::make_shared<MovedShape>(shape, path->At(time).pose);
  if (sequence == nullptr) return shape;
  return std::make_shared<TriangulatedSurface>(sequence->MovedTo(sequence->At({}, time).pose));
}

SurfacesAt::SurfacesAt(const Scene& scene, double time) : scene_(scene) {
  for (const SceneObstacle& obstacle : scene.obstacles) shapes_.push_back(obstacle.ShapeAt(time));
}

SurfacePoint SurfacesAt::Nearest(const Eigen::Vector3d& position) const {
  SurfacePoint nearest;
  nearest.gap = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < shapes_.size(); ++i) {
    SurfacePoint surface = shapes_[i]->Closest(position);
    surface.gap -= scene_.obstacles[i].contact_distance;
    if (surface.gap < nearest.gap) nearest = surface;
  }
  return nearest;
}

bool Scene::has(ParameterKind kind) const {
  switch (RowOf(kind).need) {
    case ParameterNeed::kArapMembrane:
      return membrane == MembraneLaw::kArap;
    case ParameterNeed::kOrthotropicMembrane:
      return membrane != MembraneLaw::kArap;
    case ParameterNeed::kYarnMembrane:
      return membrane == MembraneLaw::kYarn;
    case ParameterNeed::kIsotropicBending:
      return !bending.orthotropic;
    case ParameterNeed::kOrthotropicBending:
      return bending.orthotropic;
    case ParameterNeed::kSelfContact:
      return self_contact.has_value();
    case ParameterNeed::kMovingObstacle:
      return has_moving_obstacles();
    case ParameterNeed::kNothing:
      break;
  }
  return true;
}

bool Scene::has(ParameterId id) const {
  if (!has(id.kind) || id.part == kWhole) return has(id.kind);
  switch (RowOf(id.kind).part) {
    case ParameterPart::kKnot:
      return id.part < wind.profile.num_knots();
    case ParameterPart::kPiece:
      return has_of_pieces(id.kind);
    default:
      return !IsPlacement(id.kind) || obstacles[static_cast<std::size_t>(id.part)].moves();
  }
}

bool Scene::has_term(ParameterKind kind) const {
  const ParameterRow& row = RowOf(kind);
  if (row.term == ParameterTerm::kBending) return has(kind) && has_bending();
  const bool is_always_there =
      row.constant == nullptr || row.term == ParameterTerm::kMembrane || row.term == ParameterTerm::kMass;
  return is_always_there ? has(kind) : HasConstantOf(row.term, *this);
}

bool Scene::has_of_pieces(ParameterKind kind) const {
  return !pieces.empty() && RowOf(kind).part == ParameterPart::kPiece && has(kind) &&
         std::none_of(fields.begin(), fields.end(), [kind](const GridField& field) { return field.kind == kind; });
}

std::vector<ParameterId> Scene::piece_parameters() const {
  std::vector<ParameterId> ids;
  for (int i = 0; i < static_cast<int>(mesh.piece_names.size()); ++i) {
    for (const ParameterKind kind : MaterialKinds()) {
      if (has_of_pieces(kind) && has_term(kind)) ids.push_back({kind, 0, i});
    }
  }
  return ids;
}

ParameterId ParseParameter(const std::string& name, const Scene& scene) {
  const std::vector<std::string> obstacles = scene.obstacle_names();
  const std::vector<std::string>& pieces = scene.mesh.piece_names;
  std::string names = ParameterNames(
      obstacles, [&](ParameterKind kind) { return scene.has(kind); }, pieces);
  for (const SceneObstacle& obstacle : scene.obstacles) {
    if (!obstacle.moves()) continue;
    for (const char* part : {".time_offset", ".shift.x (y, z)", ".turn.x (y, z)"}) {
      names.append(", ").append(obstacle.name).append(part);
    }
  }
  const std::optional<ParameterId> id = FindParameter(name, obstacles, pieces);
  const bool is_known = id && !IsOfRecording(id->kind);
  if (is_known && scene.has(*id)) return *id;
  throw Error(ErrorKind::kUsage,
              (is_known ? "parameter '" + name + "': the scene has no such term" : "unknown parameter '" + name + "'") +
                  "; expected one of " + names);
}

}  // namespace clothid
