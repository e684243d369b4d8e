// What a fit means, in words and as an exit code.
#ifndef CLOTHID_IDENTIFY_VERDICT_VERDICT_H_
#define CLOTHID_IDENTIFY_VERDICT_VERDICT_H_

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "identify/base/options.h"
#include "identify/checks/gradient_check.h"
#include "identify/checks/holdout.h"
#include "identify/checks/multi_start.h"
#include "identify/checks/profile.h"
#include "identify/checks/step_check.h"
#include "identify/fit/fit.h"
#include "identify/landscape/fit_landscape.h"
#include "sim/base/error.h"

namespace clothid {

// What a run looked at beside the fit itself, and how it was called. Absent: not asked for.
struct FitChecks {
  JacobianMethod jacobian = JacobianMethod::kAdjoint;
  std::optional<GradientCheck> gradient_check;
  std::optional<MultiStart> starts;
  std::vector<Profile> profiles;
  std::vector<FitLandscape> landscapes;  // which `MatchLandscape` has seen
  std::optional<StepCheck> step_check;
  std::optional<Holdout> holdout;
  std::vector<Eigen::MatrixXd> predicted_nodes;  // see identify/report/node_prediction.h
  std::string flags;                             // the command line
  std::uint64_t seed = 0;
  int num_threads = 1;
};

// Whether the recordings determine parameter `index`: its derivative says so, and no other start ended at another value
// that fits as well. Absent: frozen, or the derivative at the estimate could not be evaluated.
std::optional<bool> IsIdentifiable(const FitSummary& summary, const FitChecks& checks, int index);

// Where several apply: 130, 3, 4, 5 in that order.
ExitCode FitExitCode(const FitSummary& summary, const FitChecks& checks);

// One line each: how the fit ended, what is not identifiable and why, what stands at its bound, where the other starts
// ended and why the first minimum is preferred, what the time step and the held-out measurements say, where the cost
// jumps.
std::vector<std::string> Verdict(const FitSummary& summary, const FitChecks& checks);

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_VERDICT_VERDICT_H_
