#include "costs/prediction/parameter_block.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <sstream>
#include <string_view>
#include <utility>

#include "datasets/motion/motion_validation.h"
#include "sim/base/error.h"
#include "sim/base/text_file.h"

namespace clothid {
namespace {

constexpr double kAtBound = 1e-3;
constexpr double kRelativeResolution = 1e-6;
constexpr double kLeastFriction = 0.01;
constexpr double kLeastShareOfUnit = 0.1;
constexpr char kRecordingMark = '@';
// How far beyond what was measured bounds lie: of any cloth, of a fabric that the scene names; and beyond the start.
constexpr double kMeasuredMargin = 100.0;
constexpr double kFabricMargin = 10.0;
constexpr double kStartMargin = 100.0;

// What `given` says of parameter `name`; null: nothing.
template <typename Value>
const Value* Given(const std::map<std::string, Value>& given, const std::string& name) {
  for (const std::string& own_or_group : OverrideNames(name)) {
    const auto it = given.find(own_or_group);
    if (it != given.end()) return &it->second;
  }
  return nullptr;
}

// The first of `given` and `from_scene` that is given.
double Choose(const std::map<std::string, double>& given, const std::string& name, double from_scene,
              double otherwise) {
  if (const double* value = Given(given, name)) return *value;
  return std::isnan(from_scene) ? otherwise : from_scene;
}

ParameterPrior ChoosePrior(const ParameterOverrides& overrides, const std::string& name,
                           const ParameterPrior& otherwise) {
  const ParameterPrior* given = Given(overrides.priors, name);
  return given != nullptr ? *given : otherwise;
}

// What is believed of a parameter of which nobody has said anything.
ParameterPrior DefaultPrior(ParameterKind kind) {
  const double spread = RowOf(kind).prior_spread;
  return spread > 0.0 ? ParameterPrior{IsLogarithmic(kind) ? 1.0 : 0.0, spread} : ParameterPrior();
}

[[noreturn]] void FailOnParameter(const std::string& name, const std::string& problem) {
  throw Error(ErrorKind::kUsage, "parameter '" + name + "': " + problem);
}

std::string Bounds(const ParameterBlock& block) {
  std::ostringstream text;
  text << "[" << block.lower_bound << ", " << block.upper_bound << "]";
  return text.str();
}

void CheckStartIsInside(const ParameterBlock& block) {
  if (block.start >= block.lower_bound && block.start <= block.upper_bound) return;
  std::ostringstream start;
  start << block.start;
  FailOnParameter(block.name, "the starting value " + start.str() + " is outside its bounds " + Bounds(block));
}

void CheckStart(const ParameterBlock& block) {
  const bool is_valid = std::isfinite(block.start) && (block.is_signed || block.start >= 0.0);
  if (!is_valid) {
    const std::string limit = block.is_signed ? "" : " >= 0";
    FailOnParameter(block.name, "the starting value must be a finite number" + limit);
  }
  if (block.scale == ParameterScale::kLog && block.start == 0.0) {
    FailOnParameter(block.name,
                    "the starting value is 0, so the scene has no such term; give a positive nominal value in the "
                    "scene or a positive start");
  }
}

void CheckBounds(const ParameterBlock& block) {
  const double least = block.is_signed                       ? -std::numeric_limits<double>::max()
                       : block.scale == ParameterScale::kLog ? std::nextafter(0.0, 1.0)
                                                             : 0.0;
  if (!(block.lower_bound >= least) || !(block.upper_bound > block.lower_bound) || !std::isfinite(block.upper_bound)) {
    FailOnParameter(block.name, "bounds " + Bounds(block) +
                                    (least > 0.0       ? " must be positive and increasing"
                                     : block.is_signed ? " must be finite and increasing"
                                                       : " must be >= 0 and increasing"));
  }
  CheckStartIsInside(block);
}

void CheckPrior(const ParameterBlock& block) {
  const ParameterPrior& prior = block.prior;
  if (!prior.is_given() && std::isnan(prior.spread)) return;
  const bool is_log = block.scale == ParameterScale::kLog;
  const bool is_valid = std::isfinite(prior.center) && std::isfinite(prior.spread) &&
                        (is_log ? prior.center > 0.0 && prior.spread > 1.0 : prior.spread > 0.0);
  const std::string subject = "the prior of '" + block.name + "'";
  if (!is_valid) {
    throw Error(ErrorKind::kUsage, subject +
                                       (is_log ? ": expected MEDIAN:FACTOR, a median > 0 and a factor > 1, got "
                                               : ": expected MEAN:STD, a standard deviation > 0, got ") +
                                       PriorText(prior, block.scale));
  }
  if (block.frozen) throw Error(ErrorKind::kUsage, subject + " has no effect: the scene freezes the parameter");
}

void CheckAlignmentBounds(const ParameterBlock& block, double largest) {
  const bool is_increasing =
      std::isfinite(block.lower_bound) && std::isfinite(block.upper_bound) && block.upper_bound > block.lower_bound;
  if (!is_increasing || std::max(-block.lower_bound, block.upper_bound) > largest) {
    std::ostringstream limit;
    if (std::isfinite(largest)) limit << " and within +-" << largest;
    FailOnParameter(block.name, "bounds " + Bounds(block) + " must be increasing" + limit.str());
  }
  CheckStartIsInside(block);
}

// The k_poisson beyond which the energy of a membrane would be negative for some strain.
double LargestCoupling(const Material& material) {
  return std::sqrt(material.warp_stiffness * material.weft_stiffness);
}

// That `id` is a constant of.
const Material& MaterialOf(ParameterId id, const Parameters& parameters) {
  return id.part == kWhole ? parameters.material : parameters.pieces.at(static_cast<std::size_t>(id.part));
}

// What was measured of the constant `kind`; null: nothing.
const MeasuredConstant* Measured(const Fabric& fabric, ParameterKind kind) {
  switch (kind) {
    case ParameterKind::kDensity:
      return &fabric.density;
    case ParameterKind::kStretchStiffness:
      return &fabric.k_stretch;
    case ParameterKind::kWarpStiffness:
      return &fabric.k_warp;
    case ParameterKind::kWeftStiffness:
      return &fabric.k_weft;
    case ParameterKind::kShearStiffness:
      return &fabric.k_shear;
    default:
      return RowOf(kind).term == ParameterTerm::kBending ? &fabric.k_bend : nullptr;
  }
}

// The value of a parameter that may be negative at q = 1.
double SignedUnit(ParameterId id, double nominal, const Parameters& parameters) {
  const ParameterRow& row = RowOf(id.kind);
  if (row.range == 0.0) return LargestCoupling(MaterialOf(id, parameters));
  const double own = row.term == ParameterTerm::kPlacement ? 0.0 : 2.0 * std::abs(nominal);
  return std::max(row.range, own);
}

// A start above zero brings a drag into the scene.
void CheckWindHasDrag(const ParameterBlock& block, const Scene& scene, const ParameterOverrides& overrides) {
  if (!IsWind(block.id.kind) || scene.has_air()) return;
  for (const char* drag : {"drag", "drag_normal", "drag_tangential"}) {
    const auto start = overrides.start.find(drag);
    if (start != overrides.start.end() && start->second > 0.0) return;
  }
  FailOnParameter(block.name,
                  "wind does nothing to a cloth without drag; give a positive nominal value of drag or drag_normal in "
                  "the scene or a positive start");
}

// Without given ones.
std::pair<double, double> DefaultBounds(const ParameterBlock& block, const Scene& scene) {
  const ParameterKind kind = block.id.kind;
  if (block.is_signed) return {-block.unit, block.unit};
  if (block.scale != ParameterScale::kLog) return {0.0, RowOf(kind).range};
  if (IsSize(kind)) return {block.start / RowOf(kind).range, block.start * RowOf(kind).range};
  if (const double most = RowOf(kind).range; most > 0.0) return {1e-3 * most, std::max(most, 2.0 * block.start)};
  const MeasuredConstant* any = MeasuredOfAnyCloth(kind, scene);
  if (any == nullptr) return {block.start / kBoundFactor, block.start * kBoundFactor};
  const Fabric* fabric = FindFabric(scene.fabric);
  const MeasuredConstant* own = fabric == nullptr ? nullptr : Measured(*fabric, kind);
  const bool is_known = own != nullptr && !std::isnan(own->lowest);
  const MeasuredConstant& range = is_known ? *own : *any;
  const double margin = is_known ? kFabricMargin : kMeasuredMargin;
  return {std::min(range.lowest / margin, block.start / kStartMargin),
          std::max(range.highest * margin, block.start * kStartMargin)};
}

ParameterBlock MakeAlignmentBlock(const std::string& name, ParameterId id, const RecordedMotion& motion,
                                  const ParameterOverrides& overrides) {
  ValidateMotion(motion);
  ExpectMeasured(id, name, motion);
  ParameterBlock block;
  block.name = name;
  block.id = id;
  block.is_signed = true;
  block.unit = DefaultAlignmentRange(id, motion);
  block.start = Choose(overrides.start, name, 0.0, 0.0);
  block.lower_bound = Choose(overrides.lower_bounds, name, -block.unit, 0.0);
  block.upper_bound = Choose(overrides.upper_bounds, name, block.unit, 0.0);
  CheckAlignmentBounds(block, LargestAlignmentBound(id, motion));
  block.prior = ChoosePrior(overrides, name, DefaultPrior(id.kind));
  CheckPrior(block);
  return block;
}

// `id`: that of `name` in the scene.
ParameterBlock MakeSceneBlock(const std::string& name, ParameterId id, const Scene& scene,
                              const ParameterOverrides& overrides) {
  const auto range_it = scene.parameters.find(BaseName(name));
  const ParameterRange range = range_it == scene.parameters.end() ? ParameterRange() : range_it->second;
  // The friction of all obstacles of a scene that has none: any start will do, nothing depends on it.
  const Parameters scene_values = scene.nominal_parameters();
  const double nominal = GetParameter(scene_values, id);

  ParameterBlock block;
  block.name = name;
  block.id = id;
  CheckWindHasDrag(block, scene, overrides);
  block.scale = DefaultScale(id.kind);
  block.is_signed = RowOf(id.kind).domain == ParameterDomain::kAny;
  if (block.is_signed) block.unit = SignedUnit(id, nominal, scene_values);
  block.frozen = range.frozen;
  block.start = Choose(overrides.start, name, range.nominal, std::isnan(nominal) ? 0.25 * kMaxFriction : nominal);
  CheckStart(block);
  const auto [lower, upper] = DefaultBounds(block, scene);
  block.lower_bound = Choose(overrides.lower_bounds, name, range.lower_bound, lower);
  block.upper_bound = Choose(overrides.upper_bounds, name, range.upper_bound, upper);
  CheckBounds(block);
  const ParameterPrior believed = DefaultPrior(id.kind);
  const bool is_given = range.prior.is_given() || !believed.is_given() || block.frozen;
  block.prior = ChoosePrior(overrides, name, is_given ? range.prior : believed);
  CheckPrior(block);
  return block;
}

}  // namespace

ParameterId ParameterBlock::IdIn(const Scene& scene) const {
  return IsOfRecording(id.kind) ? id : ParseParameter(BaseName(name), scene);
}

double ParameterBlock::ToCoordinate(double value) const {
  return scale == ParameterScale::kLog ? std::log(value) : value / unit;
}

double ParameterBlock::ToValue(double coordinate) const {
  return scale == ParameterScale::kLog ? std::exp(coordinate) : unit * coordinate;
}

double ParameterBlock::ValueDerivative(double coordinate) const {
  return scale == ParameterScale::kLog ? std::exp(coordinate) : unit;
}

double ParameterBlock::PriorCoordinate() const { return ToCoordinate(prior.center); }

double ParameterBlock::PriorStd() const {
  return scale == ParameterScale::kLog ? std::log(prior.spread) : prior.spread / unit;
}

double ParameterBlock::CoordinateRange() const { return ToCoordinate(upper_bound) - ToCoordinate(lower_bound); }

bool ParameterBlock::IsAtBound(double coordinate) const {
  const double distance = std::min(coordinate - ToCoordinate(lower_bound), ToCoordinate(upper_bound) - coordinate);
  const double own_range = is_signed                       ? 2.0
                           : scale == ParameterScale::kLog ? 2.0 * std::log(kBoundFactor)
                                                           : kMaxFriction;
  return distance <= kAtBound * std::min(CoordinateRange(), own_range);
}

double ParameterBlock::Resolution(double coordinate) const {
  if (scale == ParameterScale::kLog) return kRelativeResolution;
  return kRelativeResolution * std::max(std::abs(coordinate), is_signed ? kLeastShareOfUnit : kLeastFriction);
}

std::string BaseName(const std::string& name) { return name.substr(0, name.find(kRecordingMark)); }

std::map<std::string, ParameterPrior> ParseParameterPriors(const std::string& text, const std::string& flag) {
  std::map<std::string, ParameterPrior> priors;
  if (text.empty()) return priors;
  for (const std::string& item : Split(text, ',')) {
    const std::size_t equals = std::min(item.find('='), item.size());
    const std::string name(Trimmed(std::string_view(item).substr(0, equals)));
    const std::vector<std::string> numbers = Split(item.substr(std::min(equals + 1, item.size())), ':');
    const std::optional<double> center = ParseNumber(Trimmed(numbers.front()));
    const std::optional<double> spread = ParseNumber(Trimmed(numbers.back()));
    if (name.empty() || numbers.size() != 2 || !center || !spread) {
      throw Error(ErrorKind::kUsage, flag + ": expected NAME=MEDIAN:FACTOR, or NAME=MEAN:STD of friction and others " +
                                         "that are no logarithms, got '" + Printable(item) + "'");
    }
    if (!priors.emplace(name, ParameterPrior{*center, *spread}).second) {
      throw Error(ErrorKind::kUsage, flag + ": '" + Printable(name) + "' is given twice");
    }
  }
  return priors;
}

std::string PriorText(const ParameterPrior& prior, ParameterScale scale) {
  std::ostringstream text;
  text << prior.center << (scale == ParameterScale::kLog ? ", factor " : " +- ") << prior.spread;
  return text.str();
}

std::vector<std::string> OverrideNames(const std::string& name) {
  const std::string base = BaseName(name), suffix = name.substr(base.size());
  const std::optional<ParameterId> id = FindParameter(base);
  const std::string group = id && IsOfRecording(id->kind) ? base.substr(0, base.find('.')) : base;
  std::vector<std::string> names;
  for (const std::string& candidate : {name, group + suffix, base, group}) {
    if (std::find(names.begin(), names.end(), candidate) == names.end()) names.push_back(candidate);
  }
  return names;
}

const MeasuredConstant* MeasuredOfAnyCloth(ParameterKind kind, const Scene& scene) {
  const bool is_edges = kind == ParameterKind::kBendingStiffness && scene.bending.law == BendingLaw::kEdges;
  return is_edges ? nullptr : Measured(AnyFabric(), kind);
}

ParameterScale DefaultScale(ParameterKind kind) {
  return IsLogarithmic(kind) ? ParameterScale::kLog : ParameterScale::kLinear;
}

ParameterId ParseParameter(const std::string& name, const RecordedMotion& motion) {
  const std::optional<ParameterId> id = FindParameter(name);
  if (id && IsOfRecording(id->kind)) return *id;
  try {
    return ParseParameter(name, motion.scene);
  } catch (const Error& error) {
    throw Error(error.kind(), error.what() + (", " + KnownAlignmentNames()));
  }
}

ParameterBlock MakeParameterBlock(const std::string& name, const Scene& scene, const ParameterOverrides& overrides) {
  return MakeSceneBlock(name, ParseParameter(BaseName(name), scene), scene, overrides);
}

ParameterBlock MakeParameterBlock(const std::string& name, const RecordedMotion& motion,
                                  const ParameterOverrides& overrides) {
  const ParameterId id = ParseParameter(BaseName(name), motion);
  return IsOfRecording(id.kind) ? MakeAlignmentBlock(name, id, motion, overrides)
                                : MakeSceneBlock(name, id, motion.scene, overrides);
}

}  // namespace clothid
