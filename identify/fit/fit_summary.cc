#include "identify/fit/fit_summary.h"

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

}  // namespace clothid
