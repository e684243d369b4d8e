#include "identify/verdict/verdict.h"

#include <algorithm>
#include <cmath>
#include <iomanip>
#include <sstream>

namespace clothid {
namespace {

std::string Number(double value, int digits = 4) {
  std::ostringstream text;
  text << std::setprecision(digits) << value;
  return text.str();
}

std::string Millimetres(double metres) { return Number(1e3 * metres) + " mm"; }

bool IsAnyUnidentifiable(const FitSummary& summary, const FitChecks& checks) {
  for (int i = 0; i < static_cast<int>(summary.parameters.size()); ++i) {
    if (summary.parameters[i].frozen) continue;
    if (!IsIdentifiable(summary, checks, i).value_or(false)) return true;
  }
  return false;
}

// Standard deviations between an estimate and the minimum of the quadratic model there; converged fits stay below it.
constexpr double kFarFromMinimum = 1.0;
// A profile that falls below the estimate by more than this was not the minimum.
constexpr double kProfileRounding = 1e-3;

// "mu 0.3, k_stretch 50"
std::string Values(const FitSummary& summary, const Eigen::VectorXd& values) {
  std::string text;
  for (std::size_t i = 0; i < summary.parameters.size(); ++i) {
    if (summary.parameters[i].frozen) continue;
    text +=
        (text.empty() ? "" : ", ") + summary.parameters[i].name + " " + Number(values[static_cast<Eigen::Index>(i)]);
  }
  return text;
}

void AddIdentifiability(const FitSummary& summary, std::vector<std::string>* lines) {
  if (!summary.uncertainty) return;
  const Uncertainty& uncertainty = *summary.uncertainty;
  for (const HiddenDirection& direction : uncertainty.hidden_directions) {
    lines->push_back("not identifiable: " + direction.words +
                     ": moved from bound to bound, the prediction changes by " + Number(direction.visible_change, 2) +
                     " standard deviations");
  }
  for (std::size_t i = 0; i < summary.parameters.size(); ++i) {
    const FittedParameter& parameter = summary.parameters[i];
    if (parameter.at_bound) lines->push_back(parameter.name + " stands at its bound: no interval is given");
  }
}

// "mu 2.1, k_stretch 3": by how much intervals are wider than those of independent residuals.
std::string Widenings(const FitSummary& summary) {
  std::string text;
  for (std::size_t i = 0; i < summary.parameters.size(); ++i) {
    const ParameterUncertainty& parameter = summary.uncertainty->parameters[i];
    if (std::isnan(parameter.std)) continue;
    text += (text.empty() ? "" : ", ") + summary.parameters[i].name + " " + Number(parameter.widening, 2);
  }
  return text;
}

// Where no interval could be widened: with the correlation c from frame to frame, m residuals say as much as
// m (1 - c)/(1 + c) independent ones.
void AddCorrelation(const FitSummary& summary, std::vector<std::string>* lines) {
  constexpr double kHighest = 0.99;
  const double correlation = std::min(summary.error.autocorrelation(), kHighest);
  if (!summary.uncertainty) return;
  if (summary.uncertainty->is_widened) {
    const bool in_time = correlation > kCorrelatedResiduals;
    lines->push_back((in_time ? "residuals are correlated from frame to frame (" + Number(correlation, 2) +
                                    "): the model misses something that lasts"
                              : std::string("residuals of one frame are correlated: an error of the whole frame")) +
                     "; the intervals count with that and are wider than those of independent residuals by " +
                     Widenings(summary));
    return;
  }
  if (summary.uncertainty->residual_scale < kRoundingResiduals || !(correlation > kCorrelatedResiduals)) return;
  lines->push_back("residuals are correlated from frame to frame (" + Number(correlation, 2) +
                   "): the model misses something that lasts, and the intervals are too narrow by a factor of about " +
                   Number(std::sqrt((1.0 + correlation) / (1.0 - correlation)), 2));
}

void AddFarPoints(const FitSummary& summary, std::vector<std::string>* lines) {
  constexpr double kManyFar = 0.2;  // above what a robust loss is for
  const CloudError& cloud = summary.error.cloud;
  if (!(cloud.num_far > kManyFar * cloud.num_points)) return;
  lines->push_back(Number(100.0 * cloud.num_far / cloud.num_points, 3) +
                   " % of the points of clouds are farther than " + Number(kFarFromSurface, 2) +
                   " sigma from the predicted surface: the model misses what they show, and the estimates with it");
}

void AddDistance(const FitSummary& summary, std::vector<std::string>* lines) {
  if (!summary.uncertainty) return;
  for (std::size_t i = 0; i < summary.parameters.size(); ++i) {
    const double distance = summary.uncertainty->parameters[i].distance;
    if (!(distance > kFarFromMinimum)) continue;
    lines->push_back(summary.parameters[i].name + " is " + Number(distance, 2) +
                     " standard deviations from the minimum of the quadratic model at the estimate: the fit stopped "
                     "early, or at a kink of the cost");
  }
}

void AddIntervalCheck(const FitSummary& summary, std::vector<std::string>* lines) {
  if (!summary.interval_check || summary.interval_check->is_quadratic()) return;
  const auto rise = [](double value) {
    return std::isnan(value) ? std::string("nothing that can be told") : Number(value, 2);
  };
  lines->push_back("the interval of " + summary.parameters[summary.interval_check->parameter].name +
                   " cannot be relied on: at its ends the cost rises by " + rise(summary.interval_check->rise_below) +
                   " and " + rise(summary.interval_check->rise_above) + " instead of 3.84; see --profile and --starts");
}

void AddStarts(const FitSummary& summary, const MultiStart& starts, std::vector<std::string>* lines) {
  const std::string total = std::to_string(starts.starts.size());
  const auto num_unconverged = std::count_if(starts.starts.begin(), starts.starts.end(),
                                             [](const StartResult& start) { return start.minimum < 0; });
  if (num_unconverged > 0)
    lines->push_back(std::to_string(num_unconverged) + " of " + total + " starts did not converge");
  if (starts.minima.empty()) return;
  const Minimum& first = starts.minima.front();
  lines->push_back(std::to_string(first.num_starts) + " of " + total + " starts ended in the same minimum, rmse " +
                   Millimetres(first.rmse) + (starts.minima.size() > 1 ? ": the preferred one" : ""));
  for (std::size_t m = 1; m < starts.minima.size(); ++m) {
    const Minimum& other = starts.minima[m];
    std::string line = std::to_string(other.num_starts) + " of " + total + " ended in another minimum, " +
                       Values(summary, other.values) + ", rmse " + Millimetres(other.rmse) + ": ";
    constexpr double kFarHigher = 1e4;
    const double ratio = other.cost / first.cost;
    if (!other.is_distinguishable()) {
      line += "the recording cannot tell it from the preferred one";
    } else {
      line += "not preferred, its cost is " + (ratio < kFarHigher ? Number(ratio, 3) + " times" : "far above") +
              " the lowest";
    }
    lines->push_back(line);
  }
}

void AddProfiles(const FitSummary& summary, const FitChecks& checks, std::vector<std::string>* lines) {
  for (const Profile& profile : checks.profiles) {
    const auto end = [](double value) { return std::isnan(value) ? std::string("open") : Number(value, 6); };
    lines->push_back("profile of " + profile.parameter + ": 95 % interval " + end(profile.lower95) + " .. " +
                     end(profile.upper95) + (profile.has_no_noise ? ": that of the optimiser, there is no noise" : ""));
    const auto lowest =
        std::min_element(profile.points.begin(), profile.points.end(),
                         [](const ProfilePoint& a, const ProfilePoint& b) { return a.cost_rise < b.cost_rise; });
    if (lowest->cost_rise < -kProfileRounding) {
      lines->push_back("profile of " + profile.parameter + ": a lower cost was found at " +
                       Values(summary, lowest->values) + ": fit again from there");
    }
  }
}

void AddStepCheck(const FitSummary& summary, const StepCheck& check, std::vector<std::string>* lines) {
  if (check.changes.size() == 0) {
    lines->push_back("step check: the rollout at half the time step failed");
    return;
  }
  std::string moves;
  for (std::size_t i = 0; i < summary.parameters.size(); ++i) {
    const FittedParameter& parameter = summary.parameters[i];
    if (parameter.frozen) continue;
    const double change = check.values[static_cast<Eigen::Index>(i)] - parameter.value;
    moves += (moves.empty() ? "" : ", ") + parameter.name + " moves by " + Number(change, 3);
    if (parameter.value != 0.0) moves += " (" + Number(100.0 * change / parameter.value, 3) + " %)";
    if (summary.uncertainty && !std::isnan(summary.uncertainty->parameters[i].std)) {
      moves += ", " + Number(std::abs(change) / summary.uncertainty->parameters[i].std, 3) + " standard deviations";
    }
  }
  std::string line = "at half the time step " + moves;
  if (check.status != FitStatus::kConverged) line += "; that fit ended as " + FitStatusName(check.status);
  lines->push_back(line);
}

// A node takes normal and friction of the nearest obstacle, so at equal distances of two both change at once.
void AddObstacleSwitches(const FitSummary& summary, std::vector<std::string>* lines) {
  const int num_switches = summary.counts.obstacle_switches;
  if (num_switches == 0) return;
  lines->push_back("at the estimate " + std::to_string(num_switches) +
                   (num_switches == 1 ? " contact jumps" : " contacts jump") +
                   " from one obstacle to another: the cost has small jumps there that no derivative shows, and a fit "
                   "may end at one; compare with --starts and look at the landscape");
}

void AddHoldout(const Holdout& holdout, std::vector<std::string>* lines) {
  if (!holdout.failure.empty()) lines->push_back("held out: " + holdout.failure);
  if (std::isnan(holdout.rmse) || std::isnan(holdout.nominal_rmse)) return;
  lines->push_back(std::string("held out: the estimates predict ") + (holdout.has_failed() ? "worse" : "better") +
                   " than the nominal parameters, rmse " + Millimetres(holdout.rmse) + " against " +
                   Millimetres(holdout.nominal_rmse));
}

}  // namespace

std::optional<bool> IsIdentifiable(const FitSummary& summary, const FitChecks& checks, int index) {
  if (summary.parameters[index].frozen || !summary.uncertainty) return std::nullopt;
  const bool is_ambiguous = checks.starts && !checks.starts->ambiguous.empty() && checks.starts->ambiguous[index];
  return summary.uncertainty->parameters[index].identifiable && !is_ambiguous;
}

ExitCode FitExitCode(const FitSummary& summary, const FitChecks& checks) {
  if (summary.status == FitStatus::kInterrupted) return kExitInterrupted;
  if (summary.status != FitStatus::kConverged) return kExitNotConverged;
  const bool is_at_bound = std::any_of(summary.parameters.begin(), summary.parameters.end(),
                                       [](const FittedParameter& parameter) { return parameter.at_bound; });
  if (is_at_bound || IsAnyUnidentifiable(summary, checks)) return kExitNotIdentifiable;
  if (checks.holdout && checks.holdout->has_failed()) return kExitHoldoutFailed;
  return kExitSuccess;
}

std::vector<std::string> Verdict(const FitSummary& summary, const FitChecks& checks) {
  std::vector<std::string> lines;
  if (summary.status != FitStatus::kConverged) {
    std::string status = FitStatusName(summary.status);
    std::replace(status.begin(), status.end(), '_', ' ');
    lines.push_back(status + ": " + summary.message);
  }
  AddIdentifiability(summary, &lines);
  AddCorrelation(summary, &lines);
  AddFarPoints(summary, &lines);
  AddIntervalCheck(summary, &lines);
  AddDistance(summary, &lines);
  if (checks.starts) AddStarts(summary, *checks.starts, &lines);
  AddProfiles(summary, checks, &lines);
  if (checks.step_check) AddStepCheck(summary, *checks.step_check, &lines);
  AddObstacleSwitches(summary, &lines);
  if (checks.holdout) AddHoldout(*checks.holdout, &lines);
  if (summary.status == FitStatus::kConverged && FitExitCode(summary, checks) == kExitSuccess) {
    lines.insert(lines.begin(), "every fitted parameter is identifiable");
  }
  return lines;
}

}  // namespace clothid
