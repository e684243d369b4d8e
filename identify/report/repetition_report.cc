#include "identify/report/repetition_report.h"

#include <cmath>
#include <iomanip>
#include <limits>
#include <sstream>
#include <string_view>

#include "identify/base/version.h"
#include "identify/page/page_template.h"
#include "identify/report/interval_text.h"
#include "identify/verdict/repetition_text.h"

namespace clothid {

// Files embedded by CMake.
std::string_view PooledPage();               // pooled_page.html
std::string_view PooledScript();             // its verdict and provenance
std::string_view ReportRepetitionsScript();  // report_repetitions.js

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

std::string RangeOf(double value, double lower, double upper) {
  return IntervalText(value, 0.5 * (upper - lower) / kNormal95, lower, upper);
}

class Rows {
 public:
  void Add(const std::string& name, const std::string& value, const std::string& interval, const std::string& remark) {
    std::ostringstream row;
    row << std::left << std::setw(15) << name << ' ' << std::setw(13) << value << " " << std::setw(28) << interval
        << remark;
    const std::string text = row.str();
    rows_ << text.substr(0, text.find_last_not_of(' ') + 1) << "\n";
  }
  std::string Text() const { return rows_.str(); }

 private:
  std::ostringstream rows_;
};

void AddEstimates(const Repetitions& repetitions, const PooledParameter& parameter, Rows* rows) {
  std::size_t k = 0;
  for (std::size_t r = 0; r < repetitions.fits.size(); ++r) {
    const SingleFit& fit = repetitions.fits[r];
    const SingleEstimate* estimate = fit.Find(parameter.name);
    const bool is_pooled = k < parameter.fits.size() && parameter.fits[k] == static_cast<int>(r);
    std::string remark = fit.name + (is_pooled ? "" : "  left out");
    if (is_pooled && parameter.is_pooled() && !parameter.effects.left_out[k].fits)
      remark += "  does not fit the others";
    k += is_pooled ? 1 : 0;
    if (estimate == nullptr) {
      rows->Add("", "-", "-", remark);
      continue;
    }
    rows->Add("", NumberText(estimate->value, 6), RangeOf(estimate->value, estimate->lower95, estimate->upper95),
              remark);
  }
}

void AddPooled(const PooledParameter& parameter, Rows* rows) {
  const RandomEffects& effects = parameter.effects;
  const auto text = [&](double difference) { return DifferenceText(parameter.scale, difference); };
  rows->Add("  mean", NumberText(parameter.mean, 6), RangeOf(parameter.mean, parameter.lower95, parameter.upper95),
            "of " + std::to_string(parameter.fits.size()) + " recordings");
  rows->Add("  next", "", RangeOf(parameter.mean, parameter.next_lower95, parameter.next_upper95),
            "of the next specimen");
  rows->Add("  scatter", text(effects.tau), text(effects.tau_lower95) + " .. " + text(effects.tau_upper95),
            "between recordings, beside the " + text(effects.typical_std) + " that their intervals explain");
  if (effects.common_error > 0.0) {
    rows->Add("  common", text(effects.common_error), "", "error of time step and mesh, in all recordings alike");
  }
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

std::string RepetitionRows(const Repetitions& repetitions) {
  Rows rows;
  rows.Add("repetitions", "estimate", "95 % interval", "each recording fitted for itself");
  for (const PooledParameter& parameter : repetitions.parameters) {
    rows.Add(parameter.name, "", "", "");
    AddEstimates(repetitions, parameter, &rows);
    if (parameter.is_pooled()) AddPooled(parameter, &rows);
  }
  return rows.Text();
}

Json RepetitionLinesJson(const Repetitions& repetitions) {
  Json lines = Json::object();
  for (const PooledParameter& parameter : repetitions.parameters) lines[parameter.name] = RepetitionLine(parameter);
  return lines;
}

std::string PooledHtml(const FitSummary& summary, const FitChecks& checks, const Verdict& verdict) {
  const Json data = {{"result", Json::parse(PooledResultJson(summary, checks, verdict))},
                     {"repetition_lines", RepetitionLinesJson(*checks.repetitions)}};
  const PageParts page = {
      "Repetitions", PooledPage(), {}, /*has_charts=*/false, {PooledScript(), ReportRepetitionsScript()}};
  return MakePage(page, ScriptText(data));
}

}  // namespace clothid
