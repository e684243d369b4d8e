// Reverse sweep over a rollout: the gradients of several scalars of the trajectory at once.
#ifndef CLOTHID_SIM_DERIVATIVE_ADJOINT_H_
#define CLOTHID_SIM_DERIVATIVE_ADJOINT_H_

#include <Eigen/Core>
#include <functional>
#include <vector>

#include "sim/derivative/adjoint_options.h"
#include "sim/rollout/rollout.h"
#include "sim/scene/parameters.h"

namespace clothid {

class Simulator;

// Gradients of s scalars C_1 .. C_s of the trajectory.
struct RolloutGradient {
  Eigen::MatrixXd parameters;          // [p x s] dC/dtheta, in the parameter's own unit (not logarithmic)
  Eigen::MatrixXd initial_positions;   // [3N x s] dC/dx_0; zero at handles, whose path is part of the scene
  Eigen::MatrixXd initial_velocities;  // [3N x s] dC/dv_0; zero at handles
  // [3 H K x s] dC/d(values of Rollout::handle_offsets at its K knots), ordered as in SensitivityDirections; empty
  // without them.
  Eigen::MatrixXd handle_offsets;
  // [K F x s] dC/d(logarithm of every triangle's value) of the K fields of the parameters; empty without them.
  Eigen::MatrixXd fields;
  AdjointWork work;
};

// Adds dC_i/dx after `step` steps (step 0: the start) to column i of `gradient` [3N x s].
using AddPositionGradient = std::function<void(int step, Eigen::MatrixXd* gradient)>;

// Walks the steps of `rollout` backwards, which must be ok() and come from the same `simulator`. At step n, with
// lambda_x and lambda_v the gradients with respect to x_{n+1} and v_{n+1}:
//   w = lambda_v + h lambda_x;   A^T z = w;   y = (I + S)^T z
//   lambda_v <- M y - h N^T y;   lambda_x <- lambda_x - h (H + V^T) y - N^T y - X^T z
// with the matrices of step_derivative.h. Stages go back likewise, with second_start_derivative.h between the second
// and the first. What handle_coupling.h says of handles, transposed, goes to their offsets. Throws `std::runtime_error`
// where a step Jacobian is singular, and where RecordReader does.
//
// `add_pair_force_gradient` (may be empty): likewise dC_i/dF of the forces of pairs upon handles at the end of step
// 1, .. (sim/rollout/pair_forces.h) to column i of `gradient` [3H x s].
//
// Where the rollout is corrected, x after a step is that before the correction. `add_corrected_gradient` (may be
// empty): likewise dC_i/dx by the corrected positions of the steps that have such, which go back through
// correction_derivative.h.
RolloutGradient PullBack(const Rollout& rollout, const std::vector<ParameterId>& parameters, int num_columns,
                         const AddPositionGradient& add_position_gradient, Simulator* simulator,
                         const AdjointOptions& options = {}, const AddPositionGradient& add_pair_force_gradient = {},
                         const AddPositionGradient& add_corrected_gradient = {});

}  // namespace clothid

#endif  // CLOTHID_SIM_DERIVATIVE_ADJOINT_H_
