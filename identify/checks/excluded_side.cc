#include "identify/checks/excluded_side.h"

#include "identify/checks/profile.h"

namespace clothid {

void AddExcludedSides(const FitOptions& options, FitProblem* problem, FitSummary* summary) {
  if (!summary->uncertainty) return;
  const auto end = [&](int index, int side) {
    return ProfileEnd(options, *summary, index, side, problem, &summary->statistics);
  };
  for (const BoundCheck& check : summary->bound_checks) {
    if (check.parameter < 0 || options.is_cancelled()) continue;
    ParameterUncertainty& parameter = summary->uncertainty->parameters[check.parameter];
    if (parameter.visible) continue;
    if (check.is_worse_below()) parameter.lower95 = end(check.parameter, -1);
    if (check.is_worse_above()) parameter.upper95 = end(check.parameter, +1);
  }
}

}  // namespace clothid
