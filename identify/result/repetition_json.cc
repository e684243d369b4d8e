#include "identify/result/repetition_json.h"

#include <cmath>
#include <limits>

#include "identify/base/version.h"
#include "identify/verdict/repetition_text.h"

namespace clothid {
namespace {

using Json = nlohmann::ordered_json;

constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();

// Null where the fit has no such parameter.
Json SingleJson(const SingleFit& fit, const std::string& name) {
  const SingleEstimate* estimate = fit.Find(name);
  if (estimate == nullptr) return nullptr;
  return {{"value", estimate->value},     {"std", estimate->std}, {"lower95", estimate->lower95},
          {"upper95", estimate->upper95}, {"weight", nullptr},    {"deviation", nullptr},
          {"mean_of_others", nullptr},    {"fits", nullptr}};
}

Json EstimatesJson(const Repetitions& repetitions, const PooledParameter& parameter) {
  Json estimates = Json::array();
  for (const SingleFit& fit : repetitions.fits) estimates.push_back(SingleJson(fit, parameter.name));
  for (std::size_t k = 0; parameter.is_pooled() && k < parameter.fits.size(); ++k) {
    const LeftOutEstimate& left_out = parameter.effects.left_out[k];
    const bool is_log = parameter.scale == ParameterScale::kLog;
    Json& json = estimates[static_cast<std::size_t>(parameter.fits[k])];
    json["weight"] = parameter.effects.weights[static_cast<Eigen::Index>(k)];
    json["deviation"] = left_out.deviation;
    json["mean_of_others"] = is_log ? std::exp(left_out.mean) : left_out.mean;
    json["fits"] = left_out.fits;
  }
  return estimates;
}

Json ParameterJson(const Repetitions& repetitions, const PooledParameter& parameter) {
  const RandomEffects& effects = parameter.effects;
  Json json = {{"scale", parameter.scale == ParameterScale::kLog ? "log" : "linear"},
               {"estimates", EstimatesJson(repetitions, parameter)},
               {"pooled", parameter.fits.size()}};
  if (!parameter.is_pooled()) return json;
  json["mean"] = parameter.mean;
  json["lower95"] = parameter.lower95;
  json["upper95"] = parameter.upper95;
  json["next_lower95"] = parameter.next_lower95;
  json["next_upper95"] = parameter.next_upper95;
  json["scatter"] = effects.tau;
  json["scatter_lower95"] = effects.tau_lower95;
  json["scatter_upper95"] = effects.tau_upper95;
  json["scatter_paule_mandel"] = effects.tau_paule_mandel;
  json["typical_std"] = effects.typical_std;
  json["difference"] = effects.scatter();
  json["common_error"] = effects.common_error;
  json["cochran_q"] = effects.q;
  json["p_value"] = effects.p_value;
  json["varies"] = parameter.varies();
  json["words"] = MeanText(parameter);
  return json;
}

// Of the mean in its own unit, to first order.
double MeanStd(const PooledParameter& parameter) {
  if (!parameter.is_pooled()) return kUnknown;
  return parameter.effects.mean_std * (parameter.scale == ParameterScale::kLog ? parameter.mean : 1.0);
}

}  // namespace

Json RepetitionsJson(const Repetitions& repetitions) {
  Json recordings = Json::array(), parameters = Json::object();
  for (const SingleFit& fit : repetitions.fits) {
    recordings.push_back(
        {{"name", fit.name}, {"why_not_used", fit.why_not_used.empty() ? Json(nullptr) : Json(fit.why_not_used)}});
  }
  for (const PooledParameter& parameter : repetitions.parameters) {
    parameters[parameter.name] = ParameterJson(repetitions, parameter);
  }
  return {{"recordings", recordings}, {"parameters", parameters}};
}

std::string PooledResultJson(const FitSummary& summary, const FitChecks& checks, const Verdict& verdict) {
  Json parameters = Json::object();
  std::string sha256;
  for (const SingleFit& fit : checks.repetitions->fits) sha256 += (sha256.empty() ? "" : ",") + fit.sha256;
  for (std::size_t i = 0; i < summary.parameters.size(); ++i) {
    const PooledParameter& parameter = checks.repetitions->parameters[i];
    parameters[parameter.name] = {{"value", parameter.mean},
                                  {"std", MeanStd(parameter)},
                                  {"lower95", parameter.lower95},
                                  {"upper95", parameter.upper95},
                                  {"scale", parameter.scale == ParameterScale::kLog ? "log" : "linear"},
                                  {"usable", UsabilityName(verdict.parameters[i])}};
  }
  const Json json = {{"schema", "clothid.result/1"},
                     {"status", "pooled"},
                     {"exit_code", static_cast<int>(verdict.exit_code)},
                     {"usable", UsabilityName(verdict.overall)},
                     {"verdict", verdict.Lines()},
                     {"parameters", parameters},
                     {"repetitions", RepetitionsJson(*checks.repetitions)},
                     {"provenance",
                      {{"version", Version()},
                       {"git", GitHash()},
                       {"input_sha256", sha256},
                       {"flags", checks.flags},
                       {"threads", checks.num_threads}}}};
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace clothid
