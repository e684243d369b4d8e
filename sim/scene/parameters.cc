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

constexpr std::string_view kFrictionPrefix = "mu.";

std::string Named(ParameterKind kind) { return RowOf(kind).name; }

// Of one row, or null.
const ParameterRow* FindRow(std::string_view name) {
  for (const ParameterRow& row : ParameterTable()) {
    if (name == row.name && row.term != ParameterTerm::kPlacement) return &row;
  }
  return nullptr;
}

bool CanBeOfKnot(ParameterKind kind) { return RowOf(kind).wind_vector == &Wind::mean; }

// "wind.x.1" of a knot.
std::optional<ParameterId> FindKnot(std::string_view name) {
  for (const ParameterKind kind : KindsOf(ParameterTerm::kWind)) {
    const std::string prefix = Named(kind) + ".";
    if (!CanBeOfKnot(kind) || name.substr(0, prefix.size()) != prefix) continue;
    const std::string_view digits = name.substr(prefix.size());
    const std::optional<long long> number = ParseInteger(digits);
    if (number && *number >= 1 && *number <= kMaxWindKnots && digits == std::to_string(*number)) {
      return ParameterId{kind, kAllObstacles, static_cast<int>(*number - 1)};
    }
  }
  return std::nullopt;
}

// "NAME.shift.x".
std::optional<ParameterId> FindPlacement(const std::string& name, const std::vector<std::string>& obstacle_names) {
  for (std::size_t i = 0; i < obstacle_names.size(); ++i) {
    for (const ParameterKind kind : KindsOf(ParameterTerm::kPlacement)) {
      if (name == obstacle_names[i] + Named(kind)) return ParameterId{kind, static_cast<int>(i)};
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
  const ParameterRow* const row = FindRow(name.substr(0, dot));
  if (row == nullptr || !row->can_be_of_piece) return std::nullopt;
  return ParameterId{row->kind, kAllObstacles, kMeanWind, static_cast<int>(piece - piece_names.begin())};
}

// The value that `kind`, of a placement, names.
double& PlacementValue(ParameterKind kind, Placement* placement) {
  const auto index = static_cast<int>(RowOf(kind).part);
  if (index == 0) return placement->time_offset;
  return index < static_cast<int>(PlacementPart::kTurnX)
             ? placement->shift[index - static_cast<int>(PlacementPart::kShiftX)]
             : placement->turn[index - static_cast<int>(PlacementPart::kTurnX)];
}

// The value that `id`, of a wind, names.
double& WindValue(ParameterId id, Wind* wind) {
  const ParameterRow& row = RowOf(id.kind);
  if (row.wind_number != nullptr) return wind->*row.wind_number;
  if (id.knot == kMeanWind) return (wind->*row.wind_vector)[row.axis];
  if (id.knot >= wind->profile.velocities.cols()) throw std::out_of_range("knot of the wind's profile");
  return wind->profile.velocities(row.axis, id.knot);
}

void SetConstant(ParameterId id, double value, Parameters* parameters) {
  double Material::*const constant = RowOf(id.kind).constant;
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

bool IsWind(ParameterKind kind) { return RowOf(kind).term == ParameterTerm::kWind; }

bool IsSize(ParameterKind kind) { return RowOf(kind).term == ParameterTerm::kSize; }

bool IsPlacement(ParameterKind kind) { return RowOf(kind).term == ParameterTerm::kPlacement; }

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

std::string ParameterNames(const std::vector<std::string>& obstacle_names,
                           const std::function<bool(ParameterKind)>& has, const std::vector<std::string>& piece_names) {
  std::string names;
  for (const ParameterRow& row : ParameterTable()) {
    if (row.term == ParameterTerm::kPlacement) continue;
    const bool is_always_told = row.term == ParameterTerm::kFriction || row.term == ParameterTerm::kSize;
    if (is_always_told || has(row.kind)) names.append(names.empty() ? "" : ", ").append(row.name);
    if (row.term != ParameterTerm::kFriction) continue;
    for (const std::string& obstacle : obstacle_names) names.append(", ").append(kFrictionPrefix).append(obstacle);
  }
  if (piece_names.empty()) return names;
  names += "; with a piece behind a constant of the cloth, as in";
  for (const std::string& piece : piece_names) names += (piece == piece_names[0] ? " density." : ", density.") + piece;
  return names;
}

ParameterId ParseParameter(const std::string& name, const std::vector<std::string>& obstacle_names,
                           const std::vector<std::string>& piece_names) {
  const ParameterRow* const row = FindRow(name);
  const bool is_own = row != nullptr && row->kind != ParameterKind::kSelfFriction;  // an obstacle may be called "self"
  if (is_own) return {row->kind};
  if (const auto knot = FindKnot(name)) return *knot;
  if (name.compare(0, kFrictionPrefix.size(), kFrictionPrefix) == 0) {
    const auto found = std::find(obstacle_names.begin(), obstacle_names.end(), name.substr(kFrictionPrefix.size()));
    if (found != obstacle_names.end()) {
      return {ParameterKind::kFriction, static_cast<int>(found - obstacle_names.begin())};
    }
  }
  if (row != nullptr) return {row->kind};
  if (const auto placement = FindPlacement(name, obstacle_names)) return *placement;
  if (const auto of_piece = FindOfPiece(name, piece_names)) return *of_piece;
  throw Error(ErrorKind::kUsage, "unknown parameter '" + name + "'; expected one of " +
                                     ParameterNames(
                                         obstacle_names, [](ParameterKind) { return true; }, piece_names));
}

std::string ParameterName(ParameterId id, const std::vector<std::string>& obstacle_names,
                          const std::vector<std::string>& piece_names) {
  const std::string name = Named(id.kind);
  if (id.piece != kWholeCloth) return name + "." + piece_names.at(static_cast<std::size_t>(id.piece));
  if (id.knot != kMeanWind) return name + "." + std::to_string(id.knot + 1);
  if (IsPlacement(id.kind)) return obstacle_names.at(static_cast<std::size_t>(id.obstacle)) + name;
  if (id.obstacle == kAllObstacles || id.kind != ParameterKind::kFriction) return name;
  return name + "." + obstacle_names.at(static_cast<std::size_t>(id.obstacle));
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
  const ParameterRow& row = RowOf(id.kind);
  switch (row.term) {
    case ParameterTerm::kWind: {
      Wind wind = parameters.wind;
      return WindValue(id, &wind);
    }
    case ParameterTerm::kSize:
      return parameters.size[static_cast<std::size_t>(row.axis)];
    case ParameterTerm::kPlacement: {
      Placement placement = parameters.placement(id.obstacle);
      return PlacementValue(id.kind, &placement);
    }
    case ParameterTerm::kSelfFriction:
      return parameters.self_friction;
    case ParameterTerm::kFriction: {
      const std::vector<double>& mu = parameters.friction_coefficients;
      if (mu.empty()) return std::numeric_limits<double>::quiet_NaN();
      return id.obstacle == kAllObstacles ? mu.front() : mu.at(static_cast<std::size_t>(id.obstacle));
    }
    default:  // of the material
      break;
  }
  return (id.piece == kWholeCloth ? parameters.material : parameters.pieces.at(static_cast<std::size_t>(id.piece))).*
         row.constant;
}

void SetParameter(ParameterId id, double value, Parameters* parameters) {
  std::vector<double>& mu = parameters->friction_coefficients;
  const ParameterRow& row = RowOf(id.kind);
  switch (row.term) {
    case ParameterTerm::kWind:
      WindValue(id, &parameters->wind) = value;
      return;
    case ParameterTerm::kSize:
      parameters->size[static_cast<std::size_t>(row.axis)] = value;
      return;
    case ParameterTerm::kPlacement:
      if (parameters->placements.empty()) parameters->placements.resize(mu.size());
      PlacementValue(id.kind, &parameters->placements.at(static_cast<std::size_t>(id.obstacle))) = value;
      return;
    case ParameterTerm::kSelfFriction:
      parameters->self_friction = value;
      return;
    case ParameterTerm::kFriction:
      if (id.obstacle == kAllObstacles) return std::fill(mu.begin(), mu.end(), value);
      mu.at(static_cast<std::size_t>(id.obstacle)) = value;
      return;
    default:
      return SetConstant(id, value, parameters);
  }
}

}  // namespace clothid
