// Reasons that lie in what was looked at beside the fit.
#include <algorithm>
#include <cmath>

#include "identify/verdict/model_error_text.h"
#include "identify/verdict/reason.h"

namespace clothid {
namespace {

// A profile that falls below the estimate by more than the first was not the minimum; in s^2, by more than the second
// the fit should have ended elsewhere.
constexpr double kProfileRounding = 1e-3;
constexpr double kClearlyLower = 0.1;

// Energy that comes from nowhere, as a share of the largest energy: from here on the motion is another.
constexpr double kLargeEnergyGain = 0.1;

void AddMinimum(const FitSummary& summary, const MultiStart& starts, const Minimum& other,
                std::vector<Reason>* reasons) {
  constexpr double kFarHigher = 1e4;
  const std::string line = std::to_string(other.num_starts) + " of " + std::to_string(starts.starts.size()) +
                           " ended in another minimum, " + ValuesText(summary, other.values) + ", rmse " +
                           MillimetreText(other.rmse) + ": ";
  if (other.is_distinguishable()) {
    const double ratio = other.cost / starts.minima.front().cost;
    reasons->push_back(Remark(line + "not preferred, its cost is " +
                              (ratio < kFarHigher ? NumberText(ratio, 3) + " times" : "far above") + " the lowest"));
    return;
  }
  std::vector<int> ambiguous;
  for (int i = 0; i < static_cast<int>(starts.ambiguous.size()); ++i) {
    if (starts.ambiguous[i]) ambiguous.push_back(i);
  }
  if (ambiguous.empty()) {
    reasons->push_back(Remark(line + "the recording cannot tell it from the preferred one"));
    return;
  }
  reasons->push_back(
      NotTold(ambiguous, "another minimum fits as well", line + "the recording cannot tell it from the preferred one"));
}

void AddStarts(const FitSummary& summary, const MultiStart& starts, std::vector<Reason>* reasons) {
  const std::string total = std::to_string(starts.starts.size());
  const auto num_unconverged = std::count_if(starts.starts.begin(), starts.starts.end(),
                                             [](const StartResult& start) { return start.minimum < 0; });
  if (num_unconverged > 0) {
    reasons->push_back(Remark(std::to_string(num_unconverged) + " of " + total + " starts did not converge"));
  }
  if (starts.minima.empty()) return;
  const Minimum& first = starts.minima.front();
  reasons->push_back(Remark(std::to_string(first.num_starts) + " of " + total +
                            " starts ended in the same minimum, rmse " + MillimetreText(first.rmse) +
                            (starts.minima.size() > 1 ? ": the preferred one" : "")));
  for (std::size_t m = 1; m < starts.minima.size(); ++m) AddMinimum(summary, starts, starts.minima[m], reasons);
}

int IndexOf(const FitSummary& summary, const std::string& name) {
  const auto it = std::find_if(summary.parameters.begin(), summary.parameters.end(),
                               [&](const FittedParameter& parameter) { return parameter.name == name; });
  return static_cast<int>(it - summary.parameters.begin());
}

void AddProfileInterval(const FitSummary& summary, const Profile& profile, std::vector<Reason>* reasons) {
  const auto end = [](double value) { return std::isnan(value) ? std::string("open") : NumberText(value, 6); };
  const std::string line = "profile of " + profile.parameter + ": 95 % interval " + end(profile.lower95) + " .. " +
                           end(profile.upper95) +
                           (profile.has_no_noise ? ": that of the optimiser, there is no noise" : "");
  const int num_open = (std::isnan(profile.lower95) ? 1 : 0) + (std::isnan(profile.upper95) ? 1 : 0);
  const std::vector<int> parameter = {IndexOf(summary, profile.parameter)};
  if (num_open == 2) {
    reasons->push_back(NotTold(parameter, "its profile is open", line));
  } else if (num_open == 1) {
    reasons->push_back(Careful(parameter, "the profile of " + profile.parameter + " is open on one side", line));
  } else {
    reasons->push_back(Remark(line));
  }
}

void AddProfiles(const FitSummary& summary, const FitChecks& checks, std::vector<Reason>* reasons) {
  for (const Profile& profile : checks.profiles) {
    AddProfileInterval(summary, profile, reasons);
    const auto lowest =
        std::min_element(profile.points.begin(), profile.points.end(),
                         [](const ProfilePoint& a, const ProfilePoint& b) { return a.cost_rise < b.cost_rise; });
    if (lowest == profile.points.end() || !(lowest->cost_rise < -kProfileRounding)) continue;
    reasons->push_back(AgainstAll(-0.5 * lowest->cost_rise > kClearlyLower, "a profile met a point of lower cost",
                                  "profile of " + profile.parameter + ": a lower cost was found at " +
                                      ValuesText(summary, lowest->values) + ": fit again from there"));
  }
}

void AddHoldout(const Holdout& holdout, std::vector<Reason>* reasons) {
  const std::string brief = holdout.failure.empty()
                                ? "what was held out is predicted worse than by the nominal parameters"
                                : "what was held out cannot be predicted";
  const auto add = [&](const std::string& line) {
    reasons->push_back(holdout.has_failed() ? Reason{Usability::kDoNotUse, kExitHoldoutFailed, {}, brief, line}
                                            : Remark(line));
  };
  if (!holdout.failure.empty()) add("held out: " + holdout.failure);
  if (holdout.has_only_forces && !std::isnan(holdout.force_rms + holdout.nominal_force_rms)) {
    add(std::string("held out: the estimates predict forces ") + (holdout.has_failed() ? "worse" : "better") +
        " than the nominal parameters, root mean square " + NumberText(holdout.force_rms) + " N against " +
        NumberText(holdout.nominal_force_rms) + " N");
  }
  if (std::isnan(holdout.rmse) || std::isnan(holdout.nominal_rmse)) return;
  add(std::string("held out: the estimates predict ") + (holdout.has_failed() ? "worse" : "better") +
      " than the nominal parameters, rmse " + MillimetreText(holdout.rmse) +
      (std::isnan(holdout.nodes_rmse) ? "" : " (nodes " + MillimetreText(holdout.nodes_rmse) + ")") + " against " +
      MillimetreText(holdout.nominal_rmse) +
      (std::isnan(holdout.cost + holdout.nominal_cost)
           ? ""
           : ", as the loss counts " + NumberText(holdout.cost) + " against " + NumberText(holdout.nominal_cost)));
  if (!holdout.lead_times.empty())
    reasons->push_back(Remark("held out: predicts " + LeadTimesText(holdout.lead_times)));
}

void AddEnergy(const EnergyGain& gain, const std::string& prefix, std::vector<Reason>* reasons) {
  if (!(gain.share() >= kMostEnergyGain)) return;
  const std::string brief = prefix + "the simulation gains energy that no work pays for";
  reasons->push_back(AgainstAll(gain.share() >= kLargeEnergyGain, brief,
                                brief + ", " + NumberText(gain.energy) + " J by " + NumberText(gain.time) + " s, " +
                                    NumberText(100.0 * gain.share(), 3) + " % of the largest: " + gain.remedy()));
}

// "3 of 80 steps".
std::string StepsText(int count, const SelfContactAudit& audit) {
  return std::to_string(count) + " of " + std::to_string(audit.num_states - 1) + " steps";
}

// A cloth that meets itself: where derivatives are not promised, and where it passes through itself.
void AddSelfContact(const SelfContactAudit& audit, JacobianMethod jacobian, const std::string& prefix,
                    std::vector<Reason>* reasons) {
  if (audit.num_states == 0) return;
  if (audit.dependent_steps > 0 && jacobian != JacobianMethod::kNumeric) {
    const std::string brief =
        prefix + "derivatives are not promised in " + StepsText(audit.dependent_steps, audit) + " at the estimate";
    reasons->push_back(Careful({}, brief,
                               brief +
                                   ", in which contacts of the cloth with itself depend on each other: a fit may end "
                                   "early there, and its intervals may be wrong; compare with --jacobian numeric"));
  }
  if (audit.num_cut > 0) {
    const std::string brief = prefix + "the simulated cloth passes through itself";
    reasons->push_back(Careful({}, brief,
                               brief + ": " + std::to_string(audit.intersections) +
                                   " pairs of triangles cut each other, in " + StepsText(audit.num_cut, audit) +
                                   " at the estimate, from step " + std::to_string(audit.first_cut) +
                                   " on: take shorter steps"));
    return;
  }
  reasons->push_back(Remark(prefix +
                            "the simulated cloth stays out of itself, and comes nearer than its thickness by " +
                            MillimetreText(audit.violation, 2) + " at most"));
}

void AddField(const FittedField& field, std::vector<Reason>* reasons) {
  const std::string& name = field.request.name;
  const auto size = static_cast<double>(field.values.size());
  const double undetermined = std::round(size * (1.0 - ShareDetermined(field)));
  if (field.log_std.size() == 0 || undetermined == 0.0) return;
  const std::string line = "the recordings do not determine the field " + name + " at " + NumberText(undetermined) +
                           " of " + NumberText(size) + " control nodes: there it is what was believed beforehand";
  reasons->push_back(undetermined == size ? NotTold({}, "the field " + name + " is not told", line)
                                          : Careful({}, "the field " + name + " is not told everywhere", line));
}

}  // namespace

void AddCheckReasons(const FitSummary& summary, const FitChecks& checks, std::vector<Reason>* reasons) {
  if (summary.fields) {
    for (const FittedField& field : summary.fields->fields) AddField(field, reasons);
  }
  if (checks.starts) AddStarts(summary, *checks.starts, reasons);
  AddProfiles(summary, checks, reasons);
  if (checks.holdout) AddHoldout(*checks.holdout, reasons);
  if (checks.holdout && checks.held_bands) {
    reasons->push_back(Remark("held out: " + HeldBandsText(*checks.held_bands, checks.holdout->has_only_forces)));
  }
  for (std::size_t r = 0; r < checks.energy.size(); ++r) {
    AddEnergy(checks.energy[r], checks.energy.size() > 1 ? checks.recordings[r].name + ": " : "", reasons);
  }
  for (std::size_t r = 0; r < checks.self_contact.size(); ++r) {
    AddSelfContact(checks.self_contact[r], checks.jacobian,
                   checks.self_contact.size() > 1 ? checks.recordings[r].name + ": " : "", reasons);
  }
}

}  // namespace clothid
