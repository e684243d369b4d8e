#include "sim/scene/parameters.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <optional>
#include <stdexcept>
#include <string_view>

#include "sim/base/error.h"
#include "sim/base/text_file.h"

namespace clothid {
namespace {

constexpr std::string_view kAxes = "xyz";
constexpr int kMostHandleGroups = 1000;

using Names = std::vector<std::string>;

// The number in "wind.x.12" or "handle_shift2.y"; 1 where there is none that these may have.
int NumberIn(std::string_view name, ParameterPart part) {
  const std::size_t first = std::min(name.find_first_of("0123456789"), name.size());
  const std::optional<long long> number = ParseInteger(name.substr(first, name.find('.', first) - first));
  const int most = part == ParameterPart::kKnot ? kMaxWindKnots : kMostHandleGroups;
  return number && *number >= 1 && *number <= most ? static_cast<int>(*number) : 1;
}

// The parts that `name` may be of, if it is one of the row.
std::vector<int> PartsIn(const std::string& name, const ParameterRow& row, const Names& obstacles,
                         const Names& pieces) {
  std::vector<int> parts;
  if (row.has_whole) parts.push_back(kWhole);
  const auto add_all = [&parts](const Names& names) {
    for (std::size_t i = 0; i < names.size(); ++i) parts.push_back(static_cast<int>(i));
  };
  switch (row.part) {
    case ParameterPart::kNone:
      break;
    case ParameterPart::kObstacle:
      add_all(obstacles);
      break;
    case ParameterPart::kPiece:
      add_all(pieces);
      break;
    case ParameterPart::kKnot:
    case ParameterPart::kHandleGroup:
      parts.push_back(NumberIn(name, row.part) - 1);
      break;
  }
  return parts;
}

// The value that `id`, of a placement, names.
double& PlacementValue(ParameterId id, Placement* placement) {
  if (id.kind == ParameterKind::kPathTimeOffset) return placement->time_offset;
  return (id.kind == ParameterKind::kPathShift ? placement->shift : placement->turn)[id.axis];
}

// The value that `id`, of a wind, names.
double& WindValue(ParameterId id, Wind* wind) {
  const ParameterRow& row = RowOf(id.kind);
  if (row.wind_number != nullptr) return wind->*row.wind_number;
  if (id.part == kWhole) return (wind->*row.wind_vector)[id.axis];
  if (id.part >= wind->profile.velocities.cols()) throw std::out_of_range("knot of the wind's profile");
  return wind->profile.velocities(id.axis, id.part);
}

// The constant of the material that `id` names.
double Material::*ConstantOf(ParameterId id) {
  double Material::*const constant = RowOf(id.kind).constant;
  if (constant == nullptr) throw std::logic_error("a parameter that a scene does not have");
  return constant;
}

void SetConstant(ParameterId id, double value, Parameters* parameters) {
  double Material::*const constant = ConstantOf(id);
  double& level = parameters->material.*constant;
  if (id.part == kWhole) {
    level = value;
    for (Material& piece : parameters->pieces) piece.*constant = value;
  } else {
    parameters->pieces.at(static_cast<std::size_t>(id.part)).*constant = value;
    if (level == 0.0) level = value;
  }
}

}  // namespace

bool IsWind(ParameterKind kind) { return RowOf(kind).term == ParameterTerm::kWind; }

bool IsSize(ParameterKind kind) { return RowOf(kind).term == ParameterTerm::kSize; }

bool IsPlacement(ParameterKind kind) { return RowOf(kind).term == ParameterTerm::kPlacement; }

bool IsOfRecording(ParameterKind kind) { return RowOf(kind).term >= ParameterTerm::kClock; }

bool IsFriction(ParameterKind kind) { return kind == ParameterKind::kFriction || kind == ParameterKind::kSelfFriction; }

bool IsOfContact(ParameterKind kind) { return IsFriction(kind) || IsPlacement(kind); }

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

bool IsWindKnot(ParameterId id) { return RowOf(id.kind).part == ParameterPart::kKnot && id.part != kWhole; }

std::vector<ParameterId> ParametersOf(ParameterTerm term) {
  std::vector<ParameterId> ids;
  for (const ParameterRow& row : ParameterTable()) {
    for (int axis = 0; row.term == term && axis < std::max(1, row.num_axes); ++axis) ids.push_back({row.kind, axis});
  }
  return ids;
}

PlacementPart PlacementPartOf(ParameterId id) {
  return static_cast<PlacementPart>(static_cast<int>(RowOf(id.kind).placement) + id.axis);
}

std::string ParameterNames(const Names& obstacle_names, const std::function<bool(ParameterKind)>& has,
                           const Names& piece_names) {
  std::string names;
  const auto add = [&names](const std::string& name) { names.append(names.empty() ? "" : ", ").append(name); };
  for (const ParameterRow& row : ParameterTable()) {
    if (IsPlacement(row.kind) || IsOfRecording(row.kind)) continue;
    const bool is_always_told = row.term == ParameterTerm::kFriction || row.term == ParameterTerm::kSize;
    if (!is_always_told && !has(row.kind)) continue;
    for (int axis = 0; axis < std::max(1, row.num_axes); ++axis) add(ParameterName({row.kind, axis}, {}));
    if (row.part != ParameterPart::kObstacle) continue;
    for (std::size_t i = 0; i < obstacle_names.size(); ++i) {
      add(ParameterName({row.kind, 0, static_cast<int>(i)}, obstacle_names));
    }
  }
  if (piece_names.empty()) return names;
  names += "; with a piece behind a constant of the cloth, as in";
  for (const std::string& piece : piece_names) names += (piece == piece_names[0] ? " density." : ", density.") + piece;
  return names;
}

std::optional<ParameterId> FindParameter(const std::string& name, const Names& obstacle_names,
                                         const Names& piece_names) {
  for (const ParameterRow& row : ParameterTable()) {
    for (const int part : PartsIn(name, row, obstacle_names, piece_names)) {
      for (int axis = 0; axis < std::max(1, row.num_axes); ++axis) {
        const ParameterId id = {row.kind, axis, part};
        if (ParameterName(id, obstacle_names, piece_names) == name) return id;
      }
    }
  }
  return std::nullopt;
}

ParameterId ParseParameter(const std::string& name, const Names& obstacle_names, const Names& piece_names) {
  const std::optional<ParameterId> id = FindParameter(name, obstacle_names, piece_names);
  if (id && !IsOfRecording(id->kind)) return *id;
  throw Error(ErrorKind::kUsage, "unknown parameter '" + name + "'; expected one of " +
                                     ParameterNames(
                                         obstacle_names, [](ParameterKind) { return true; }, piece_names));
}

std::string ParameterName(ParameterId id, const Names& obstacle_names, const Names& piece_names) {
  const ParameterRow& row = RowOf(id.kind);
  const auto part = static_cast<std::size_t>(id.part);
  std::string name = row.name;
  if (IsPlacement(id.kind)) name = obstacle_names.at(part) + name;
  const int unnamed = row.has_whole ? kWhole : 0;
  if (row.part == ParameterPart::kHandleGroup && id.part > unnamed) name += std::to_string(id.part + 1);
  if (row.num_axes > 0) name.append(".").append(kAxes.substr(static_cast<std::size_t>(id.axis), 1));
  if (id.part == kWhole || !row.has_whole) return name;
  if (row.part == ParameterPart::kObstacle) return name + "." + obstacle_names.at(part);
  if (row.part == ParameterPart::kPiece) return name + "." + piece_names.at(part);
  return row.part == ParameterPart::kKnot ? name + "." + std::to_string(id.part + 1) : name;
}

bool Includes(ParameterId whole, ParameterId part) {
  return whole.kind == part.kind && whole.axis == part.axis && (whole.part == kWhole || whole.part == part.part);
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
  switch (RowOf(id.kind).term) {
    case ParameterTerm::kWind: {
      Wind wind = parameters.wind;
      return WindValue(id, &wind);
    }
    case ParameterTerm::kSize:
      return parameters.size[static_cast<std::size_t>(id.axis)];
    case ParameterTerm::kPlacement: {
      Placement placement = parameters.placement(id.part);
      return PlacementValue(id, &placement);
    }
    case ParameterTerm::kSelfFriction:
      return parameters.self_friction;
    case ParameterTerm::kFriction: {
      const std::vector<double>& mu = parameters.friction_coefficients;
      if (mu.empty()) return std::numeric_limits<double>::quiet_NaN();
      return id.part == kWhole ? mu.front() : mu.at(static_cast<std::size_t>(id.part));
    }
    default:  // of the material
      break;
  }
  return (id.part == kWhole ? parameters.material : parameters.pieces.at(static_cast<std::size_t>(id.part))).*
         ConstantOf(id);
}

void SetParameter(ParameterId id, double value, Parameters* parameters) {
  std::vector<double>& mu = parameters->friction_coefficients;
  switch (RowOf(id.kind).term) {
    case ParameterTerm::kWind:
      WindValue(id, &parameters->wind) = value;
      return;
    case ParameterTerm::kSize:
      parameters->size[static_cast<std::size_t>(id.axis)] = value;
      return;
    case ParameterTerm::kPlacement:
      if (parameters->placements.empty()) parameters->placements.resize(mu.size());
      PlacementValue(id, &parameters->placements.at(static_cast<std::size_t>(id.part))) = value;
      return;
    case ParameterTerm::kSelfFriction:
      parameters->self_friction = value;
      return;
    case ParameterTerm::kFriction:
      if (id.part == kWhole) return std::fill(mu.begin(), mu.end(), value);
      mu.at(static_cast<std::size_t>(id.part)) = value;
      return;
    default:
      return SetConstant(id, value, parameters);
  }
}

}  // namespace clothid
