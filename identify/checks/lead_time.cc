#include "identify/checks/lead_time.h"

#include <cmath>

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

}  // namespace

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
      const Eigen::ArrayXd seen = motion.positions.col(frame).array();
      const Eigen::ArrayXd errors = seen - predicted.col(frame).array();
      const Eigen::ArrayXd moved = seen - motion.positions.col(launch).array();
      const Eigen::Array<bool, Eigen::Dynamic, 1> counts = !errors.isNaN() && !moved.isNaN();
      if (!counts.any()) continue;
      sums_[i].squared += counts.select(errors.square(), 0.0).sum();
      sums_[i].still += counts.select(moved.square(), 0.0).sum();
      sums_[i].num += static_cast<double>(counts.count());
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
