#include "identify/verdict/told.h"

#include <algorithm>
#include <cmath>

#include "identify/base/join_words.h"

namespace clothid {

namespace {

bool IsInDent(const FitSummary& summary, int index) {
  return std::any_of(summary.dents.begin(), summary.dents.end(),
                     [&](const DentCheck& check) { return check.parameter == index && check.is_dent(); });
}

// A derivative that promises so many times what the cost rises by 1 % away is none of the cost that matters.
constexpr double kLost = 1e6;

bool IsLost(const DentCheck& check) {
  const double rise = std::fmax(std::abs(check.rise_below), std::abs(check.rise_above));
  return !(check.expected_rise > 0.0) || check.expected_rise > kLost * std::fmax(1.0, rise);
}

// Another start ended at another value that fits as well.
bool IsAmbiguous(const FitChecks& checks, int index) {
  return checks.starts && !checks.starts->ambiguous.empty() && checks.starts->ambiguous[index];
}

}  // namespace

bool HasLostDerivative(const FitSummary& summary, int index) {
  return std::any_of(summary.dents.begin(), summary.dents.end(),
                     [&](const DentCheck& check) { return check.parameter == index && IsLost(check); });
}

std::optional<bool> IsIdentifiable(const FitSummary& summary, const FitChecks& checks, int index) {
  if (summary.parameters[index].frozen || !summary.uncertainty) return std::nullopt;
  return summary.uncertainty->parameters[index].identifiable && !IsAmbiguous(checks, index);
}

bool HasInterval(const FitSummary& summary, const FitChecks& checks, int index) {
  if (summary.parameters[index].frozen || !summary.uncertainty) return false;
  return !std::isnan(summary.uncertainty->parameters[index].std) && !IsAmbiguous(checks, index) &&
         !HasLostDerivative(summary, index);
}

bool HasExcludedSide(const FitSummary& summary, const FitChecks& checks, int index) {
  return summary.uncertainty && summary.uncertainty->parameters[index].has_excluded_side() &&
         !IsAmbiguous(checks, index);
}

std::string RangeText(const ParameterUncertainty& parameter) {
  constexpr int kDigits = 5;
  const std::string lower = NumberText(parameter.lower95, kDigits), upper = NumberText(parameter.upper95, kDigits);
  if (std::isnan(parameter.upper95)) return "at least " + lower;
  return std::isnan(parameter.lower95) ? "at most " + upper : "between " + lower + " and " + upper;
}

namespace {

std::string ToldRemark(const FitSummary& summary, const FitChecks& checks, int index) {
  if (summary.parameters[index].frozen) return "frozen";
  if (IsIdentifiable(summary, checks, index).value_or(true)) {
    if (summary.parameters[index].at_bound) return "at its bound";
    if (HasLostDerivative(summary, index)) return "lost in a rough cost";
    return IsInDent(summary, index) ? "one dent" : "";
  }
  const ParameterUncertainty& parameter = summary.uncertainty->parameters[index];
  if (parameter.stalled) return "stalled";
  if (HasExcludedSide(summary, checks, index)) return "told by what is excluded";
  if (parameter.visible && summary.parameters[index].at_bound) return "at its bound";
  if (!HasInterval(summary, checks, index)) return "not identifiable";
  if (summary.parameters[index].is_knot && !parameter.visible) return "as smooth as believed";
  if (parameter.beside_prior && !parameter.beside_prior->is_told) {
    return parameter.beside_prior->adds_nothing() ? "as believed" : "by its prior";
  }
  return parameter.is_hardly_told() ? "hardly told" : "reaches a bound";
}

std::string PartsRemark(const FitSummary& summary, const FitChecks& checks, int index) {
  if (!HasInterval(summary, checks, index)) return "";
  const ParameterUncertainty& parameter = summary.uncertainty->parameters[index];
  if (!(parameter.total_std() > std::sqrt(2.0) * parameter.std)) return "";
  std::string text = "noise +- " + NumberText(parameter.std, 2);
  if (!std::isnan(parameter.step_error)) text += ", step +- " + NumberText(parameter.step_error, 2);
  if (!std::isnan(parameter.mesh_error)) text += ", mesh +- " + NumberText(parameter.mesh_error, 2);
  if (!std::isnan(parameter.memory_error)) text += ", memory +- " + NumberText(parameter.memory_error, 2);
  if (!std::isnan(parameter.stall_error)) text += ", stall +- " + NumberText(parameter.stall_error, 2);
  return text;
}

}  // namespace

std::string ParameterRemark(const FitSummary& summary, const FitChecks& checks, int index) {
  const std::string told = ToldRemark(summary, checks, index), parts = PartsRemark(summary, checks, index);
  return told + (told.empty() || parts.empty() ? "" : "; ") + parts;
}

std::string PriorRemark(const FitSummary& summary, int index) {
  const FittedParameter& parameter = summary.parameters[index];
  if (!parameter.prior.is_given()) return "";
  const std::string prior = PriorText(parameter.prior, parameter.scale);
  if (!summary.uncertainty || !summary.uncertainty->parameters[index].beside_prior) return prior;
  const ToldBesidePrior& told = *summary.uncertainty->parameters[index].beside_prior;
  return prior + "; " + (told.adds_nothing() ? "the recording adds nothing" : "the recording makes it narrower") +
         ": the standard deviation is " + NumberText(told.share, 2) + " of the prior's";
}

}  // namespace clothid
