#include "identify/prediction/posterior.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <utility>

#include "datasets/fabric/fabric_card.h"
#include "identify/base/cloth_laws.h"
#include "identify/base/fitted_result.h"
#include "identify/prediction/random_streams.h"
#include "identify/uncertainty/uncertainty.h"
#include "sim/base/error.h"
#include "sim/base/json_document.h"
#include "sim/base/text_file.h"
#include "sim/matrix/dense.h"

namespace clothid {
namespace {

// NaN where it is null or not there.
double ToldNumber(const JsonNode& parent, const std::string& key) {
  const std::optional<JsonNode> node = parent.Find(key);
  return node && !node->is(JsonValue::Kind::kNull) ? node->Number() : std::nan("");
}

void ExpectFit(const JsonNode& root) {
  const std::string expected = std::string("\"") + kResultSchema + "\", the result of a fit";
  const JsonNode schema = root.Require("schema", expected);
  if (!schema.is(JsonValue::Kind::kString) || schema.String() != kResultSchema) schema.Fail("expected " + expected);
  const JsonNode status = root.Require("status", "a text");
  if (status.String() != "converged") {
    status.Fail("expected \"converged\", as of a fit with intervals, got \"" + Printable(status.String()) + "\"");
  }
  if (const auto fields = root.Find("fields")) {
    fields->Fail("expected a fit without fields, which no result.json holds");
  }
}

// The first line of the verdict, where it says that the fit must not be used.
std::string WarningOf(const JsonNode& root) {
  const auto usable = root.Find("usable");
  if (!usable || usable->String() != "no") return "";
  const std::vector<JsonNode> lines = root.Require("verdict", "an array of lines").items();
  return lines.empty() ? "do not use" : Printable(lines.front().String());
}

// "drag@2", "shift.x", "wind.x.3" of --wind_profile.
bool IsOfOneRecording(const std::string& name) {
  if (BaseName(name) != name) return true;
  const std::optional<ParameterId> id = FindParameter(name);
  return id && (IsOfRecording(id->kind) || IsWindKnot(*id));
}

// A parameter with what is told of its spread, in its own unit; NaN: nothing.
struct ToldParameter {
  PosteriorParameter parameter;
  double std = std::nan(""), lower95 = std::nan(""), upper95 = std::nan("");

