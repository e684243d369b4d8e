// Forward sweep: derivatives of the whole trajectory along a few directions, alongside the rollout, nothing stored.
#ifndef CLOTHID_SIM_DERIVATIVE_SENSITIVITY_H_
#define CLOTHID_SIM_DERIVATIVE_SENSITIVITY_H_

#include <Eigen/Core>
#include <atomic>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "sim/rollout/rollout.h"
#include "sim/scene/parameters.h"

namespace clothid {

class Simulator;

// The directions: first the parameters, then the columns of what the rollout is given besides. A column may change
// start and handles at once.
struct SensitivityDirections {
  std::vector<ParameterId> parameters;  // p of them
  Eigen::MatrixXd initial_positions;    // [3N x q] m, or empty; entries of handles are ignored
  Eigen::MatrixXd initial_velocities;   // [3N x q] m/s, or empty
  // [3 H K x q] m, or empty: changes of the H handles at the first knot of `SensitivityOptions::handle_offsets`, then
  // at the second, .. of K.
  Eigen::MatrixXd handle_offsets;
  // [K F x q], or empty: changes of the logarithms of the values that the K fields of the parameters have per triangle,
  // those of the first field first.
  Eigen::MatrixXd fields = {};
};

// Called with x [3N] and dx [3N x (p + q)] after `step` steps, from step 0 on.
using SensitivityVisitor =
    std::function<void(int step, const Eigen::VectorXd& positions, const Eigen::MatrixXd& positions_derivative)>;

// Called before it, after every step but the start, with the forces of pairs upon handles F [3H] N
// (sim/rollout/pair_forces.h) and dF [3H x (p + q)].
using PairForceVisitor =
    std::function<void(int step, const Eigen::VectorXd& forces, const Eigen::MatrixXd& forces_derivative)>;

struct SensitivityResult {
  RolloutCounts counts;
  std::optional<StepFailure> failure;  // set: the rollout ended early; the visitor saw the steps before
};

struct SensitivityOptions {
  std::optional<double> step_tolerance;  // as of RolloutOptions
  // As of RolloutOptions.
  const Eigen::VectorXd* initial_positions = nullptr;
  const Eigen::VectorXd* initial_velocities = nullptr;
  const HandlePath* handle_offsets = nullptr;
  std::shared_ptr<const Correction> correction = nullptr;
  // Relative residual asked of the linear systems where they are solved by iteration. Absent: the scene's.
  std::optional<double> adjoint_tolerance;
  PairForceVisitor pair_force_visitor = {};  // may be empty
  // Called after the visitor, at the end of the steps that were corrected, with the corrected x and its dx. May be
  // empty.
  SensitivityVisitor corrected_visitor = {};
};

// Runs the rollout that `Simulate` would run, and with it
//   A dv = -[(I + S)(h (H + V) dx_n + N dx^ - M dv_n + dg/dtheta) + X dx_n - dr/dtheta],   dx_{n+1} = dx_n + h dv
// with the matrices of step_derivative.h, stage by stage with what second_start_derivative.h says in between; handles
// that move add what handle_coupling.h says to the bracket of I + S, and corrections what correction_derivative.h says.
// Throws `std::runtime_error` where a step Jacobian
// is singular, `std::logic_error` where directions have other sizes, and as `Simulate` does.
SensitivityResult PushForward(const Parameters& parameters, int num_steps, const SensitivityDirections& directions,
                              const SensitivityVisitor& visitor, Simulator* simulator,
                              const std::atomic<bool>* cancel = nullptr, const SensitivityOptions& options = {});

// The same along a rollout that is at hand: nothing is simulated, and the factors that it keeps are used again. For a
// product with the Jacobian of its trajectory, as often as one is wanted. It must be ok() and come from the same
// `simulator`. `adjoint_tolerance`: as of SensitivityOptions.
void PushForward(const Rollout& rollout, const SensitivityDirections& directions, const SensitivityVisitor& visitor,
                 Simulator* simulator, std::optional<double> adjoint_tolerance = std::nullopt,
                 const PairForceVisitor& pair_force_visitor = {}, const SensitivityVisitor& corrected_visitor = {});

}  // namespace clothid

#endif  // CLOTHID_SIM_DERIVATIVE_SENSITIVITY_H_
