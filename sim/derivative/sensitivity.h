// Forward sweep: derivatives of the whole trajectory along a few directions, alongside the rollout, nothing stored.
#ifndef CLOTHID_SIM_DERIVATIVE_SENSITIVITY_H_
#define CLOTHID_SIM_DERIVATIVE_SENSITIVITY_H_

#include <Eigen/Core>
#include <atomic>
#include <functional>
#include <vector>

#include "sim/rollout/rollout.h"
#include "sim/scene/parameters.h"

namespace clothid {

class Simulator;

// The directions: first the parameters, then the columns of the start state's perturbations.
struct SensitivityDirections {
  std::vector<ParameterId> parameters;  // p of them
  Eigen::MatrixXd initial_positions;    // [3N x q] m, or empty for q = 0; entries of handles are ignored
  Eigen::MatrixXd initial_velocities;   // [3N x q] m/s, or empty
};

// Called with x [3N] and dx [3N x (p + q)] after `step` steps, from step 0 on.
using SensitivityVisitor =
    std::function<void(int step, const Eigen::VectorXd& positions, const Eigen::MatrixXd& positions_derivative)>;

struct SensitivityResult {
  RolloutCounts counts;
  std::optional<StepFailure> failure;  // set: the rollout ended early; the visitor saw the steps before
};

// Runs the rollout that `Simulate` would run, and with it
//   A dv = -[(I + S)(h (H + V) dx_n - M dv_n + dg/dtheta) + X dx_n - dr/dtheta],   dx_{n+1} = dx_n + h dv
// with the matrices of step_derivative.h.
SensitivityResult PushForward(const Parameters& parameters, int num_steps, const SensitivityDirections& directions,
                              const SensitivityVisitor& visitor, Simulator* simulator,
                              const std::atomic<bool>* cancel = nullptr);

}  // namespace clothid

#endif  // CLOTHID_SIM_DERIVATIVE_SENSITIVITY_H_
