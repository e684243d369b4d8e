#include "identify/report/fit_quality.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "identify/base/join_words.h"

namespace clothid {
namespace {

// Every difference of a coordinate.
template <typename Visitor>
void ForEachResidual(const Observation& observation, const RecordedMotion& motion, const Eigen::MatrixXd& predicted,
                     const Visitor& visit) {
  for (const SeenCoordinate& seen : observation.coordinates()) {
    const Eigen::Index row = 3 * static_cast<Eigen::Index>(seen.point) + seen.axis;
    visit(seen, predicted(row, seen.frame) - motion.positions(row, seen.frame));
  }
}

// Below this share of sigma a residual is that of the solver: a recording without noise.
constexpr double kWithoutNoise = 1e-3;
// Residuals up to this many sigma are explained by it.
constexpr double kExplained = 1.2;
// Of the mean square, from which on something that lasts is worth a word.
constexpr double kLasting = 0.1;

// Whose word the noise is.
std::string NoiseName(const std::vector<RecordedMotion>& motions) {
  const auto is_all = [&](SigmaSource source) {
    return std::all_of(motions.begin(), motions.end(),
                       [&](const RecordedMotion& motion) { return motion.sigma_source == source; });
  };
  if (is_all(SigmaSource::kEstimated)) return "noise that was estimated from the scatter of the points";
  if (is_all(SigmaSource::kGiven)) return "noise that --sigma states";
  if (is_all(SigmaSource::kRecorded)) return "noise that the recording states";
  return "noise that is assumed";
}

void AddNoise(const FitSummary& summary, const std::vector<RecordedMotion>& motions,
              const std::vector<Observation>& observations, std::vector<std::string>* lines) {
  if (!summary.uncertainty) return;
  const double scale = summary.uncertainty->residual_scale;
  const bool is_known = std::all_of(observations.begin(), observations.end(),
                                    [](const Observation& observation) { return observation.sigma_is_known(); });
  if (scale < kWithoutNoise) {
    lines->push_back("There is next to no noise: what is left of the error is that of the solver.");
  } else if (std::any_of(summary.model_errors.begin(), summary.model_errors.end(),
                         [](const ModelError& error) { return !error.is_zero(); })) {
    lines->push_back("The " + NoiseName(motions) +
                     " does not explain the error: the model misses the rest, and frames count for less by that.");
  } else if (!is_known) {
    lines->push_back(
        "The recording does not state its noise, so the intervals take all of the remaining error for noise: how "
        "large the error should be at best is not known.");
  } else if (scale <= kExplained) {
    lines->push_back("The " + NoiseName(motions) + " explains the error: residuals are " + NumberText(scale, 3) +
                     " times its standard deviation. A better fit would be a fit of the noise.");
  } else {
    lines->push_back("Residuals are " + NumberText(scale, 3) + " times the " + NoiseName(motions) +
                     ": the model misses something, or there is more noise than that.");
  }
}

// With the autocorrelation c of errors from frame to frame, c of their mean square lasts and 1 - c changes like noise.
void AddLasting(const FitSummary& summary, std::vector<std::string>* lines) {
  const double correlation = std::min(summary.error.autocorrelation(), 1.0), rmse = summary.error.rmse();
  if (!summary.uncertainty || summary.uncertainty->residual_scale < kWithoutNoise || std::isnan(correlation)) return;
  if (correlation <= kLasting) {
    lines->push_back("The error changes from frame to frame like the noise of a sensor (correlation " +
                     NumberText(correlation, 2) + ").");
    return;
  }
  lines->push_back("Of " + MillimetreText(rmse, 3) + " rmse about " + MillimetreText(rmse * std::sqrt(correlation), 3) +
                   " last from frame to frame, which is an error of the model, and " +
                   MillimetreText(rmse * std::sqrt(1.0 - correlation), 3) +
                   " change like noise. The model cannot come below the former with these parameters.");
}

void AddUnseen(const std::vector<RecordedMotion>& motions, std::vector<std::string>* lines) {
  constexpr double kWorthAWord = 1e-3;
  double num_unseen = 0.0, num_all = 0.0;
  for (const RecordedMotion& motion : motions) {
    num_unseen += static_cast<double>(motion.positions.array().isNaN().count());
    num_all += static_cast<double>(motion.positions.size());
  }
  if (num_unseen <= kWorthAWord * num_all) return;
  lines->push_back(NumberText(100.0 * num_unseen / num_all, 2) + " % of the coordinates were not seen.");
}

}  // namespace

Eigen::MatrixXd PointErrors(const Observation& observation, const RecordedMotion& motion,
                            const Eigen::MatrixXd& predicted) {
  Eigen::MatrixXd squares = Eigen::MatrixXd::Zero(observation.num_points(), observation.num_frames());
  Eigen::MatrixXd counts = squares;
  ForEachResidual(observation, motion, predicted, [&](const SeenCoordinate& seen, double difference) {
    squares(seen.point, seen.frame) += difference * difference;
    counts(seen.point, seen.frame) += 1.0;
  });
  return (squares.array() * 3.0 / counts.array()).sqrt();  // 0/0 is NaN
}

double RootMeanSquare(const Eigen::VectorXd& errors) {
  double sum = 0.0, count = 0.0;
  for (const double error : errors) {
    if (std::isnan(error)) continue;
    sum += error * error;
    count += 1.0;
  }
  return std::sqrt(sum / count);  // 0/0 is NaN
}

Eigen::VectorXd FrameErrors(const Eigen::MatrixXd& point_errors) {
  Eigen::VectorXd errors(point_errors.cols());
  for (Eigen::Index frame = 0; frame < errors.size(); ++frame) errors[frame] = RootMeanSquare(point_errors.col(frame));
  return errors;
}

bool StartsAtFirstFrame(const RecordedMotion& motion) {
  return motion.start_source != StartSource::kScene && !IsUnknown(motion.start_source);
}

std::vector<ResidualHistogram> ResidualHistograms(const Observation& observation, const RecordedMotion& motion,
                                                  const Eigen::MatrixXd& predicted, double range, int num_bins) {
  std::vector<ResidualHistogram> histograms(3);
  std::array<double, 3> sums = {0.0, 0.0, 0.0}, squares = {0.0, 0.0, 0.0}, seen_counts = {0.0, 0.0, 0.0};
  const bool leaves_out_start = StartsAtFirstFrame(motion);
  for (ResidualHistogram& histogram : histograms) histogram.counts.assign(static_cast<std::size_t>(num_bins), 0);
  ForEachResidual(observation, motion, predicted, [&](const SeenCoordinate& seen, double difference) {
    if (leaves_out_start && seen.frame == 0) return;
    const std::size_t axis = static_cast<std::size_t>(seen.axis);
    sums[axis] += difference;
    squares[axis] += difference * difference;
    seen_counts[axis] += 1.0;
    const double bin = std::floor((difference + range) / (2.0 * range) * num_bins);
    if (bin >= 0.0 && bin < num_bins) {
      ++histograms[axis].counts[static_cast<std::size_t>(bin)];
    } else {
      ++histograms[axis].num_beyond;
    }
  });
  for (std::size_t axis = 0; axis < 3; ++axis) {
    histograms[axis].mean = sums[axis] / seen_counts[axis];
    const double variance = squares[axis] / seen_counts[axis] - histograms[axis].mean * histograms[axis].mean;
    histograms[axis].deviation = std::sqrt(std::max(variance, 0.0));
  }
  return histograms;
}

std::vector<std::string> FitLimits(const FitSummary& summary, const std::vector<RecordedMotion>& motions,
                                   const std::vector<Observation>& observations) {
  std::vector<std::string> lines;
  AddNoise(summary, motions, observations, &lines);
  AddLasting(summary, &lines);
  AddUnseen(motions, &lines);
  const int num_substeps = summary.counts.substeps;
  if (num_substeps > 0) {
    lines.push_back("At the estimate " + std::to_string(num_substeps) +
                    (num_substeps == 1 ? " substep was" : " substeps were") +
                    " taken, where a step did not converge as a whole: each makes the cost jump a little.");
  }
  return lines;
}

}  // namespace clothid
