// A fit once more, with another time step or mesh, from where the first one ended.
#ifndef CLOTHID_IDENTIFY_CHECKS_REPEATED_FIT_H_
#define CLOTHID_IDENTIFY_CHECKS_REPEATED_FIT_H_

#include <Eigen/Core>
#include <string>
#include <vector>

#include "datasets/motion/recorded_motion.h"
#include "identify/base/options.h"
#include "identify/fit/fit.h"
#include "identify/problem/problem.h"

namespace clothid {

struct RepeatedFit {
  FitStatus status = FitStatus::kFailed;
  Eigen::VectorXd coordinates;  // [p] its estimates in their internal coordinates; empty: it has none
  Eigen::VectorXd values;       // [p] in the parameters' own units; empty likewise
  Eigen::VectorXd changes;      // [p] against the estimates of the first fit: of mu, or relative for the others
  double rmse = 0.0;            // m
  CostStatistics statistics;

  bool has_estimate() const { return values.size() > 0; }
};

// What leads from coordinates [p] to others, as RepeatedFit::changes.
Eigen::VectorXd ChangesBetween(const FitProblem& problem, const Eigen::VectorXd& from, const Eigen::VectorXd& to);

// Fits `motions`, those of `problem` made anew, from `coordinates`, the estimate of that problem [p + n + f], with its
// weights of smoothness. `from_bases`: unknown starts begin at their bases, for on another mesh they mean something
// else. Without intervals, with looser tolerances than the first fit: the estimate ends some hundredths of a standard
// deviation from the minimum. `tag` names its journals. Throws `Error` where `FitProblem` does.
RepeatedFit RepeatFit(const std::vector<RecordedMotion>& motions, const FitOptions& options, const std::string& tag,
                      const FitProblem& problem, const Eigen::VectorXd& coordinates, bool from_bases = false);

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_CHECKS_REPEATED_FIT_H_
