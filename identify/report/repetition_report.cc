#include "identify/report/repetition_report.h"

#include <iomanip>
#include <sstream>
#include <string_view>

#include "identify/page/page_template.h"
#include "identify/report/interval_text.h"
#include "identify/result/repetition_json.h"
#include "identify/verdict/repetition_text.h"

namespace clothid {

// Files embedded by CMake.
std::string_view PooledPage();               // pooled_page.html
std::string_view PooledScript();             // its verdict and provenance
std::string_view ReportRepetitionsScript();  // report_repetitions.js

namespace {

using Json = nlohmann::ordered_json;

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
