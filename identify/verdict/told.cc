#include "identify/verdict/told.h"

#include <cmath>

namespace clothid {

std::optional<bool> IsIdentifiable(const FitSummary& summary, const FitChecks& checks, int index) {
  if (summary.parameters[index].frozen || !summary.uncertainty) return std::nullopt;
  const bool is_ambiguous = checks.starts && !checks.starts->ambiguous.empty() && checks.starts->ambiguous[index];
  return summary.uncertainty->parameters[index].identifiable && !is_ambiguous;
}

bool HasInterval(const FitSummary& summary, const FitChecks& checks, int index) {
  if (summary.parameters[index].frozen || !summary.uncertainty) return false;
  const bool is_ambiguous = checks.starts && !checks.starts->ambiguous.empty() && checks.starts->ambiguous[index];
  return !std::isnan(summary.uncertainty->parameters[index].std) && !is_ambiguous;
}

std::string ParameterRemark(const FitSummary& summary, const FitChecks& checks, int index) {
  if (summary.parameters[index].frozen) return "frozen";
  if (IsIdentifiable(summary, checks, index).value_or(true)) {
    return summary.parameters[index].at_bound ? "at its bound" : "";
  }
  const ParameterUncertainty& parameter = summary.uncertainty->parameters[index];
  if (parameter.stalled) return "stalled";
  if (parameter.visible && summary.parameters[index].at_bound) return "at its bound";
  if (!HasInterval(summary, checks, index)) return "not identifiable";
  return parameter.is_hardly_told() ? "hardly told" : "reaches a bound";
}

}  // namespace clothid
