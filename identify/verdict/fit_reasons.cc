// Reasons that lie in the fit as a whole.
#include <algorithm>
#include <cmath>

#include "identify/verdict/reason.h"

namespace clothid {
namespace {

// Errors below this many times the noise, or without a known noise below this share of the cloth, are small whatever
// they are compared with.
constexpr double kNoiseFactor = 1.5;
constexpr double kSmallShare = 0.01;
// A recorded motion below this share of the cloth is that of a cloth at rest, which any error exceeds.
constexpr double kRestShare = 0.02;
// Errors are compared with the recorded motion, which noise makes larger by a little: 1 - |error|/|motion| in %.
constexpr double kClearlyNegative = -10.0;
constexpr double kLowFit = 20.0;
// Errors against the cloth's size: by the first share points are predicted at another place of the cloth, and what such
// a prediction hides in the parameters can be anything.
constexpr double kHugeShare = 0.25;
constexpr double kLargeShare = 0.1;
// A point whose cost is lower by more than this, in s^2, is where the fit should have ended.
constexpr double kLowerCost = 0.1;

void AddEnd(const FitSummary& summary, std::vector<Reason>* reasons) {
  if (summary.status == FitStatus::kConverged) return;
  std::string brief = FitStatusName(summary.status);
  std::replace(brief.begin(), brief.end(), '_', ' ');
  if (summary.message != brief) brief += ": " + summary.message;
  const ExitCode exit_code = summary.status == FitStatus::kInterrupted ? kExitInterrupted : kExitNotConverged;
  reasons->push_back({Usability::kDoNotUse, exit_code, {}, brief, ""});
}

bool IsSmall(const RecordingFit& recording) {
  return std::isnan(recording.noise) ? recording.judged().rmse() <= kSmallShare * recording.cloth_size
                                     : recording.judged().rmse() <= kNoiseFactor * recording.noise;
}

// "a.bin: " where there are several.
std::string Prefix(const FitChecks& checks, const RecordingFit& recording) {
  return checks.recordings.size() > 1 ? recording.name + ": " : std::string();
}

// What the fit's loss discounts is neither held against it nor hidden.
void AddDiscounted(const RecordingFit& recording, const std::string& prefix, std::vector<Reason>* reasons) {
  if (!recording.discounted) return;
  const Discounted& discounted = *recording.discounted;
  const std::string brief =
      prefix + "the loss discounts " + NumberText(100.0 * discounted.share, 3) + " % of the points";
  const std::string fifth = discounted.is_many() ? "the worst fifth" : "them";
  const std::string line = brief + ": rmse " + MillimetreText(discounted.error.rmse()) + " without " + fifth +
                           ", by which the fit is judged, " + MillimetreText(recording.error.rmse()) + " with " + fifth;
  reasons->push_back(discounted.is_many() ? Careful({}, brief, line + "; so many are no gross errors") : Remark(line));
}

void AddFitPercent(const RecordingFit& recording, const std::string& prefix, std::vector<Reason>* reasons) {
  const double fit = recording.judged().fit_percent();
  if (!(fit < kLowFit) || IsSmall(recording)) return;
  const std::string brief =
      prefix + (fit >= 0.0 ? "the fit is low" : "the fit is negative") + " (" + NumberText(fit) + " %)";
  if (fit >= 0.0) {
    reasons->push_back(
        Careful({}, brief, brief + ": the prediction is hardly nearer to the recording than a cloth at rest"));
    return;
  }
  const bool moves = recording.motion() > kRestShare * recording.cloth_size;
  reasons->push_back(
      AgainstAll(fit < kClearlyNegative && moves, brief,
                 brief + ": every point at rest at its mean place would be nearer to the recording, rmse " +
                     MillimetreText(recording.motion()) + " against " + MillimetreText(recording.judged().rmse()) +
                     (moves ? "; look at unit, frame of reference and axes" : "; the cloth hardly moves")));
}

void AddSize(const RecordingFit& recording, const std::string& prefix, std::vector<Reason>* reasons) {
  const double share = recording.judged().rmse() / recording.cloth_size;
  if (!(share > kLargeShare)) return;
  const bool is_huge = share > kHugeShare;
  const std::string brief = prefix + (is_huge ? "the error is of the size of the cloth" : "the error is large");
  reasons->push_back(AgainstAll(is_huge, brief,
                                brief + ": rmse " + MillimetreText(recording.judged().rmse()) + ", " +
                                    NumberText(100.0 * share, 3) + " % of the " + MillimetreText(recording.cloth_size) +
                                    " of the cloth"));
}

// Errors that noise does not explain: intervals, which scale with them, know what chance would do, and neither what the
// model misses nor that of another minimum.
void AddUnexplained(const RecordingFit& recording, const std::string& prefix, std::vector<Reason>* reasons) {
  const double factor = recording.judged().rmse() / recording.noise;
  if (!(factor > kExplainedScale) || !recording.model_error.is_zero()) return;
  const std::string brief = prefix + "the error is " + NumberText(factor, 2) + " times the noise";
  reasons->push_back(Careful({}, brief,
                             brief + ": rmse " + MillimetreText(recording.judged().rmse()) + " against " +
                                 MillimetreText(recording.noise) +
                                 "; model, start or handles miss something, or this is not the best minimum, and "
                                 "intervals know of neither"));
}

void AddStart(const RecordingFit& recording, const std::string& prefix, std::vector<Reason>* reasons) {
  if (!recording.start || !recording.start->is_noticeable()) return;
  const StartDifference& start = *recording.start;
  const std::string brief = prefix + "the scene's start is not where the first frame shows the cloth";
  reasons->push_back(AgainstAll(
      start.is_large(), brief,
      brief + ": " + MillimetreText(start.rms) + " off (root mean square), " +
          NumberText(100.0 * start.rms / start.cloth_size, 3) +
          " % of the cloth's size; correct initial.positions, or leave it out: the start is then estimated"));
}

void AddNoisyStart(const RecordingFit& recording, const std::string& prefix, std::vector<Reason>* reasons) {
  if (!recording.starts_at_noise) return;
  const std::string brief = prefix + "noisy frames were taken for the start";
  reasons->push_back(Careful({}, brief, brief + ": intervals do not count with that; --initial estimated does"));
}

// How much of the doubt comes from the start: nothing against the fit.
void AddEstimatedStart(const FitSummary& summary, std::vector<Reason>* reasons) {
  if (summary.starts.empty() || !summary.uncertainty) return;
  std::string factors;
  for (std::size_t i = 0; i < summary.parameters.size(); ++i) {
    const ParameterUncertainty& parameter = summary.uncertainty->parameters[i];
    if (std::isnan(parameter.std) || std::isnan(parameter.known_start_std) || summary.parameters[i].is_knot) continue;
    factors += (factors.empty() ? "" : ", ") + summary.parameters[i].name + " " +
               NumberText(parameter.std / parameter.known_start_std, 2);
  }
  reasons->push_back(Remark("the start was estimated with the parameters" +
                            (factors.empty() ? "" : "; standard deviations are larger for it by " + factors)));
}

// "mu 2.1, k_stretch 3, knots of the wind up to 4": by how much intervals are wider than those of independent
// residuals.
std::string Widenings(const FitSummary& summary) {
  std::string text;
  double of_knots = 0.0;
  for (std::size_t i = 0; i < summary.parameters.size(); ++i) {
    const ParameterUncertainty& parameter = summary.uncertainty->parameters[i];
    if (std::isnan(parameter.std)) continue;
    if (summary.parameters[i].is_knot) {
      of_knots = std::max(of_knots, parameter.widening);
      continue;
    }
    text += (text.empty() ? "" : ", ") + summary.parameters[i].name + " " + NumberText(parameter.widening, 2);
  }
  if (of_knots > 0.0)
    text += (text.empty() ? "" : ", ") + std::string("knots of the wind up to ") + NumberText(of_knots, 2);
  return text;
}

// Intervals that count with correlated residuals are honest about chance; what lasts in the residuals is a bias of the
// model that they do not know of.
void AddWidening(const FitSummary& summary, std::vector<Reason>* reasons) {
  constexpr double kMuchWider = 2.0;
  const double correlation = summary.error.autocorrelation();
  const bool in_time = correlation > kCorrelatedResiduals;
  const bool is_grave = in_time || summary.uncertainty->largest_widening() > kMuchWider;
  const std::string widenings = Widenings(summary);
  const std::string brief =
      in_time ? "residuals are correlated from frame to frame" : "residuals of one frame are correlated";
  const std::string meaning = in_time ? " (" + NumberText(correlation, 2) + "): the model misses something that lasts"
                                      : ": an error of the whole frame";
  const std::string consequence =
      "; the intervals count with that and are wider than those of independent residuals by " + widenings;
  const std::string line = brief + meaning + (widenings.empty() ? "" : consequence);
  reasons->push_back(is_grave ? Careful({}, brief, line) : Remark(line));
}

bool HasModelError(const FitChecks& checks) {
  return std::any_of(checks.recordings.begin(), checks.recordings.end(),
                     [](const RecordingFit& recording) { return !recording.model_error.is_zero(); });
}

// Where no interval could be widened: with the correlation c from frame to frame, m residuals say as much as
// m (1 - c)/(1 + c) independent ones.
void AddCorrelation(const FitSummary& summary, const FitChecks& checks, std::vector<Reason>* reasons) {
  constexpr double kHighest = 0.99;
  if (!summary.uncertainty || HasModelError(checks)) return;
  if (summary.uncertainty->is_widened) return AddWidening(summary, reasons);
  const double correlation = std::min(summary.error.autocorrelation(), kHighest);
  if (summary.uncertainty->residual_scale < kRoundingResiduals || !(correlation > kCorrelatedResiduals)) return;
  const std::string brief = "residuals are correlated from frame to frame";
  reasons->push_back(
      Careful({}, brief,
              brief + " (" + NumberText(correlation, 2) +
                  "): the model misses something that lasts, and the intervals are too narrow by a factor of about " +
                  NumberText(std::sqrt((1.0 + correlation) / (1.0 - correlation)), 2)));
}

void AddFarPoints(const FitSummary& summary, std::vector<Reason>* reasons) {
  constexpr double kManyFar = 0.2;  // above what a robust loss is for
  const CloudError& cloud = summary.error.cloud;
  if (!(cloud.num_far > kManyFar * cloud.num_points)) return;
  reasons->push_back(
      Careful({}, "many points of clouds are far from the surface",
              NumberText(100.0 * cloud.num_far / cloud.num_points, 3) + " % of the points of clouds are farther than " +
                  NumberText(kFarFromSurface, 2) +
                  " sigma from the predicted surface: the model misses what they show, and the estimates with it"));
}

void AddLowerPoint(const FitSummary& summary, std::vector<Reason>* reasons) {
  const int num = summary.num_continuations;
  const std::string times = std::to_string(num) + (num == 1 ? " time" : " times");
  if (summary.interval_check && summary.interval_check->better.size() > 0) {
    const IntervalCheck& check = *summary.interval_check;
    const std::string brief = "a point of lower cost was met";
    const std::string where =
        check.rise_beyond == check.lowest_rise() ? "a step on from an end of it" : "at an end of it";
    reasons->push_back(AgainstAll(-0.5 * check.lowest_rise() > kLowerCost, brief,
                                  brief + " where the interval of " + summary.parameters[check.parameter].name +
                                      " was checked: " + where + " the cost \"rises\" by " +
                                      NumberText(check.lowest_rise(), 2) + " instead of 3.84" +
                                      (num > 0 ? ", after the fit had gone on from such a point " + times : "") +
                                      "; the cost is rough: see --starts and the landscape"));
  } else if (summary.lower_point().size() > 0) {
    const std::string brief = "a point of lower cost was met";
    reasons->push_back(AgainstAll(true, brief,
                                  brief + " where what the derivative does not tell was tried at its bounds" +
                                      (num > 0 ? ", after the fit had gone on from such a point " + times : "") +
                                      "; see --starts"));
  } else if (num > 0) {
    const std::string brief = "the cost has more than one minimum";
    reasons->push_back(Careful(
        {}, brief,
        "the fit went on " + times +
            " from a point of lower cost, met where an interval or a bound was checked: " + brief + "; see --starts"));
  }
}

// A node takes normal and friction of the nearest obstacle, so at equal distances of two both change at once.
void AddObstacleSwitches(const FitSummary& summary, std::vector<Reason>* reasons) {
  const int num_switches = summary.counts.obstacle_switches;
  if (num_switches == 0) return;
  reasons->push_back(Remark(
      "at the estimate " + std::to_string(num_switches) + (num_switches == 1 ? " contact jumps" : " contacts jump") +
      " from one obstacle to another: the cost has small jumps there that no derivative shows, and a fit may end at "
      "one; compare with --starts and look at the landscape"));
}

}  // namespace

void AddFitReasons(const FitSummary& summary, const FitChecks& checks, std::vector<Reason>* reasons) {
  AddEnd(summary, reasons);
  for (const RecordingFit& recording : checks.recordings) {
    const std::string prefix = Prefix(checks, recording);
    AddDiscounted(recording, prefix, reasons);
    AddFitPercent(recording, prefix, reasons);
    AddSize(recording, prefix, reasons);
    AddUnexplained(recording, prefix, reasons);
    AddStart(recording, prefix, reasons);
    AddNoisyStart(recording, prefix, reasons);
  }
  AddLowerPoint(summary, reasons);
  AddEstimatedStart(summary, reasons);
  AddCorrelation(summary, checks, reasons);
  AddFarPoints(summary, reasons);
  AddObstacleSwitches(summary, reasons);
}

}  // namespace clothid
