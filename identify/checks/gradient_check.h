// Do the adjoint, the sensitivities and finite differences of the cost agree at the starting values?
#ifndef CLOTHID_IDENTIFY_CHECKS_GRADIENT_CHECK_H_
#define CLOTHID_IDENTIFY_CHECKS_GRADIENT_CHECK_H_

#include <string>
#include <vector>

#include "datasets/motion/recorded_motion.h"
#include "identify/base/options.h"

namespace clothid {

// Largest relative differences of dL/dq over the parameters with influence (|dL/dq| > 1e-8 L), q the internal
// coordinate.
struct GradientCheck {
  double adjoint_vs_sensitivity = 0.0;
  // Central differences of L; a contact that switches its branch between the two sides shows here.
  double adjoint_vs_fd = 0.0;
  std::string failure = {};  // one line: why a rollout or derivative failed; empty: none did
};

// Runs at a step tolerance of 1e-10, or the scene's where that is tighter. Throws `Error` for what `FitProblem`
// rejects; a rollout that fails is a failure of the check.
GradientCheck CheckGradients(const std::vector<RecordedMotion>& motions, const FitOptions& options);

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_CHECKS_GRADIENT_CHECK_H_
