#include "identify/report/repetition_page.h"

#include <string_view>

#include "identify/report/page_template.h"
#include "identify/report/repetition_report.h"
#include "identify/verdict/repetition_text.h"

namespace clothid {

// Files embedded by CMake.
std::string_view PooledPage();               // pooled_page.html
std::string_view PooledScript();             // its verdict and provenance
std::string_view ReportRepetitionsScript();  // report_repetitions.js

nlohmann::ordered_json RepetitionLinesJson(const Repetitions& repetitions) {
  nlohmann::ordered_json lines = nlohmann::ordered_json::object();
  for (const PooledParameter& parameter : repetitions.parameters) lines[parameter.name] = RepetitionLine(parameter);
  return lines;
}

std::string PooledHtml(const FitSummary& summary, const FitChecks& checks, const Verdict& verdict) {
  const nlohmann::ordered_json data = {
      {"result", nlohmann::ordered_json::parse(PooledResultJson(summary, checks, verdict))},
      {"repetition_lines", RepetitionLinesJson(*checks.repetitions)}};
  const PageParts page = {
      "Repetitions", PooledPage(), {}, /*has_charts=*/false, {PooledScript(), ReportRepetitionsScript()}};
  return MakePage(page, ScriptText(data));
}

}  // namespace clothid
