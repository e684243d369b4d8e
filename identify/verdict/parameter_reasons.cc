// Reasons that lie in what the recordings tell of each parameter.
#include <algorithm>
#include <cmath>

#include "identify/verdict/reason.h"
#include "identify/verdict/told.h"

namespace clothid {
namespace {

// Ends of an interval that differ by more than this factor are worth a word.
constexpr double kWideFactor = 5.0;

std::vector<int> FreeParameters(const FitSummary& summary) {
  std::vector<int> free;
  for (int i = 0; i < static_cast<int>(summary.parameters.size()); ++i) {
    if (!summary.parameters[i].frozen) free.push_back(i);
  }
  return free;
}

// What is known of a direction at its bounds: of itself, or of the only parameter in it. Null: nobody looked.
const BoundCheck* CheckOf(const FitSummary& summary, int direction) {
  const std::string& words = summary.uncertainty->hidden_directions[direction].words;
  const auto it = std::find_if(summary.bound_checks.begin(), summary.bound_checks.end(), [&](const BoundCheck& check) {
    return check.direction == direction || (check.parameter >= 0 && summary.parameters[check.parameter].name == words);
  });
  return it == summary.bound_checks.end() ? nullptr : &*it;
}

// What happens as the parameters of a hidden direction move from bound to bound.
std::string MoveText(const Uncertainty& uncertainty, int direction, const BoundCheck* check) {
  const bool is_known = check != nullptr && !std::isnan(check->rise_below + check->rise_above);
  const double change = check == nullptr ? 0.0 : std::max(1.0, uncertainty.residual_scale) * check->change();
  if (check != nullptr && (check->is_worse_below() || check->is_worse_above())) {
    return "its derivative shows no change of the prediction, but at a bound it changes by " + NumberText(change, 2) +
           " standard deviations; --profile tells more";
  }
  // Below a hundredth it may be the rounding of rollouts.
  const double shown =
      std::max(is_known && change > 0.01 ? change : 0.0, uncertainty.hidden_directions[direction].visible_change);
  return std::string(is_known ? "" : "by its derivative, ") + "moved from bound to bound, the prediction changes by " +
         NumberText(shown, 2) + " standard deviations";
}

void AddHidden(const FitSummary& summary, const std::vector<int>& hidden, std::vector<Reason>* reasons) {
  if (hidden.empty()) return;
  const std::string brief = "not told by the recording";
  const std::vector<HiddenDirection>& directions = summary.uncertainty->hidden_directions;
  if (directions.empty()) {
    reasons->push_back(NotTold(hidden, brief, "not identifiable: " + NamesText(summary, hidden)));
  }
  for (int k = 0; k < static_cast<int>(directions.size()); ++k) {
    const BoundCheck* const check = CheckOf(summary, k);
    if (check != nullptr && check->parameter >= 0 &&
        summary.uncertainty->parameters[check->parameter].has_excluded_side()) {
      continue;  // said of the parameter
    }
    reasons->push_back(NotTold(
        hidden, brief, "not identifiable: " + directions[k].words + ": " + MoveText(*summary.uncertainty, k, check)));
  }
}

// Of one whose derivative tells nothing.
void AddExcludedSide(const FitSummary& summary, int index, std::vector<Reason>* reasons) {
  const std::string range = RangeText(summary.uncertainty->parameters[index]);
  const std::string brief = summary.parameters[index].name + " is " + range;
  reasons->push_back({Usability::kWithCare,
                      kExitNotIdentifiable,
                      {index},
                      brief,
                      brief + ": beyond, the cost rises by more than 3.84 wherever the others are; which of the values "
                              "that are left it is nothing tells, and the estimate is but one of them"});
}

// "1 %": how far `step` of its coordinate takes a parameter.
std::string StepText(const FittedParameter& parameter, double step) {
  return PercentText(step / (parameter.scale == ParameterScale::kLog ? 1.0 : std::abs(parameter.value)), 2);
}

// "mu is 0.8, k_bend 1.2 standard deviations from the minimum of .."
std::string StallText(const FitSummary& summary, const std::vector<int>& stalled) {
  std::vector<std::string> distances;
  for (const int i : stalled) {
    distances.push_back(summary.parameters[i].name + (distances.empty() ? " is " : " ") +
                        NumberText(summary.uncertainty->parameters[i].distance, 2));
  }
  return JoinWords(distances) +
         " standard deviations from the minimum of the quadratic model at the estimate, which promises a cost lower " +
         "by " + NumberText(summary.uncertainty->predicted_decrease, 2) +
         " s^2: the fit stopped early, or at a kink of the cost; ";
}

void AddStalled(const FitSummary& summary, const std::vector<int>& stalled, std::vector<Reason>* reasons) {
  if (stalled.empty()) return;
  reasons->push_back(NotTold(stalled, "the fit stalled", StallText(summary, stalled) + "no interval is given"));
}

// Of those whose intervals count with the distance.
void AddStalledNear(const FitSummary& summary, std::vector<Reason>* reasons) {
  std::vector<int> stalled;
  for (std::size_t i = 0; i < summary.parameters.size(); ++i) {
    if (!std::isnan(summary.uncertainty->parameters[i].stall_error)) stalled.push_back(static_cast<int>(i));
  }
  if (stalled.empty()) return;
  reasons->push_back(Careful(stalled, "the fit stalled near its minimum",
                             StallText(summary, stalled) + "the interval counts with that distance"));
}

void AddHardlyTold(const FitSummary& summary, const FitChecks& checks, int index, std::vector<Reason>* reasons) {
  const std::string& name = summary.parameters[index].name;
  const ParameterUncertainty& parameter = summary.uncertainty->parameters[index];
  if (parameter.is_hardly_told()) {
    const std::string how =
        parameter.reaches_lower && parameter.reaches_upper
            ? "reaches from bound to bound"
            : "is " + NumberText(parameter.share_of_belief, 2) + " of what was believed before" +
                  (parameter.reaches_lower || parameter.reaches_upper ? ", and reaches a bound" : "");
    // Above sqrt(2) of the noise the errors are more than it. Those that nobody asked for are not judged by.
    const bool is_discretization = checks.discretization && parameter.total_std() > std::sqrt(2.0) * parameter.std;
    const std::string brief =
        is_discretization ? "hardly told at this time step and mesh" : "hardly told by the recording";
    const std::string advice = is_discretization ? "most of it are their errors" : "give narrower bounds or freeze it";
    reasons->push_back(NotTold({index}, brief, name + " is " + brief + ": its 95 % interval " + how + "; " + advice));
    return;
  }
  // Its value is known, but not from this side.
  const std::string side = parameter.reaches_lower ? "lower" : "upper";
  const std::string brief = "the interval of " + name + " reaches its " + side + " bound";
  reasons->push_back(
      {Usability::kWithCare,
       kExitNotIdentifiable,
       {index},
       brief,
       brief + ": the recording tells only " + (parameter.reaches_lower ? "how large" : "how small") + " it can be"});
}

void AddUndetermined(const FitSummary& summary, const FitChecks& checks, const std::vector<int>& free,
                     std::vector<Reason>* reasons) {
  std::vector<int> hidden, stalled;
  for (const int i : free) {
    const ParameterUncertainty& parameter = summary.uncertainty->parameters[i];
    const bool reaches_bound = parameter.reaches_lower || parameter.reaches_upper;
    if (HasExcludedSide(summary, checks, i)) {
      AddExcludedSide(summary, i, reasons);
      continue;
    }
    if (summary.parameters[i].at_bound) {
      reasons->push_back(
          NotTold({i}, "at its bound", summary.parameters[i].name + " stands at its bound: no interval is given"));
    } else if (parameter.stalled) {
      stalled.push_back(i);
    } else if (parameter.visible && (parameter.is_hardly_told() || reaches_bound)) {
      AddHardlyTold(summary, checks, i, reasons);
    }
    if (!parameter.visible && !parameter.beside_prior && !summary.parameters[i].is_knot) hidden.push_back(i);
  }
  AddStalled(summary, stalled, reasons);
  AddHidden(summary, hidden, reasons);
}

void AddWide(const FitSummary& summary, int index, std::vector<Reason>* reasons) {
  const ParameterUncertainty& parameter = summary.uncertainty->parameters[index];
  if (!parameter.identifiable || !(parameter.factor > kWideFactor)) return;
  const std::string brief = "the interval of " + summary.parameters[index].name + " is wide";
  reasons->push_back(
      Careful({index}, brief, brief + ": its ends differ by a factor of " + NumberText(parameter.factor, 2)));
}

void AddIntervalCheck(const FitSummary& summary, const FitChecks& checks, std::vector<Reason>* reasons) {
  if (!summary.interval_check || summary.interval_check->is_quadratic()) return;
  const IntervalCheck& check = *summary.interval_check;
  if (check.better.size() > 0 || !IsIdentifiable(summary, checks, check.parameter).value_or(false)) return;
  const auto rise = [](double value) {
    return std::isnan(value) ? std::string("nothing that can be told") : NumberText(value, 2);
  };
  const std::string brief = "the interval of " + summary.parameters[check.parameter].name + " cannot be relied on";
  reasons->push_back(Careful({check.parameter}, brief,
                             brief + ": at its ends the cost rises by " + rise(check.rise_below) + " and " +
                                 rise(check.rise_above) + " instead of 3.84; see --profile and --starts"));
}

}  // namespace

void AddParameterReasons(const FitSummary& summary, const FitChecks& checks, std::vector<Reason>* reasons) {
  const std::vector<int> free = FreeParameters(summary);
  if (free.empty()) return;
  if (!summary.uncertainty) {
    if (summary.status != FitStatus::kConverged) return;
    reasons->push_back(NotTold(free, "no interval", "no interval is given: there is no derivative at the estimate"));
    return;
  }
  AddUndetermined(summary, checks, free, reasons);
  AddStalledNear(summary, reasons);
  AddIntervalCheck(summary, checks, reasons);
  for (const int i : free) AddWide(summary, i, reasons);
}

void AddDentReasons(const FitSummary& summary, const FitChecks& checks, std::vector<Reason>* reasons) {
  for (const DentCheck& check : summary.dents) {
    if (HasLostDerivative(summary, check.parameter)) {
      const std::string& name = summary.parameters[check.parameter].name;
      reasons->push_back(NotTold({check.parameter}, "lost in a rough cost",
                                 "the derivative by " + name +
                                     " is lost: rollouts amplify what changes until nothing of "
                                     "it is left that the cost shows; look at the landscape"));
      continue;
    }
    if (!check.is_dent() || !HasInterval(summary, checks, check.parameter)) continue;
    const FittedParameter& parameter = summary.parameters[check.parameter];
    const std::string brief = "the interval of " + parameter.name + " is that of one dent of a rough cost";
    const auto rise = [](double value) { return std::isnan(value) ? std::string("nothing") : NumberText(value, 2); };
    reasons->push_back(Careful({check.parameter}, brief,
                               brief + ": " + StepText(parameter, check.step) +
                                   " below and above it the cost rises by " + rise(check.rise_below) + " and " +
                                   rise(check.rise_above) + " instead of " + NumberText(check.expected_rise, 2) +
                                   "; what --starts or a landscape show is its width"));
  }
}

}  // namespace clothid
