// Reverse sweep over a rollout: the gradients of several scalars of the trajectory at once.
#ifndef CLOTHID_SIM_DERIVATIVE_ADJOINT_H_
#define CLOTHID_SIM_DERIVATIVE_ADJOINT_H_

#include <Eigen/Core>
#include <functional>
#include <optional>
#include <vector>

#include "sim/base/phase_seconds.h"
#include "sim/rollout/rollout.h"
#include "sim/scene/parameters.h"

namespace clothid {

class Simulator;

// How A^T z = w is solved at every step. Section 5.4 of the DiffCloth paper compares kSparseLu and kFixedPoint.
enum class AdjointMethod {
  kReduced,      // contacts eliminated, Cholesky of the symmetric rest, friction coupling by GMRES
  kLu,           // sparse LU of the whole step Jacobian (UMFPACK): the reference
  kSparseLu,     // the same by Eigen's SparseLU
  kFixedPoint,   // P z <- (dP + dR)^T z + w with the prefactored P of sim/cloth/system_matrix.h
  kSystemGmres,  // GMRES preconditioned by P, without restart
};

struct AdjointOptions {
  AdjointMethod method = AdjointMethod::kReduced;
  // Relative residual |w - A^T z|/|w| of the iterative methods; absent: `adjoint_tolerance` of the scene. It does not
  // depend on the d of the contact law, which the methods choose differently.
  std::optional<double> threshold = std::nullopt;
  bool use_kept_factors = true;  // kReduced: those of RolloutOptions::factor_memory, as preconditioners
};

// What a sweep took. A method that misses its threshold hands over to LU: kReduced to UMFPACK, the iterations on P to
// Eigen's.
struct AdjointWork {
  int solves = 0;         // linear systems: one per step, more where substeps were taken
  int iterations = 0;     // of the slowest column, summed over the solves; a direct method has none
  int failed_solves = 0;  // in which LU stepped in
  // Wall time, s. Phases as in Table 1 of the paper: factorization and solution are its linear solve (with the steps
  // that LU took over), assembly its dP, contact its dR.
  PhaseSeconds phases;
  double total_seconds = 0.0;
  double fallback_seconds = 0.0;  // of LU where it stepped in; part of the phases

  double other_seconds() const { return total_seconds - phases.sum(); }
};

// Gradients of s scalars C_1 .. C_s of the trajectory.
struct RolloutGradient {
  Eigen::MatrixXd parameters;          // [p x s] dC/dtheta, in the parameter's own unit (not logarithmic)
  Eigen::MatrixXd initial_positions;   // [3N x s] dC/dx_0; zero at handles, whose path is part of the scene
  Eigen::MatrixXd initial_velocities;  // [3N x s] dC/dv_0; zero at handles
  AdjointWork work;
};

// Adds dC_i/dx after `step` steps (step 0: the start) to column i of `gradient` [3N x s].
using AddPositionGradient = std::function<void(int step, Eigen::MatrixXd* gradient)>;

// Walks the steps of `rollout` backwards, which must be ok() and come from the same `simulator`. At step n, with
// lambda_x and lambda_v the gradients with respect to x_{n+1} and v_{n+1}:
//   w = lambda_v + h lambda_x;   A^T z = w;   y = (I + S)^T z
//   lambda_v <- M y;             lambda_x <- lambda_x - h (H + V^T) y - X^T z
// with the matrices of step_derivative.h.
// Throws `std::runtime_error` where a step Jacobian is singular, and where RecordReader does.
RolloutGradient PullBack(const Rollout& rollout, const std::vector<ParameterId>& parameters, int num_columns,
                         const AddPositionGradient& add_position_gradient, Simulator* simulator,
                         const AdjointOptions& options = {});

}  // namespace clothid

#endif  // CLOTHID_SIM_DERIVATIVE_ADJOINT_H_
