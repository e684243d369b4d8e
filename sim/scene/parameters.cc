#include "sim/scene/parameters.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <iterator>
#include <limits>
#include <optional>
#include <stdexcept>
#include <string_view>

#include "sim/base/error.h"
#include "sim/base/text_file.h"

namespace clothid {
namespace {

struct MaterialName {
  const char* name;
  ParameterKind kind;
  double Material::*constant;
  ParameterDomain domain;
};

constexpr MaterialName kMaterialNames[] = {
    {"k_stretch", ParameterKind::kStretchStiffness, &Material::stretch_stiffness, ParameterDomain::kPositive},
    {"k_bend", ParameterKind::kBendingStiffness, &Material::bending_stiffness, ParameterDomain::kNotNegative},
    {"density", ParameterKind::kDensity, &Material::density, ParameterDomain::kPositive},
    {"drag", ParameterKind::kDrag, &Material::drag, ParameterDomain::kNotNegative},
    {"damping", ParameterKind::kDamping, &Material::damping, ParameterDomain::kNotNegative},
    {"k_warp", ParameterKind::kWarpStiffness, &Material::warp_stiffness, ParameterDomain::kPositive},
    {"k_weft", ParameterKind::kWeftStiffness, &Material::weft_stiffness, ParameterDomain::kPositive},
    {"k_shear", ParameterKind::kShearStiffness, &Material::shear_stiffness, ParameterDomain::kPositive},
    {"k_poisson", ParameterKind::kPoissonStiffness, &Material::poisson_stiffness, ParameterDomain::kAny},
    {"bend_warp", ParameterKind::kWarpBending, &Material::warp_bending, ParameterDomain::kPositive},
    {"bend_weft", ParameterKind::kWeftBending, &Material::weft_bending, ParameterDomain::kPositive},
    {"bend_twist", ParameterKind::kTwistBending, &Material::twist_bending, ParameterDomain::kPositive},
    {"drag_normal", ParameterKind::kNormalDrag, &Material::normal_drag, ParameterDomain::kNotNegative},
    {"drag_tangential", ParameterKind::kTangentialDrag, &Material::tangential_drag, ParameterDomain::kNotNegative},
    {"added_mass", ParameterKind::kAddedMass, &Material::added_mass, ParameterDomain::kNotNegative}};

struct KindName {
  const char* name;
  ParameterKind kind;
};

constexpr KindName kWindNames[] = {{"wind.x", ParameterKind::kWindX},
                                   {"wind.y", ParameterKind::kWindY},
                                   {"wind.z", ParameterKind::kWindZ},
                                   {"gust.x", ParameterKind::kGustX},
                                   {"gust.y", ParameterKind::kGustY},
                                   {"gust.z", ParameterKind::kGustZ},
                                   {"gust.frequency", ParameterKind::kGustFrequency},
                                   {"gust.phase", ParameterKind::kGustPhase},
                                   {"gust.wave.x", ParameterKind::kGustWaveX},
                                   {"gust.wave.y", ParameterKind::kGustWaveY},
                                   {"gust.wave.z", ParameterKind::kGustWaveZ},
                                   {"wind.shear.x", ParameterKind::kWindShearX},
                                   {"wind.shear.y", ParameterKind::kWindShearY},
                                   {"wind.shear.z", ParameterKind::kWindShearZ}};

constexpr KindName kSizeNames[] = {{"size.x", ParameterKind::kSizeX}, {"size.y", ParameterKind::kSizeY}};

// After the name of an obstacle, in the order of PlacementPart.
constexpr KindName kPlacementNames[] = {{".time_offset", ParameterKind::kPathTimeOffset},
                                        {".shift.x", ParameterKind::kPathShiftX},
                                        {".shift.y", ParameterKind::kPathShiftY},
                                        {".shift.z", ParameterKind::kPathShiftZ},
                                        {".turn.x", ParameterKind::kPathTurnX},
                                        {".turn.y", ParameterKind::kPathTurnY},
                                        {".turn.z", ParameterKind::kPathTurnZ}};

constexpr std::string_view kFrictionPrefix = "mu.";
constexpr const char* kSelfFrictionName = "mu.self";

// Null for friction, wind, size and placements.
const MaterialName* FindKind(ParameterKind kind) {
  for (const MaterialName& material : kMaterialNames) {
    if (material.kind == kind) return &material;
  }
  return nullptr;
}

// 0, 1 or 2 of a component of the mean wind or its profile; -1 of another kind.
int WindAxis(ParameterKind kind) {
  return kind == ParameterKind::kWindX ? 0 : kind == ParameterKind::kWindY ? 1 : kind == ParameterKind::kWindZ ? 2 : -1;
}

// "wind.x", or "wind.x.1" of a knot.
std::optional<ParameterId> FindWind(std::string_view name) {
  for (const KindName& wind : kWindNames) {
    const std::string_view known = wind.name;
    if (name == known) return ParameterId{wind.kind};
    if (WindAxis(wind.kind) < 0 || name.substr(0, known.size()) != known) continue;
    const std::string_view rest = name.substr(known.size());
    const std::optional<long long> number = ParseInteger(rest.substr(std::min<std::size_t>(1, rest.size())));
    const bool is_knot = rest[0] == '.' && number && *number >= 1 && *number <= kMaxWindKnots;
    if (is_knot && rest == "." + std::to_string(*number)) {
      return ParameterId{wind.kind, kAllObstacles, static_cast<int>(*number - 1)};
    }
  }
  return std::nullopt;
}

// "NAME.shift.x".
std::optional<ParameterId> FindPlacement(const std::string& name, const std::vector<std::string>& obstacle_names) {
  for (std::size_t i = 0; i < obstacle_names.size(); ++i) {
    for (const KindName& placement : kPlacementNames) {
      if (name == obstacle_names[i] + placement.name) return ParameterId{placement.kind, static_cast<int>(i)};
    }
  }
  return std::nullopt;
}

// "k_stretch.NAME" of a piece.
std::optional<ParameterId> FindOfPiece(std::string_view name, const std::vector<std::string>& piece_names) {
  const std::size_t dot = name.find('.');
  if (dot == name.npos) return std::nullopt;
  const auto piece = std::find(piece_names.begin(), piece_names.end(), name.substr(dot + 1));
  if (piece == piece_names.end()) return std::nullopt;
  for (const MaterialName& material : kMaterialNames) {
    if (name.substr(0, dot) != material.name || !CanBeOfPiece(material.kind)) continue;
    return ParameterId{material.kind, kAllObstacles, kMeanWind, static_cast<int>(piece - piece_names.begin())};
  }
  return std::nullopt;
}

// The value that `id`, of a placement, names.
double& PlacementValue(ParameterKind kind, Placement* placement) {
  const int index = static_cast<int>(PartOf(kind));
  if (index == 0) return placement->time_offset;
  return index < static_cast<int>(PlacementPart::kTurnX)
             ? placement->shift[index - static_cast<int>(PlacementPart::kShiftX)]
             : placement->turn[index - static_cast<int>(PlacementPart::kTurnX)];
}

std::size_t SizeAxis(ParameterKind kind) { return kind == ParameterKind::kSizeX ? 0 : 1; }

// The value that `id`, of a wind, names.
double& WindValue(ParameterId id, Wind* wind) {
  switch (id.kind) {
    case ParameterKind::kGustX:
      return wind->gust.x();
    case ParameterKind::kGustY:
      return wind->gust.y();
    case ParameterKind::kGustZ:
      return wind->gust.z();
    case ParameterKind::kGustFrequency:
      return wind->frequency;
    case ParameterKind::kGustPhase:
      return wind->phase;
    case ParameterKind::kGustWaveX:
      return wind->wave_vector.x();
    case ParameterKind::kGustWaveY:
      return wind->wave_vector.y();
    case ParameterKind::kGustWaveZ:
      return wind->wave_vector.z();
    case ParameterKind::kWindShearX:
      return wind->shear.x();
    case ParameterKind::kWindShearY:
      return wind->shear.y();
    case ParameterKind::kWindShearZ:
      return wind->shear.z();
    default:
      break;
  }
  const int axis = WindAxis(id.kind);
  if (id.knot == kMeanWind) return wind->mean[axis];
  if (id.knot >= wind->profile.velocities.cols()) throw std::out_of_range("knot of the wind's profile");
  return wind->profile.velocities(axis, id.knot);
}

void SetConstant(ParameterId id, double value, Parameters* parameters) {
  double Material::*constant = MaterialConstant(id.kind);
  double& level = parameters->material.*constant;
  if (id.piece == kWholeCloth) {
    level = value;
    for (Material& piece : parameters->pieces) piece.*constant = value;
  } else {
    parameters->pieces.at(static_cast<std::size_t>(id.piece)).*constant = value;
    if (level == 0.0) level = value;
  }
}

}  // namespace

bool IsWind(ParameterKind kind) {
  return std::find(std::begin(kWindKinds), std::end(kWindKinds), kind) != std::end(kWindKinds);
}

bool CanBeOfPiece(ParameterKind kind) {
  return FindKind(kind) != nullptr && kind != ParameterKind::kNormalDrag && kind != ParameterKind::kTangentialDrag &&
         kind != ParameterKind::kAddedMass;
}

bool IsSize(ParameterKind kind) { return kind == ParameterKind::kSizeX || kind == ParameterKind::kSizeY; }

bool IsPlacement(ParameterKind kind) {
  return std::any_of(std::begin(kPlacementNames), std::end(kPlacementNames),
                     [kind](const KindName& placement) { return placement.kind == kind; });
}

bool IsFriction(ParameterKind kind) { return kind == ParameterKind::kFriction || kind == ParameterKind::kSelfFriction; }

bool IsOfContact(ParameterKind kind) { return IsFriction(kind) || IsPlacement(kind); }

PlacementPart PartOf(ParameterKind kind) {
  return static_cast<PlacementPart>(static_cast<int>(kind) - static_cast<int>(ParameterKind::kPathTimeOffset));
}

bool Material::operator==(const Material& other) const {
  static_assert(sizeof(Material) == std::size(kMaterialNames) * sizeof(double), "every constant is compared");
  return std::all_of(std::begin(kMaterialNames), std::end(kMaterialNames), [&](const MaterialName& material) {
    return this->*material.constant == other.*material.constant;
  });
}

ParameterDomain DomainOf(ParameterKind kind) {
  if (IsWind(kind) || IsPlacement(kind)) return ParameterDomain::kAny;
  if (IsSize(kind)) return ParameterDomain::kPositive;
  const MaterialName* material = FindKind(kind);
  return material != nullptr ? material->domain : ParameterDomain::kNotNegative;
}

bool IsInDomain(ParameterDomain domain, double value) {
  if (!std::isfinite(value)) return false;
  return domain == ParameterDomain::kAny || value > 0.0 || (domain == ParameterDomain::kNotNegative && value == 0.0);
}

const char* DomainWords(ParameterDomain domain) {
  switch (domain) {
    case ParameterDomain::kPositive:
      return "a finite number > 0";
    case ParameterDomain::kNotNegative:
      return "a finite number >= 0";
    case ParameterDomain::kAny:
      break;
  }
  return "a finite number";
}

double Material::*MaterialConstant(ParameterKind kind) {
  const MaterialName* material = FindKind(kind);
  return material != nullptr ? material->constant : nullptr;
}

std::string ParameterNames(const std::vector<std::string>& obstacle_names,
                           const std::function<bool(ParameterKind)>& has, const std::vector<std::string>& piece_names) {
  std::string names;
  for (const MaterialName& material : kMaterialNames) {
    if (has(material.kind)) names += std::string(material.name) + ", ";
  }
  names += "mu";
  for (const std::string& obstacle : obstacle_names) names.append(", ").append(kFrictionPrefix).append(obstacle);
  if (has(ParameterKind::kSelfFriction)) names.append(", ").append(kSelfFrictionName);
  for (const KindName& wind : kWindNames) {
    if (has(wind.kind)) names.append(", ").append(wind.name);
  }
  for (const KindName& size : kSizeNames) names.append(", ").append(size.name);
  if (piece_names.empty()) return names;
  names += "; with a piece behind a constant of the cloth, as in";
  for (const std::string& piece : piece_names) names += (piece == piece_names[0] ? " density." : ", density.") + piece;
  return names;
}

ParameterId ParseParameter(const std::string& name, const std::vector<std::string>& obstacle_names,
                           const std::vector<std::string>& piece_names) {
  for (const MaterialName& material : kMaterialNames) {
    if (name == material.name) return {material.kind, kAllObstacles};
  }
  if (const auto wind = FindWind(name)) return *wind;
  for (const KindName& size : kSizeNames) {
    if (name == size.name) return {size.kind};
  }
  if (name == "mu") return {ParameterKind::kFriction, kAllObstacles};
  if (name.compare(0, kFrictionPrefix.size(), kFrictionPrefix) == 0) {
    const auto found = std::find(obstacle_names.begin(), obstacle_names.end(), name.substr(kFrictionPrefix.size()));
    if (found != obstacle_names.end()) {
      return {ParameterKind::kFriction, static_cast<int>(found - obstacle_names.begin())};
    }
  }
  if (name == kSelfFrictionName) return {ParameterKind::kSelfFriction};
  if (const auto placement = FindPlacement(name, obstacle_names)) return *placement;
  if (const auto of_piece = FindOfPiece(name, piece_names)) return *of_piece;
  throw Error(ErrorKind::kUsage, "unknown parameter '" + name + "'; expected one of " +
                                     ParameterNames(
                                         obstacle_names, [](ParameterKind) { return true; }, piece_names));
}

std::string ParameterName(ParameterId id, const std::vector<std::string>& obstacle_names,
                          const std::vector<std::string>& piece_names) {
  for (const MaterialName& material : kMaterialNames) {
    if (id.kind != material.kind) continue;
    return id.piece == kWholeCloth
               ? material.name
               : std::string(material.name) + "." + piece_names.at(static_cast<std::size_t>(id.piece));
  }
  for (const KindName& size : kSizeNames) {
    if (id.kind == size.kind) return size.name;
  }
  for (const KindName& wind : kWindNames) {
    if (id.kind != wind.kind) continue;
    return id.knot == kMeanWind ? wind.name : std::string(wind.name) + "." + std::to_string(id.knot + 1);
  }
  for (const KindName& placement : kPlacementNames) {
    if (id.kind == placement.kind) return obstacle_names.at(static_cast<std::size_t>(id.obstacle)) + placement.name;
  }
  if (id.kind == ParameterKind::kSelfFriction) return kSelfFrictionName;
  if (id.obstacle == kAllObstacles) return "mu";
  return std::string(kFrictionPrefix) + obstacle_names.at(static_cast<std::size_t>(id.obstacle));
}

bool Includes(ParameterId whole, ParameterId part) {
  return whole.kind == part.kind && (whole.obstacle == kAllObstacles || whole.obstacle == part.obstacle) &&
         (whole.piece == kWholeCloth || whole.piece == part.piece);
}

std::map<std::string, double> ParseParameterValues(const std::string& text, const std::string& flag) {
  std::map<std::string, double> values;
  if (text.empty()) return values;
  for (const std::string& item : Split(text, ',')) {
    const std::size_t equals = item.find('=');
    const std::optional<double> value =
        equals == std::string::npos ? std::nullopt : ParseNumber(Trimmed(std::string_view(item).substr(equals + 1)));
    const std::string name(Trimmed(std::string_view(item).substr(0, equals)));
    if (name.empty() || !value) {
      throw Error(ErrorKind::kUsage, flag + ": expected NAME=NUMBER, a finite one, got '" + Printable(item) + "'");
    }
    if (!values.emplace(name, *value).second) {
      throw Error(ErrorKind::kUsage, flag + ": '" + Printable(name) + "' is given twice");
    }
  }
  return values;
}

double GetParameter(const Parameters& parameters, ParameterId id) {
  if (IsWind(id.kind)) {
    Wind wind = parameters.wind;
    return WindValue(id, &wind);
  }
  if (IsSize(id.kind)) return parameters.size[SizeAxis(id.kind)];
  if (IsPlacement(id.kind)) {
    Placement placement = parameters.placement(id.obstacle);
    return PlacementValue(id.kind, &placement);
  }
  if (id.kind == ParameterKind::kSelfFriction) return parameters.self_friction;
  if (id.kind != ParameterKind::kFriction) {
    const bool is_whole = id.piece == kWholeCloth;
    const Material& material =
        is_whole ? parameters.material : parameters.pieces.at(static_cast<std::size_t>(id.piece));
    return material.*MaterialConstant(id.kind);
  }
  const std::vector<double>& mu = parameters.friction_coefficients;
  if (mu.empty()) return std::numeric_limits<double>::quiet_NaN();
  return id.obstacle == kAllObstacles ? mu.front() : mu.at(static_cast<std::size_t>(id.obstacle));
}

void SetParameter(ParameterId id, double value, Parameters* parameters) {
  std::vector<double>& mu = parameters->friction_coefficients;
  if (IsWind(id.kind)) {
    WindValue(id, &parameters->wind) = value;
  } else if (IsSize(id.kind)) {
    parameters->size[SizeAxis(id.kind)] = value;
  } else if (IsPlacement(id.kind)) {
    if (parameters->placements.empty()) parameters->placements.resize(mu.size());
    PlacementValue(id.kind, &parameters->placements.at(static_cast<std::size_t>(id.obstacle))) = value;
  } else if (id.kind == ParameterKind::kSelfFriction) {
    parameters->self_friction = value;
  } else if (id.kind != ParameterKind::kFriction) {
    SetConstant(id, value, parameters);
  } else if (id.obstacle == kAllObstacles) {
    std::fill(mu.begin(), mu.end(), value);
  } else {
    mu.at(static_cast<std::size_t>(id.obstacle)) = value;
  }
}

}  // namespace clothid
