// The coarsest time step whose error hides in the noise: `identify --time_step auto`.
//
// The fit is run again, from its estimate, with time steps of the recordings that are h times powers of two, h theirs.
// The error of an estimate at a step and its order p follow from three of them (see
// identify/uncertainty/discretization_error.h), and a step is fine enough where no error is larger than the standard
// deviation of its estimate: the share of the noise is then the larger one. What a coarse step misses of the recording
// looks like noise, so standard deviations are those that the least residuals of all these fits leave. From h the
// choice goes to coarser steps while they are fine enough, by the standard deviations of independent residuals: a model
// that errs widens intervals, but is no reason to err more. Where h itself is not, it goes to the step that the order
// promises, and on from there.
#ifndef CLOTHID_IDENTIFY_CHECKS_STEP_CHOICE_H_
#define CLOTHID_IDENTIFY_CHECKS_STEP_CHOICE_H_

#include <Eigen/Core>
#include <limits>
#include <string>
#include <vector>

#include "identify/checks/discretization_check.h"

namespace clothid {

// No step is tried that is finer or coarser than h by more than 2^4.
inline constexpr int kMostStepLevels = 4;

// What was learnt of one step.
struct StepTrial {
  int level = 0;                                                       // the step is h 2^level
  double time_step = 0.0;                                              // s, of the first recording
  double error_over_noise = std::numeric_limits<double>::quiet_NaN();  // the largest of all estimates
  double order = std::numeric_limits<double>::quiet_NaN();             // of that one; NaN: no clear order

  bool is_fine_enough() const { return error_over_noise <= 1.0; }
};

struct StepChoice {
  std::vector<StepTrial> trials;  // in the order in which they were looked at; the first is h
  int level = 0;                  // of the step that was chosen; 0 where none was found
  bool found = false;
  double needed = std::numeric_limits<double>::quiet_NaN();  // s: the step that orders promise where none was found
  DiscretizationCheck check;  // the fits at half and at twice the chosen step, `changes` against the fit at h
  Eigen::VectorXd start;      // [p + n + f] estimate at the chosen step, in internal coordinates; where a fit may start
};

// "time step 0.0025 s: its errors are at most 0.4 of the noise (0.01 s: 5.1)", or why there is none.
std::string StepChoiceText(const StepChoice& choice);

// Of `motions`, fitted as `problem` with the estimate and the uncertainty of `summary`, whose counts get the work. Ends
// early, with none found, where options.cancel is true, where a fit fails, or where no standard deviation is known.
StepChoice ChooseTimeStep(const std::vector<RecordedMotion>& motions, const FitOptions& options,
                          const FitProblem& problem, FitSummary* summary);

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_CHECKS_STEP_CHOICE_H_
