#include "identify/checks/step_choice.h"

#include <algorithm>
#include <cmath>
#include <iomanip>
#include <map>
#include <sstream>

#include "identify/uncertainty/discretization_error.h"

namespace clothid {
namespace {

constexpr double kNotKnown = std::numeric_limits<double>::quiet_NaN();

class StepChooser {
 public:
  StepChooser(const std::vector<RecordedMotion>& motions, const FitOptions& options, const FitProblem& problem,
              FitSummary* summary)
      : motions_(motions), options_(options), problem_(problem), summary_(summary) {
    RepeatedFit& own = fits_[0];
    own.status = summary->status;
    own.coordinates = summary->coordinates.head(problem.num_blocks());
    own.values = summary->values();
    own.rmse = summary->error.rmse();
  }

  StepChoice Choose() {
    int level = 0;
    StepTrial trial = Look(level);
    if (trial.is_fine_enough()) {
      while (level < kMostStepLevels && Look(level + 1).is_fine_enough()) ++level;
      Take(level);
      return std::move(choice_);
    }
    while (!std::isnan(trial.error_over_noise)) {
      const double halvings = std::log2(trial.error_over_noise) / (std::isnan(trial.order) ? 1.0 : trial.order);
      choice_.needed = trial.time_step * std::exp2(-halvings);
      level -= static_cast<int>(std::ceil(std::min(halvings, 2.0 * kMostStepLevels)));
      if (level < -kMostStepLevels) break;
      trial = Look(level);
      if (!trial.is_fine_enough()) continue;
      Take(level);
      break;
    }
    return std::move(choice_);
  }

 private:
  // Of the standard deviations at h, what is left of them where the fits are better.
  double NoiseShare() const {
    double least = fits_.at(0).rmse;
    for (const auto& [level, fit] : fits_) {
      if (fit.has_estimate()) least = std::min(least, fit.rmse);
    }
    const double share = fits_.at(0).rmse > 0.0 ? least / fits_.at(0).rmse : 1.0;
    // Where sigma is known, residuals below it narrow no interval.
    return std::max(share, std::min(1.0, 1.0 / summary_->uncertainty->residual_scale));
  }

  StepTrial Look(int level) {
    StepTrial trial;
    trial.level = level;
    trial.time_step = motions_.front().scene.time_step * std::exp2(level);
    const bool has_fits = FitAt(level).has_estimate() && FitAt(level - 1).has_estimate();
    if (has_fits) FitAt(level + 1);
    const double noise_share = NoiseShare();
    for (int i = 0; has_fits && i < problem_.num_blocks(); ++i) {
      const ParameterUncertainty& parameter = summary_->uncertainty->parameters[static_cast<std::size_t>(i)];
      const double std = noise_share * (level > 0 ? parameter.independent_std : parameter.coordinate_std);
      if (!(std > 0.0)) continue;
      const DiscretizationError error = ErrorAt(level, i);
      if (error.error / std <= trial.error_over_noise) continue;  // a NaN there is replaced
      trial.error_over_noise = error.error / std;
      trial.order = error.order;
    }
    choice_.trials.push_back(trial);
    return trial;
  }

  DiscretizationError ErrorAt(int level, int i) {
    const RepeatedFit& coarse = FitAt(level + 1);
    const bool tells_order = coarse.status == FitStatus::kConverged && coarse.has_estimate();
    return ErrorOfStep(FitAt(level).coordinates[i], FitAt(level - 1).coordinates[i],
                       tells_order ? coarse.coordinates[i] : kNotKnown);
  }

  // At the step h 2^level, from the estimate at h; without an estimate where the run was cancelled.
  const RepeatedFit& FitAt(int level) {
    const auto [entry, is_new] = fits_.try_emplace(level);
    if (!is_new || options_.is_cancelled()) return entry->second;
    std::vector<RecordedMotion> motions = motions_;
    for (RecordedMotion& motion : motions) motion.scene.time_step *= std::exp2(level);
    const std::string tag = (level < 0 ? "step_over_" : "step_times_") + std::to_string(1 << std::abs(level));
    entry->second = RepeatFit(motions, options_, tag, problem_, summary_->coordinates);
    summary_->statistics += entry->second.statistics;
    return entry->second;
  }

  void Take(int level) {
    choice_.found = true;
    choice_.level = level;
    choice_.needed = kNotKnown;
    choice_.check.half_step = FitAt(level - 1);
    choice_.check.double_step = FitAt(level + 1);
    choice_.start = summary_->coordinates;
    choice_.start.head(problem_.num_blocks()) = FitAt(level).coordinates;
  }

  const std::vector<RecordedMotion>& motions_;
  const FitOptions& options_;
  const FitProblem& problem_;
  FitSummary* summary_;
  std::map<int, RepeatedFit> fits_;  // by level
  StepChoice choice_;
};

std::string Rounded(double value, int digits) {
  std::ostringstream text;
  text << std::setprecision(digits) << value;
  return text.str();
}

std::string TrialText(const StepTrial& trial) {
  return std::isnan(trial.error_over_noise) ? "not known" : Rounded(trial.error_over_noise, 2);
}

std::string Seconds(double seconds) { return Rounded(seconds, 4) + " s"; }

}  // namespace

std::string StepChoiceText(const StepChoice& choice) {
  if (choice.trials.empty()) return "not chosen: no standard deviation is known that its error could be held against";
  std::string tried;
  const StepTrial* taken = nullptr;
  for (const StepTrial& trial : choice.trials) {
    if (choice.found && trial.level == choice.level) {
      taken = &trial;
    } else {
      tried += (tried.empty() ? "" : ", ") + Seconds(trial.time_step) + ": " + TrialText(trial);
    }
  }
  if (taken != nullptr) {
    return Seconds(taken->time_step) + ": its error is at most " + TrialText(*taken) +
           " standard deviations of the noise" + (tried.empty() ? "" : " (" + tried + ")");
  }
  std::string text = "not chosen: errors in standard deviations of the noise are " + tried;
  if (!std::isnan(choice.needed)) text += "; it would take about " + Seconds(choice.needed);
  return text;
}

StepChoice ChooseTimeStep(const std::vector<RecordedMotion>& motions, const FitOptions& options,
                          const FitProblem& problem, FitSummary* summary) {
  if (!summary->has_estimate() || !summary->uncertainty) return {};
  bool has_std = false;
  for (const ParameterUncertainty& parameter : summary->uncertainty->parameters) {
    has_std = has_std || parameter.coordinate_std > 0.0;
  }
  return has_std ? StepChooser(motions, options, problem, summary).Choose() : StepChoice();
}

}  // namespace clothid
