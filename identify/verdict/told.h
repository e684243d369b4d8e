// What the recordings tell of a parameter.
#ifndef CLOTHID_IDENTIFY_VERDICT_TOLD_H_
#define CLOTHID_IDENTIFY_VERDICT_TOLD_H_

#include <optional>
#include <string>

#include "identify/estimate/fit_summary.h"
#include "identify/verdict/fit_checks.h"

namespace clothid {

// Whether the recordings determine parameter `index`: its derivative and its interval say so
// (identify/uncertainty/uncertainty.h), and no other start ended at another value that fits as well. Absent: frozen, or
// the derivative at the estimate could not be evaluated.
std::optional<bool> IsIdentifiable(const FitSummary& summary, const FitChecks& checks, int index);

// Whether its derivative is that of a rollout that forgets where it comes from: 1 % away the cost rises by less than a
// millionth of what it promises (`DentCheck`), or its sign is lost.
bool HasLostDerivative(const FitSummary& summary, int index);

// Whether parameter `index` has an interval to show. One that is hardly told has, for that it is wide is the answer;
// one whose value another start contradicts, that the fit stalled at, or whose derivative is lost, has none.
bool HasInterval(const FitSummary& summary, const FitChecks& checks, int index);

// Whether it has an end of an interval to show though the derivative tells nothing of it: values beyond are excluded
// (identify/checks/excluded_side.h); and in words, "at least 0.364", "at most 0.4", "between 0.3 and 0.4".
bool HasExcludedSide(const FitSummary& summary, const FitChecks& checks, int index);
std::string RangeText(const ParameterUncertainty& parameter);

// What stands beside a parameter in a table: "frozen", "not identifiable", "told by what is excluded", "hardly told",
// "stalled", "reaches a bound", "at its bound", "one dent" of one whose interval is that of a dent
// (identify/estimate/interval_check.h), "lost in a rough cost", "as believed" and "by its prior" of one that is not
// identifiable without its prior, or nothing; and where errors of time step and mesh exceed the noise what each of them
// is, "noise +- 0.0045, step +- 0.017".
std::string ParameterRemark(const FitSummary& summary, const FitChecks& checks, int index);

// "1e-05, factor 2; the recording adds nothing" of parameter `index`; empty where it has no prior.
std::string PriorRemark(const FitSummary& summary, int index);

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_VERDICT_TOLD_H_
