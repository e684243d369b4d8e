#include "identify/estimate/fit_summary.h"

namespace clothid {

std::string FitStatusName(FitStatus status) {
  switch (status) {
    case FitStatus::kConverged:
      return "converged";
    case FitStatus::kNotConverged:
      return "not_converged";
    case FitStatus::kFailed:
      return "failed";
    case FitStatus::kInterrupted:
      return "interrupted";
  }
  return "unknown";
}

Eigen::VectorXd FitSummary::values() const {
  Eigen::VectorXd values(static_cast<Eigen::Index>(parameters.size()));
  for (Eigen::Index i = 0; i < values.size(); ++i) values[i] = parameters[i].value;
  return values;
}

Eigen::VectorXd FitSummary::lower_point() const {
  if (interval_check && interval_check->better.size() > 0) return interval_check->better;
  for (const BoundCheck& check : bound_checks) {
    if (check.better.size() > 0) return check.better;
  }
  return {};
}

void AddEarlierFit(const FitSummary& first, FitSummary* summary) {
  for (std::size_t i = 0; i < first.parameters.size() && summary->has_estimate(); ++i) {
    summary->parameters[i].start = first.parameters[i].start;
  }
  summary->start_error = first.start_error;
  summary->start_predicted = first.start_predicted;
  summary->statistics += first.statistics;
  summary->lead += first.lead;
  summary->plan.insert(summary->plan.begin(), first.plan.begin(), first.plan.end());
  summary->total_seconds += first.total_seconds;
  summary->solver_seconds += first.solver_seconds;
}

}  // namespace clothid
