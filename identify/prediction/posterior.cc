#include "identify/prediction/posterior.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "identify/base/cloth_laws.h"
#include "identify/base/fitted_result.h"
#include "identify/prediction/random_streams.h"
#include "identify/uncertainty/uncertainty.h"
#include "sim/base/error.h"
#include "sim/base/json_document.h"
#include "sim/base/text_file.h"

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

struct ToldSpread {
  double noise = std::nan(""), beside = 0.0;  // standard deviations of q; NaN: none is told
};

ToldSpread SpreadOf(const PosteriorParameter& parameter, const JsonNode& node, double quantile) {
  const double std = ToldNumber(node, "std");
  const double lower = ToldNumber(node, "lower95"), upper = ToldNumber(node, "upper95");
  ToldSpread spread;
  if (!(std >= 0.0) || !(lower < upper)) return spread;
  const double q = parameter.ToCoordinate(parameter.value);
  const double half_width = std::max(parameter.ToCoordinate(upper) - q, q - parameter.ToCoordinate(lower));
  const double total = half_width / quantile;
  spread.noise = std::min(total, parameter.scale == ParameterScale::kLog ? std / parameter.value : std);
  spread.beside = std::sqrt(std::max(0.0, total * total - spread.noise * spread.noise));
  return spread;
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

// Of parameters `names`; 0 where none is told.
Eigen::MatrixXd ReadCorrelation(const JsonNode& uncertainty, const std::vector<PosteriorParameter>& parameters) {
  const JsonNode rows = uncertainty.Require("correlation", "an object");
  const auto size = static_cast<Eigen::Index>(parameters.size());
  Eigen::MatrixXd correlation = Eigen::MatrixXd::Identity(size, size);
  for (Eigen::Index i = 0; i < size; ++i) {
    const JsonNode row = rows.Require(parameters[static_cast<std::size_t>(i)].name, "an object");
    for (Eigen::Index j = 0; j < size; ++j) {
      const double told = ToldNumber(row, parameters[static_cast<std::size_t>(j)].name);
      if (i != j && !std::isnan(told)) correlation(i, j) = told;
    }
  }
  return correlation;
}

void ReadParameters(const JsonNode& root, Posterior* posterior) {
  const JsonNode uncertainty = root.Require("uncertainty", "that of a fit with intervals");
  if (!uncertainty.is(JsonValue::Kind::kObject)) uncertainty.Fail("expected that of a fit with intervals");
  const auto widening = uncertainty.Find("widening");
  const double quantile = widening ? widening->Require("quantile95", "a number").PositiveNumber() : kNormal95;
  const JsonNode parameters = root.Require("parameters", "an object");
  std::vector<double> noise, beside;
  for (const std::string& name : parameters.keys()) {
    if (IsOfOneRecording(name)) {
      posterior->left_out.push_back(name);
      continue;
    }
    const JsonNode node = *parameters.Find(name);
    const PosteriorParameter parameter = ReadParameter(name, node);
    const ToldSpread spread = SpreadOf(parameter, node, quantile);
    if (std::isnan(spread.noise)) {
      posterior->held[name] = parameter.value;
      continue;
    }
    posterior->parameters.push_back(parameter);
    noise.push_back(spread.noise);
    beside.push_back(spread.beside);
  }
  if (posterior->parameters.empty()) parameters.Fail("expected one with an interval, 'lower95' to 'upper95'");
  const auto size = static_cast<Eigen::Index>(noise.size());
  const Eigen::Map<const Eigen::VectorXd> deviations(noise.data(), size), others(beside.data(), size);
  const Eigen::MatrixXd correlation = ReadCorrelation(uncertainty, posterior->parameters);
  posterior->covariance = deviations.asDiagonal() * correlation * deviations.asDiagonal();
  posterior->covariance.diagonal() += others.cwiseAbs2();
}

// The mean over the recordings, of squares; none where no recording has told one that lasts.
std::optional<LastingForce> ReadLastingForce(const JsonNode& root) {
  const auto assimilation = root.Find("assimilation");
  if (!assimilation) return std::nullopt;
  LastingForce mean;
  double num = 0.0;
  for (const JsonNode& recording : assimilation->Require("recordings", "an array").items()) {
    const JsonNode force = recording.Require("missing_force", "an object");
    const double size = ToldNumber(force, "deviation_N_m2"), time = ToldNumber(force, "time_s");
    const double length = ToldNumber(force, "length_m");
    if (!(size > 0.0) || !(time > 0.0) || !(length > 0.0)) continue;
    mean.size += size * size;
    mean.time += time;
    mean.length += length;
    num += 1.0;
  }
  if (num == 0.0) return std::nullopt;
  return LastingForce{std::sqrt(mean.size / num), mean.time / num, mean.length / num};
}

std::optional<std::string> ReadLaw(const JsonNode& root, const std::string& key) {
  const auto cloth = root.Find("cloth");
  if (!cloth) return std::nullopt;
  const JsonNode law = cloth->Require(key, "a text or null");
  return law.is(JsonValue::Kind::kNull) ? std::nullopt : std::optional<std::string>(law.String());
}

[[noreturn]] void FailOnParameter(const Posterior& posterior, const std::string& name, const std::string& problem) {
  throw Error(ErrorKind::kBadData, posterior.path + ": key 'parameters." + name + "': " + problem);
}

// Throws where the scene has no such parameter, or it means something else there.
void ExpectParameter(const Scene& scene, const std::string& scene_name, const Posterior& posterior,
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
void Erase(std::size_t index, Posterior* posterior) {
  posterior->parameters.erase(posterior->parameters.begin() + static_cast<std::ptrdiff_t>(index));
  std::vector<Eigen::Index> kept;
  for (Eigen::Index i = 0; i < posterior->covariance.rows(); ++i) {
    if (i != static_cast<Eigen::Index>(index)) kept.push_back(i);
  }
  posterior->covariance = posterior->covariance(kept, kept).eval();
}

}  // namespace

double PosteriorParameter::ToCoordinate(double at) const { return scale == ParameterScale::kLog ? std::log(at) : at; }

double PosteriorParameter::ToValue(double coordinate) const {
  return std::clamp(scale == ParameterScale::kLog ? std::exp(coordinate) : coordinate, lower_bound, upper_bound);
}

Posterior ReadPosterior(const std::string& path) {
  const JsonValue json = ParseJson(ReadText(path, kMaxJsonBytes), path);
  const JsonNode root(json, path);
  ExpectFit(root);
  Posterior posterior;
  posterior.path = path;
  posterior.warning = WarningOf(root);
  ReadParameters(root, &posterior);
  posterior.force = ReadLastingForce(root);
  posterior.membrane = ReadLaw(root, "membrane");
  posterior.bending = ReadLaw(root, "bending");
  return posterior;
}

void FitToScene(const Scene& scene, const std::string& scene_name, Posterior* posterior) {
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

Eigen::MatrixXd DrawParameters(const Posterior& posterior, int num_draws, std::uint64_t seed) {
  const auto size = static_cast<Eigen::Index>(posterior.parameters.size());
  Eigen::MatrixXd values(size, num_draws);
  if (size == 0) return values;
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(posterior.covariance);
  const Eigen::MatrixXd root = eigen.eigenvectors() * eigen.eigenvalues().cwiseMax(0.0).cwiseSqrt().asDiagonal();
  for (int draw = 0; draw < num_draws; ++draw) {
    const Eigen::VectorXd change = root * NormalStream(seed, draw, DrawStream::kParameters).Draw(size, 1);
    for (Eigen::Index i = 0; i < size; ++i) {
      const PosteriorParameter& parameter = posterior.parameters[static_cast<std::size_t>(i)];
      values(i, draw) = parameter.ToValue(parameter.ToCoordinate(parameter.value) + change[i]);
    }
  }
  return values;
}

}  // namespace clothid