  bool HasInterval() const { return std >= 0.0 && lower95 < upper95; }
};

struct ToldSpread {
  double noise = 0.0, beside = 0.0;  // standard deviations of q
};

// Of one that has an interval, or a range.
ToldSpread SpreadOf(const ToldParameter& told, double quantile) {
  if (told.parameter.untold) return {1.0, 0.0};
  ToldSpread spread;
  const PosteriorParameter& parameter = told.parameter;
  const double q = parameter.ToCoordinate(parameter.value);
  const double half_width =
      std::max(parameter.ToCoordinate(told.upper95) - q, q - parameter.ToCoordinate(told.lower95));
  const double total = half_width / quantile;
  spread.noise = std::min(total, parameter.scale == ParameterScale::kLog ? told.std / parameter.value : told.std);
  spread.beside = std::sqrt(std::max(0.0, total * total - spread.noise * spread.noise));
  return spread;
}

// The correlation of the noise of two parameters; NaN where none is told.
using CorrelationOf = std::function<double(std::size_t i, std::size_t j)>;

// Parameters, their covariance, and those that are held: all, where none has an interval.
void SetParameters(const std::vector<ToldParameter>& told, double quantile, const CorrelationOf& correlation_of,
                   FitPosterior* posterior) {
  std::vector<std::size_t> indices;
  std::vector<ToldSpread> spreads;
  const bool tells =
      std::any_of(told.begin(), told.end(), [](const ToldParameter& parameter) { return parameter.HasInterval(); });
  for (std::size_t i = 0; i < told.size(); ++i) {
    if (!tells || (!told[i].HasInterval() && !told[i].parameter.untold)) {
      posterior->held[told[i].parameter.name] = told[i].parameter.value;
      continue;
    }
    posterior->parameters.push_back(told[i].parameter);
    indices.push_back(i);
    spreads.push_back(SpreadOf(told[i], quantile));
  }
  const auto size = static_cast<Eigen::Index>(indices.size());
  posterior->covariance.setZero(size, size);
  for (Eigen::Index i = 0; i < size; ++i) {
    for (Eigen::Index j = 0; j < size; ++j) {
      const auto row = static_cast<std::size_t>(i), column = static_cast<std::size_t>(j);
      const bool is_apart = told[indices[row]].parameter.untold || told[indices[column]].parameter.untold;
      const double correlation = i == j ? 1.0 : is_apart ? 0.0 : correlation_of(indices[row], indices[column]);
      if (!std::isnan(correlation)) {
        posterior->covariance(i, j) = spreads[row].noise * correlation * spreads[column].noise;
      }
    }
    posterior->covariance(i, i) += std::pow(spreads[static_cast<std::size_t>(i)].beside, 2);
  }
}

// The hidden directions over the parameters `names`.
std::vector<Eigen::VectorXd> ReadHiddenDirections(const JsonNode& uncertainty, const std::vector<std::string>& names) {
  std::vector<Eigen::VectorXd> directions;
  const auto told = uncertainty.Find("hidden_directions");
  if (!told) return directions;
  for (const JsonNode& direction : told->items()) {
    const JsonNode coordinates = direction.Require("coordinates", "an object");
    Eigen::VectorXd& changes = directions.emplace_back(Eigen::VectorXd::Zero(static_cast<Eigen::Index>(names.size())));
    for (Eigen::Index i = 0; i < changes.size(); ++i) {
      const double change = ToldNumber(coordinates, names[static_cast<std::size_t>(i)]);
      if (!std::isnan(change)) changes[i] = change;
    }
  }
  return directions;
}

// Of a parameter that has no interval; none where it was frozen, or the result does not tell, as older ones.
std::optional<UntoldRange> ReadUntoldRange(const ToldParameter& told, const JsonNode& node, const JsonNode& uncertainty,
                                           bool hidden_alone) {
  const auto is = [&](const char* key) {
    const auto found = node.Find(key);
    return found && found->Boolean();
  };
  const auto changes = uncertainty.Find("visible_change");
  if (!changes || is("frozen")) return std::nullopt;
  const double visible_change = ToldNumber(*changes, told.parameter.name);
  const double scale = ToldNumber(uncertainty, "residual_scale");
  if (std::isnan(visible_change) || std::isnan(scale)) return std::nullopt;
  return RangeOf({told.parameter.scale, told.parameter.value, told.parameter.lower_bound, told.parameter.upper_bound,
                  is("at_bound"), hidden_alone, visible_change, scale, told.lower95, told.upper95});
}

PosteriorParameter ReadParameter(const std::string& name, const JsonNode& node) {
  PosteriorParameter parameter;
  parameter.name = name;
  const JsonNode scale = node.Require("scale", "\"log\" or \"linear\"; fit the recording again");
  if (scale.String() != "log" && scale.String() != "linear") scale.Fail("expected \"log\" or \"linear\"");
  parameter.scale = scale.String() == "log" ? ParameterScale::kLog : ParameterScale::kLinear;
  const JsonNode value = node.Require("value", "a number");
  parameter.value = parameter.scale == ParameterScale::kLog ? value.PositiveNumber() : value.Number();
  parameter.lower_bound = node.Require("lower_bound", "a number").Number();
  parameter.upper_bound = node.Require("upper_bound", "a number").Number();
  return parameter;
}

void ReadParameters(const JsonNode& root, FitPosterior* posterior) {
  const JsonNode uncertainty = root.Require("uncertainty", "that of a fit with intervals");
  if (!uncertainty.is(JsonValue::Kind::kObject)) uncertainty.Fail("expected that of a fit with intervals");
  const auto widening = uncertainty.Find("widening");
  const double quantile = widening ? widening->Require("quantile95", "a number").PositiveNumber() : kNormal95;
  const JsonNode parameters = root.Require("parameters", "an object");
  const std::vector<std::string> names = parameters.keys();
  const std::vector<Eigen::VectorXd> hidden = ReadHiddenDirections(uncertainty, names);
  std::vector<ToldParameter> told;
  for (std::size_t i = 0; i < names.size(); ++i) {
    const std::string& name = names[i];
    if (IsOfOneRecording(name)) {
      posterior->left_out.push_back(name);
      continue;
    }
    const JsonNode node = *parameters.Find(name);
    ToldParameter& next = told.emplace_back(ToldParameter{ReadParameter(name, node), ToldNumber(node, "std"),
                                                          ToldNumber(node, "lower95"), ToldNumber(node, "upper95")});
    if (next.HasInterval()) continue;
    const bool hidden_alone = IsHiddenAlone(hidden, static_cast<Eigen::Index>(i));
    next.parameter.untold = ReadUntoldRange(next, node, uncertainty, hidden_alone);
  }
  const JsonNode rows = uncertainty.Require("correlation", "an object");
  const auto correlation_of = [&](std::size_t i, std::size_t j) {
    return ToldNumber(rows.Require(told[i].parameter.name, "an object"), told[j].parameter.name);
  };
  SetParameters(told, quantile, correlation_of, posterior);
  if (posterior->parameters.empty()) parameters.Fail("expected one with an interval, 'lower95' to 'upper95'");
}

std::vector<LastingForce> ReadForces(const JsonNode& root) {
  std::vector<LastingForce> forces;
  const auto told = root.Find("missing_force");
  if (!told) return forces;
  for (const JsonNode& force : told->items()) {
    const auto number = [&](const char* key) { return force.Require(key, "a positive number").PositiveNumber(); };
    forces.push_back({number("deviation_N_m2"), number("time_s"), number("length_m")});
  }
  return forces;
}

// Where bands were calibrated.
void ReadCalibration(const JsonNode& root, FitPosterior* posterior) {
  const auto holdout = root.Find("holdout");
  if (!holdout || holdout->is(JsonValue::Kind::kNull)) return;
  const auto bands = holdout->Find("bands");
  const auto calibration = bands ? bands->Find("calibration") : std::nullopt;
  if (!calibration) return;
  posterior->force_factor = calibration->Require("force_factor", "a positive number").PositiveNumber();
  for (LastingForce& force : posterior->forces) force.size *= posterior->force_factor;
}

// The mean over recordings, of squares; none where no start was fitted.
std::optional<LearntStart> MeanStart(const std::vector<LearntStart>& starts) {
  if (starts.empty()) return std::nullopt;
  LearntStart mean;
  const auto num = static_cast<double>(starts.size());
  for (const LearntStart& start : starts) {
    mean.position += start.position * start.position / num;
    mean.velocity += start.velocity * start.velocity / num;
    mean.handles += start.handles * start.handles / num;
    mean.handle_interval = std::max(mean.handle_interval, start.handle_interval);
  }
  for (double* square : {&mean.position, &mean.velocity, &mean.handles}) *square = std::sqrt(*square);
  return mean;
}

std::optional<LearntStart> ReadStart(const JsonNode& root) {
  const auto recordings = root.Find("recordings");
  if (!recordings) return std::nullopt;
  std::vector<LearntStart> starts;
  for (const JsonNode& recording : recordings->items()) {
    const auto start = recording.Find("start");
    if (!start) continue;
    const auto number = [&](const char* key) {
      const double told = ToldNumber(*start, key);
      return std::isnan(told) ? 0.0 : told;
    };
    starts.push_back({std::hypot(number("moved_m"), number("std_m")),
                      std::hypot(number("speed_change_m_s"), number("velocity_std_m_s")),
                      std::hypot(number("handles_moved_m"), number("handle_std_m")), number("handle_interval_s")});
  }
  return MeanStart(starts);
}

std::optional<std::string> ReadLaw(const JsonNode& root, const std::string& key) {
  const auto cloth = root.Find("cloth");
  if (!cloth) return std::nullopt;
  const JsonNode law = cloth->Require(key, "a text or null");
  return law.is(JsonValue::Kind::kNull) ? std::nullopt : std::optional<std::string>(law.String());
}

[[noreturn]] void FailOnParameter(const FitPosterior& posterior, const std::string& name, const std::string& problem) {
  throw Error(ErrorKind::kBadData, posterior.path + ": key '" + posterior.key + "." + name + "': " + problem);
}

// Throws where the scene has no such parameter, or it means something else there.
void ExpectParameter(const Scene& scene, const std::string& scene_name, const FitPosterior& posterior,
                     const std::string& name) {
  const std::optional<ParameterId> id = FindParameter(name, scene.obstacle_names(), scene.mesh.piece_names);
  if (!id || !scene.has(*id)) FailOnParameter(posterior, name, "expected a parameter that " + scene_name + " has");
  const ParameterTerm term = RowOf(id->kind).term;
  const std::string membrane = MembraneWord(scene);
  if (term == ParameterTerm::kMembrane && posterior.membrane && *posterior.membrane != membrane) {
    FailOnParameter(posterior, name,
                    "is of the membrane \"" + Printable(*posterior.membrane) + "\"; expected \"" + membrane +
                        "\", as " + scene_name + " has");
  }
  const char* const bending = BendingWord(scene);
  const bool bends = term == ParameterTerm::kBending && bending != nullptr && posterior.bending.has_value();
  if (bends && *posterior.bending != bending) {
    FailOnParameter(posterior, name,
                    "is of bending by \"" + Printable(*posterior.bending) + "\"; expected \"" + bending + "\", as " +
                        scene_name + " has");
  }
}

// Takes row and column `index` out.
void Erase(std::size_t index, FitPosterior* posterior) {
  posterior->parameters.erase(posterior->parameters.begin() + static_cast<std::ptrdiff_t>(index));
  std::vector<Eigen::Index> kept;
  for (Eigen::Index i = 0; i < posterior->covariance.rows(); ++i) {
    if (i != static_cast<Eigen::Index>(index)) kept.push_back(i);
  }
  posterior->covariance = posterior->covariance(kept, kept).eval();
}

FitPosterior PosteriorOfCard(const JsonNode& root, const std::string& path) {
  const FabricCard card = ParseFabricCard(root);
  FitPosterior posterior;
  posterior.path = path;
  posterior.key = "constants";
  posterior.membrane = MembraneName(card.membrane);
  posterior.bending = "patches";
  std::vector<double> variances;
  for (const CardConstant& constant : card.constants) {
    if (!constant.is_told()) continue;
    constexpr double kAny = std::numeric_limits<double>::infinity();
    const bool is_log = IsLogarithmic(constant.kind);
    posterior.parameters.push_back({RowOf(constant.kind).name, is_log ? ParameterScale::kLog : ParameterScale::kLinear,
                                    constant.value, is_log ? 0.0 : -kAny, kAny});
    const double spread = constant.Prior().spread;
    variances.push_back(std::pow(is_log ? std::log(spread) : spread, 2));
  }
  if (variances.empty()) root.Require("constants", "an object").Fail("expected one that a fit has told");
  posterior.covariance =
      Eigen::Map<const Eigen::VectorXd>(variances.data(), static_cast<Eigen::Index>(variances.size())).asDiagonal();
  for (const CardForce& force : card.missing_forces) {
    posterior.forces.push_back({force.deviation, force.time, force.length});
    posterior.force_factor = force.factor;
  }
  return posterior;
}

}  // namespace

double PosteriorParameter::ToCoordinate(double at) const { return scale == ParameterScale::kLog ? std::log(at) : at; }

double PosteriorParameter::ToValue(double coordinate) const {
  return std::clamp(scale == ParameterScale::kLog ? std::exp(coordinate) : coordinate, lower_bound, upper_bound);
}

FitPosterior ReadPosterior(const std::string& path) { return ParsePosterior(ReadText(path, kMaxJsonBytes), path); }

FitPosterior ParsePosterior(const std::string& text, const std::string& path) {
  const JsonValue json = ParseJson(text, path);
  const JsonNode root(json, path);
  if (IsFabricCard(root)) return PosteriorOfCard(root, path);
  ExpectFit(root);
  FitPosterior posterior;
  posterior.path = path;
  posterior.warning = WarningOf(root);
  ReadParameters(root, &posterior);
  posterior.forces = ReadForces(root);
  ReadCalibration(root, &posterior);
  posterior.start = ReadStart(root);
  posterior.membrane = ReadLaw(root, "membrane");
  posterior.bending = ReadLaw(root, "bending");
  return posterior;
}

FitPosterior PosteriorOf(const FitSummary& summary, const std::vector<LastingForce>& forces) {
  FitPosterior posterior;
  posterior.path = "the fit";
  std::vector<Eigen::VectorXd> hidden;
  for (const HiddenDirection& direction : summary.uncertainty->hidden_directions) {
    hidden.push_back(direction.coordinates);
  }
  std::vector<ToldParameter> told;
  for (std::size_t i = 0; i < summary.parameters.size(); ++i) {
    const FittedParameter& fitted = summary.parameters[i];
    const ParameterUncertainty& known = summary.uncertainty->parameters[i];
    ToldParameter& next = told.emplace_back(
        ToldParameter{{fitted.name, fitted.scale, fitted.value, fitted.lower_bound, fitted.upper_bound},
                      known.std,
                      known.lower95,
                      known.upper95});
    if (next.HasInterval() || fitted.frozen) continue;
    next.parameter.untold = RangeOf({fitted.scale, fitted.value, fitted.lower_bound, fitted.upper_bound, known.at_bound,
                                     IsHiddenAlone(hidden, static_cast<Eigen::Index>(i)), known.visible_change,
                                     summary.uncertainty->residual_scale, known.lower95, known.upper95});
  }
  const auto correlation_of = [&](std::size_t i, std::size_t j) {
    return summary.uncertainty->correlation(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j));
  };
  SetParameters(told, summary.uncertainty->quantile95, correlation_of, &posterior);
  posterior.forces = forces;
  std::vector<LearntStart> starts;
  for (const StartEstimate& start : summary.starts) {
    starts.push_back({std::hypot(start.moved, start.position_std), std::hypot(start.speed_change, start.velocity_std),
                      std::hypot(start.handles_moved, start.handle_std), start.handle_interval});
  }
  posterior.start = MeanStart(starts);
  return posterior;
}

