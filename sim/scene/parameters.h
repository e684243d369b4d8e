// What a fit may change: the constants of the material, or of those of its pieces, the friction of the obstacles, the
// wind, and what belongs to a recording, and their names. What is known of each kind: sim/scene/parameter_table.h.
#ifndef CLOTHID_SIM_SCENE_PARAMETERS_H_
#define CLOTHID_SIM_SCENE_PARAMETERS_H_

#include <array>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "sim/air/wind.h"
#include "sim/path/placement.h"
#include "sim/scene/parameter_table.h"

namespace clothid {

struct FieldFactors;  // sim/scene/material_field.h

struct Parameters {
  Material material;
  std::vector<double> friction_coefficients;  // mu, one per obstacle of the scene
  // How constants of the material vary over the cloth: as many and of the same as the scene has. Null: they do not.
  std::shared_ptr<const std::vector<FieldFactors>> fields;
  Wind wind = {};  // its profile has the times of the scene's
  // What the rest shape of the scene is stretched by, along the two axes of its front (sim/rollout/sized_scene.h).
  std::array<double, 2> size = {1.0, 1.0};
  // How the paths of the obstacles are placed, one per obstacle of the scene. Empty: as the scene has them.
  std::vector<Placement> placements = {};

  Placement placement(int obstacle) const {
    return placements.empty() ? Placement() : placements.at(static_cast<std::size_t>(obstacle));
  }
  // Of each piece of the scene's mesh, then of the triangles in no piece [P + 1]. Empty: the cloth has no pieces. Where
  // it has, a constant of `material` is a level that no triangle need have; it is zero only where theirs all are.
  std::vector<Material> pieces = {};
  double self_friction = 0.0;  // mu of the cloth against itself, where the scene has self-contact
};

bool IsWind(ParameterKind kind);
bool IsSize(ParameterKind kind);
bool IsPlacement(ParameterKind kind);
bool IsOfRecording(ParameterKind kind);
bool IsFriction(ParameterKind kind);  // against obstacles or the cloth itself
// Whether a step depends on it by its contacts alone: friction, and how an obstacle's path is placed.
bool IsOfContact(ParameterKind kind);
// Whether `value` is finite and one that a parameter of this domain can have.
bool IsInDomain(ParameterDomain domain, double value);
const char* DomainWords(ParameterDomain domain);  // "a finite number > 0"

inline constexpr int kWhole = -1;

// One scalar of `Parameters`, or of a recording, or that of several parts at once. The row of its kind says which axes
// and parts there are.
struct ParameterId {
  ParameterKind kind = ParameterKind::kStretchStiffness;
  int axis = 0;  // 0, 1, 2: x, y, z
  // An obstacle, a piece or a knot of the wind, as the scene numbers them, or a group of handles, from 0 on; or kWhole:
  // all obstacles, the whole cloth, the mean wind, all handles.
  int part = kWhole;

  bool operator==(const ParameterId& other) const {
    return kind == other.kind && axis == other.axis && part == other.part;
  }
};

bool IsWindKnot(ParameterId id);  // of its profile

// Every axis of every kind of one term, as a whole, in the order of the table.
std::vector<ParameterId> ParametersOf(ParameterTerm term);
// Of the path of an obstacle: what `id` changes of how it is placed.
PlacementPart PlacementPartOf(ParameterId id);

// The parameter of a name; nothing for any other name:
// "k_stretch", "k_bend", "density", "drag", "damping"; "k_warp", "k_weft", "k_shear", "k_poisson", "stiffening_warp",
// "stiffening_weft"; "bend_warp", "bend_weft", "bend_twist"; "drag_normal", "drag_tangential", "added_mass",
// "pressure"; "mu" (every obstacle), "mu.NAME" (one of them), "mu.self" (of the cloth against itself); "wind.x",
// "wind.y", "wind.z" (the mean), "wind.x.1" (the first knot of the profile), .., "gust.x", "gust.y", "gust.z",
// "gust.frequency", "gust.phase", "gust.wave.x", .., "wind.shear.x",
// ..; "size.x", "size.y"; "NAME.time_offset", "NAME.shift.x", .., "NAME.turn.x", .. of the path of an obstacle;
// "k_stretch.NAME", .. of one piece (without, of the whole cloth); and of a recording "time_offset", "shift.x", ..,
// "turn.x", .., "v0.x", .., "handle_shift.x", .. of all handles, "handle_shift1.x", .. of their first group, ..,
// "handle_turn.x", .., "force_bias.x", .. of the first group, "force_bias2.x", .. of the second, ... `obstacle_names`
// are the scene's, `piece_names` its mesh's, in their order.
std::optional<ParameterId> FindParameter(const std::string& name, const std::vector<std::string>& obstacle_names = {},
                                         const std::vector<std::string>& piece_names = {});
// The same, of those of scenes alone. Throws `Error` (kUsage) that lists the names it would accept. `ParseParameter` in
// sim/scene/scene.h also asks whether a scene has the parameter, that in costs/prediction/parameter_block.h knows those
// of recordings, too.
ParameterId ParseParameter(const std::string& name, const std::vector<std::string>& obstacle_names,
                           const std::vector<std::string>& piece_names = {});
// The names that are accepted, "k_stretch, k_bend, .., mu.ball, wind.x, ..", less those of kinds for which `has` is
// false, of knots and of placements; those of pieces in short.
std::string ParameterNames(const std::vector<std::string>& obstacle_names,
                           const std::function<bool(ParameterKind)>& has,
                           const std::vector<std::string>& piece_names = {});
std::string ParameterName(ParameterId id, const std::vector<std::string>& obstacle_names,
                          const std::vector<std::string>& piece_names = {});
// Whether setting `whole` sets `part` too: it is the same, or the friction of all obstacles that of one, or a constant
// of all pieces that of one.
bool Includes(ParameterId whole, ParameterId part);

// "mu=0.3, k_stretch=300" -> {{"k_stretch", 300}, {"mu", 0.3}}. Empty text: empty map. Throws `Error` (kUsage), naming
// `flag`, unless every item is NAME=NUMBER with a finite number and every name is there once. The names may be any.
std::map<std::string, double> ParseParameterValues(const std::string& text, const std::string& flag);

// The value of `id`. For the friction of all obstacles: that of the first; NaN where there is no obstacle. For a
// constant of all pieces: that of `material`. Setting that sets those of all pieces. Throw `std::out_of_range` for an
// obstacle, a knot or a piece that the parameters do not have, `std::logic_error` for what belongs to a recording.
double GetParameter(const Parameters& parameters, ParameterId id);
void SetParameter(ParameterId id, double value, Parameters* parameters);

}  // namespace clothid

#endif  // CLOTHID_SIM_SCENE_PARAMETERS_H_
