#include "identify/checks/lead_time.h"

#include <cmath>
#include <tuple>
#include <utility>

#include "costs/prediction/rollout_cost_options.h"

namespace clothid {
namespace {

constexpr int kNumLaunches = 4;
constexpr double kSameTime = 0.1;  // of a lead: frames count for it that are so near

// The frame of `times` that is nearest to `time`.
Eigen::Index NearestFrame(const Eigen::VectorXd& times, double time) {
  Eigen::Index nearest = 0;
  (times.array() - time).abs().minCoeff(&nearest);
  return nearest;
}

// What the seen material points of a frame differ from `expected` [>= 3P] by: its squares and their number. NaN counts
// nothing.
std::pair<double, double> SquaredDifference(const RecordedMotion& motion, Eigen::Index frame,
                                            const Eigen::VectorXd& expected) {
  double sum = 0.0, num = 0.0;
  for (int row = 0; row < 3 * motion.num_points(); ++row) {
    if (motion.points[static_cast<std::size_t>(row / 3)].kind != PointKind::kMaterial) continue;
    const double difference = motion.positions(row, frame) - expected[row];
    if (std::isnan(difference)) continue;
    sum += difference * difference;
    num += 1.0;
  }
  return {sum, num};
}

// Of the points of a frame that are compared with the surface to that of `nodes` [3N], squared and summed.
double SquaredDistance(const CloudObservation& clouds, Eigen::Index frame, const Eigen::VectorXd& nodes) {
  const int own_frame = static_cast<int>(frame);
  const CloudRows rows = clouds.Linearize(own_frame, nodes);
  double sum = 0.0;
  for (int row = 0; row < clouds.num_rows(own_frame); ++row) {
    if (clouds.is_border_row(own_frame, row)) continue;
    sum += std::pow(rows[static_cast<std::size_t>(row)].distance * clouds.point(own_frame, row).sigma, 2);
  }
  return sum;
}

}  // namespace

LeadTimes::Sum LeadTimes::Compare(const RecordedMotion& motion, const Observation& observation,
                                  const Eigen::MatrixXd& predicted, Eigen::Index launch, Eigen::Index frame) {
  const Eigen::VectorXd seen = motion.positions.col(launch);
  // A point counts where it was seen in both frames.
  const Eigen::VectorXd both = seen.array().isNaN().select(seen, predicted.col(frame).head(seen.size()));
  Sum sum;
  std::tie(sum.squared, sum.num) = SquaredDifference(motion, frame, both);
  sum.still = SquaredDifference(motion, frame, seen).first;
  const CloudObservation& clouds = observation.clouds();
  if (!observation.has_clouds()) return sum;
  sum.squared += SquaredDistance(clouds, frame, observation.Nodes(predicted).col(frame));
  sum.still += SquaredDistance(clouds, frame, observation.Nodes(predicted).col(launch));
  sum.num += static_cast<double>(clouds.points(static_cast<int>(frame)).size());
  return sum;
}

void LeadTimes::Add(const RecordedMotion& motion, const Eigen::VectorXd& coordinates, RecordingModel* model) {
  if (!assimilation_.is_on() || !model->WhyNotAssimilated().empty()) return;
  const Eigen::VectorXd& times = model->times();
  const double first = times[0], duration = times[times.size() - 1] - first;
  for (int k = 1; k <= kNumLaunches; ++k) {
    const Eigen::Index launch = NearestFrame(times, first + k * duration / (kNumLaunches + 1));
    Assimilation until = assimilation_;
    until.until = times[launch];
    model->Assimilate(until, loss_);
    Eigen::MatrixXd predicted;
    if (!model->Simulate(coordinates, {}, {}, &predicted).ok()) continue;
    for (std::size_t i = 0; i < kLeads.size(); ++i) {
      const Eigen::Index frame = NearestFrame(times, times[launch] + kLeads[i]);
      if (std::abs(times[frame] - times[launch] - kLeads[i]) > kSameTime * kLeads[i]) continue;
      const Sum own = Compare(motion, model->observation(), predicted, launch, frame);
      if (own.num == 0.0) continue;
      sums_[i].squared += own.squared;
      sums_[i].still += own.still;
      sums_[i].num += own.num;
      ++sums_[i].num_predictions;
    }
  }
  model->Assimilate({}, loss_);
}

std::vector<LeadTimeError> LeadTimes::Errors() const {
  std::vector<LeadTimeError> errors;
  for (std::size_t i = 0; i < kLeads.size(); ++i) {
    const Sum& sum = sums_[i];
    if (sum.num_predictions == 0) continue;
    errors.push_back(
        {kLeads[i], std::sqrt(sum.squared / sum.num), std::sqrt(sum.still / sum.num), sum.num_predictions});
  }
  return errors;
}

Assimilation LastAssimilation(const FitSummary& summary) {
  if (summary.assimilation.is_on() || summary.memory_trials.empty()) return summary.assimilation;
  return Assimilation{summary.memory_trials.back().memory};
}

std::vector<LeadTimeError> PredictAhead(const std::vector<RecordedMotion>& motions, const FitProblem& problem,
                                        const FitSummary& summary, const RobustLoss& loss) {
  LeadTimes ahead(LastAssimilation(summary), loss);
  if (!LastAssimilation(summary).is_on()) return {};
  for (int r = 0; r < problem.num_recordings(); ++r) {
    const RecordedMotion& motion = motions[static_cast<std::size_t>(r)];
    const RecordingModel& fitted = problem.cost(r).model();
    RecordingModel model(motion, fitted.blocks(), {}, fitted.shared_start(), problem.fields());
    ahead.Add(motion, problem.CoordinatesOf(r, summary.coordinates), &model);
  }
  return ahead.Errors();
}

}  // namespace clothid
