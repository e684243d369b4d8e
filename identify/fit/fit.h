// The fit: from a problem to estimates.
#ifndef CLOTHID_IDENTIFY_FIT_FIT_H_
#define CLOTHID_IDENTIFY_FIT_FIT_H_

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "costs/rollout_cost.h"
#include "datasets/observation/observation.h"
#include "identify/base/options.h"
#include "identify/fit/interval_check.h"
#include "identify/fit/problem.h"
#include "identify/uncertainty/uncertainty.h"

namespace clothid {

enum class FitStatus {
  kConverged,
  kNotConverged,  // stopped at max_iterations, or where the points ahead fail
  kFailed,        // a rollout or derivative failed where the fit could not go on
  kInterrupted,   // FitOptions::cancel
};
std::string FitStatusName(FitStatus status);

struct FittedParameter {
  std::string name;
  double value = 0.0;
  double start = 0.0;
  bool frozen = false;
  bool at_bound = false;
};

// Valid where has_estimate(), whatever the status: the best point that was evaluated, with full precision unless the
// fit was interrupted before it came to that.
struct FitSummary {
  FitStatus status = FitStatus::kFailed;
  std::string message = "the fit was not run";  // one line: why it ended
  std::vector<FittedParameter> parameters;
  Eigen::VectorXd coordinates;             // [p] the internal coordinates of the estimate
  std::optional<Uncertainty> uncertainty;  // at the estimate; absent: not asked for, or the derivative failed there
  std::optional<IntervalCheck> interval_check;  // of that uncertainty
  double cost = 0.0;
  PredictionError start_error;  // over all recordings, at the starting values, as they were evaluated
  PredictionError error;        // the same at the estimate
  std::vector<Eigen::MatrixXd>
      start_predicted;                     // per recording, at the start as it was evaluated [R x T] m, see Observation
  std::vector<Eigen::MatrixXd> predicted;  // the same at the estimate
  RolloutCounts counts;                    // of the rollouts at the estimate, summed over the recordings
  std::vector<FitIteration> iterations;    // of increasing number; the first is the start, the last the estimate
  CostStatistics statistics;
  double total_seconds = 0.0;
  double solver_seconds = 0.0;  // outside of rollouts and derivatives

  bool has_estimate() const { return !parameters.empty(); }
  int num_iterations() const { return iterations.empty() ? 0 : iterations.back().iteration; }
  Eigen::VectorXd values() const;  // [p] of the parameters
};

// From the starting values of the problem's blocks. Never throws for what happens during the fit: see the status; but
// throws `Error` where FitOptions::journal_folder is set and a journal cannot be written or is of another fit. The
// estimate is the point of lowest cost of all that were evaluated. On the same problem it gives the same result on any
// number of threads.
//
// kLevenbergMarquardt: Ceres' trust region with the bounds of the blocks. With FitPrecision::kAdaptive it runs twice:
// with loose rollouts (`Precision`) until the Gauss-Newton step changes no parameter by more than 5 %, and from where
// that step leads with full ones, to the end. Forward differences need full precision throughout. kLbfgs:
// `ceres::GradientProblem` has no bounds, so it works on u with  q = lower + (upper - lower) sigmoid(4 u/(upper -
// lower) + c),  dq/du = 1 in the middle, c such that u = 0 is the start; q the internal coordinate.
FitSummary Fit(const FitOptions& options, FitProblem* problem);

// Fills `uncertainty` and `interval_check` of a fit that has an estimate, unless the derivative fails there or
// options.cancel is true, and adds the work to its counts.
void AddUncertainty(const FitOptions& options, const FitProblem& problem, FitSummary* summary);

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_FIT_FIT_H_