void FitToScene(const Scene& scene, const std::string& scene_name, FitPosterior* posterior) {
  const auto is_idle = [&](const std::string& name) { return name == "mu" && scene.obstacles.empty(); };
  for (std::size_t i = 0; i < posterior->parameters.size();) {
    const std::string name = posterior->parameters[i].name;
    ExpectParameter(scene, scene_name, *posterior, name);
    if (!is_idle(name)) {
      ++i;
      continue;
    }
    posterior->left_out.push_back(name);
    Erase(i, posterior);
  }
  for (auto it = posterior->held.begin(); it != posterior->held.end();) {
    ExpectParameter(scene, scene_name, *posterior, it->first);
    it = is_idle(it->first) ? posterior->held.erase(it) : std::next(it);
  }
}

Eigen::MatrixXd DrawParameters(const FitPosterior& posterior, int num_draws, std::uint64_t seed) {
  const auto size = static_cast<Eigen::Index>(posterior.parameters.size());
  Eigen::MatrixXd values(size, num_draws);
  if (size == 0) return values;
  const Spectrum spectrum = SymmetricSpectrum(posterior.covariance);
  const Eigen::MatrixXd root = spectrum.vectors * spectrum.values.cwiseMax(0.0).cwiseSqrt().asDiagonal();
  for (int draw = 0; draw < num_draws; ++draw) {
    const Eigen::VectorXd change = root * NormalStream(seed, draw, DrawStream::kParameters).Draw(size, 1);
    for (Eigen::Index i = 0; i < size; ++i) {
      const PosteriorParameter& parameter = posterior.parameters[static_cast<std::size_t>(i)];
      values(i, draw) = parameter.ToValue(parameter.untold ? parameter.untold->At(change[i])
                                                           : parameter.ToCoordinate(parameter.value) + change[i]);
    }
  }
  return values;
}

}  // namespace clothid
