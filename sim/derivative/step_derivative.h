// The linearisation of one solve, a step or a stage of one, shared by both sweeps. With Phi(v_{n+1}; x_n, v_n, theta) =
// 0:
//
//   A dv = -[(I + S)(h (H + V) dx_n + N dx^ - M dv_n + dg/dtheta dtheta) + X dx_n - dr/dtheta dtheta]
// where H = d2(E + W)/dx2 at x_{n+1} as in step_problem.h; V = d2W/(dx dx_n), not symmetric, is there for internal
// damping alone; N = dg/dx^, through the normals at dx^ = dx_n + h dv_n, for drag by direction alone; dr/dtheta, the
// impulse at fixed F, for friction f_N t at slipping nodes; for the placement of an
// obstacle's path that through gap, normal and V at fixed v.
//
// Contacts of the cloth with itself add their impulses r to the unknowns v, and their equations R to Phi, of which then
// A, X and dr/dtheta have rows (sim/contact/pair_elimination.h, impulse_blocks.h); and to dg/dx_n at fixed v and r
// what their weights do. `StepColumns` are over both: whoever sweeps need not know which contacts there are.
//
// A second stage (sim/step/second_start.h) starts from x_s and v_s in place of x_n and v_n. Its strain rate starts from
// the metric C_s of x_n and x_1, so that h V dx_n gives way to h (V_n dx_n + V_1 dx_1), V_n = (1 - kappa) d2W/(dx dx_n)
// and V_1 = kappa d2W/(dx dx_1), as if x_n or x_1 were what the strain rate starts from.
#ifndef CLOTHID_SIM_DERIVATIVE_STEP_DERIVATIVE_H_
#define CLOTHID_SIM_DERIVATIVE_STEP_DERIVATIVE_H_

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "sim/contact/impulse_blocks.h"
#include "sim/derivative/size_derivative.h"
#include "sim/rollout/rollout.h"
#include "sim/scene/parameters.h"
#include "sim/step/step_jacobian.h"
#include "sim/step/step_problem.h"

namespace clothid {

class StepDerivative {
 public:
  // The solve that `record` ends. Everything must outlive the object, what `start` refers to as well, and the object
  // borrows the simulator's matrices: one at a time. `sizes` (may be null): for derivatives by the size of the cloth.
  StepDerivative(const StepRecord& record, const SolveStart& start, const Parameters& parameters, Simulator* simulator,
                 const SizeDerivative* sizes = nullptr);

  // Factors A. False where it fails.
  bool Factor(StepJacobian::Method method);
  // Where that or its solves fail: LU, or, as that has no pairs of the cloth, a positive definite matrix near by as a
  // preconditioner. False where it fails.
  bool FactorOtherwise();
  // Solves with `factor`, which was made at the end of the step or near it, in its place. False where it is null.
  bool UseFactor(std::shared_ptr<const ReducedFactor> factor);
  StepJacobian& jacobian() { return jacobian_; }
  const ContactSet& contacts() const { return contacts_; }                 // what sticks or slips
  const ImpulseBlocks& impulse_blocks() const { return impulses_; }        // of those of the cloth with itself
  Eigen::Index num_impulses() const { return impulses_.friction.size(); }  // 3c, the rows of r and R

  double time_step() const { return record_.time_step; }  // h
  // Whether N is there, and may be asked for.
  bool has_prediction() const { return forces_.needs_prediction(); }

  // dg/d(v, r): K dv - J^T dr; and the transpose.
  Eigen::MatrixXd TimesUnknowns(const StepColumns& columns) const;
  StepColumns TimesUnknownsTransposed(const Eigen::MatrixXd& columns) const;

  // On columns over the free nodes [3 Nf x s].
  Eigen::MatrixXd TimesMass(const Eigen::MatrixXd& columns) const;             // M y
  Eigen::MatrixXd TimesStart(const Eigen::MatrixXd& columns) const;            // h (H + V) y, dg/dx_n at fixed v and r
  Eigen::MatrixXd TimesStartTransposed(const Eigen::MatrixXd& columns) const;  // h (H + V^T) y
  Eigen::MatrixXd TimesPrediction(const Eigen::MatrixXd& columns) const;       // N y
  Eigen::MatrixXd TimesPredictionTransposed(const Eigen::MatrixXd& columns) const;  // N^T y
  StepColumns TimesFrames(const Eigen::MatrixXd& columns) const;                    // X y
  Eigen::MatrixXd TimesFramesTransposed(const StepColumns& columns) const;          // X^T z

  // What the force of pairs upon handles at the end of the solve, sum w_i r/h [3H] N, gains by dr and dx_n, and the
  // transpose, which it adds to both.
  Eigen::MatrixXd TimesHandleForces(const Eigen::MatrixXd& impulses, const Eigen::MatrixXd& start) const;
  void AddHandleForcesTransposed(const Eigen::MatrixXd& forces, Eigen::MatrixXd* impulses,
                                 Eigen::MatrixXd* start) const;

  // Of a second stage, whose TimesStart is h H y: whether C_s, and with it g, depends on x_n and x_1.
  bool has_origins() const { return forces_.needs_origins() && start_.first_positions != nullptr; }
  // h (V_n y_n + V_1 y_1).
  Eigen::MatrixXd TimesOrigins(const Eigen::MatrixXd& step, const Eigen::MatrixXd& first) const;
  // Takes h V_n^T y off `step` and h V_1^T y off `first`.
  void SubtractOriginsTransposed(const Eigen::MatrixXd& columns, Eigen::MatrixXd* step, Eigen::MatrixXd* first) const;

  // dg/dtheta [3 Nf]; zero for parameters of contact.
  Eigen::VectorXd MomentumDerivative(ParameterId id) const;
  // dM/dtheta of every node [N] kg; null for a parameter that has no part in it.
  const Eigen::VectorXd* MassSlopes(ParameterId id) const;
  // dr/dtheta at fixed v and x_n, and -dR/dtheta at fixed r, too; zero unless `id` is a parameter of contact.
  StepColumns ImpulseDerivative(ParameterId id) const;
  // Of a placement: what it changes at every contact, nothing at those with other obstacles.
  std::vector<MotionChange> MotionChanges(ParameterId id) const;

  // How the obstacle of one of `contacts().nodes` moves there over the solve; null: it stands still.
  const AffineMotion* motion_of(const Contact& contact) const;

 private:
  Eigen::MatrixXd TimesHessian(const Eigen::MatrixXd& columns) const;  // h H y = (K y - M y - h C y)/h
  ForcePoint point() const;
  // h V y by the positions `origin`, and h V^T y.
  Eigen::MatrixXd TimesMixed(const Eigen::VectorXd& origin, const Eigen::MatrixXd& columns) const;
  Eigen::MatrixXd TimesMixedTransposed(const Eigen::VectorXd& origin, const Eigen::MatrixXd& columns) const;

  const StepRecord& record_;
  const SolveStart start_;
  const Parameters& parameters_;
  const ClothModel& model_;
  const ForceSet& forces_;
  const SizeDerivative* sizes_;
  BlockMatrix& hessian_;
  StepJacobian& jacobian_;
  Eigen::VectorXd masses_;         // M [3 Nf]
  Eigen::VectorXd damped_masses_;  // M + h c_d diag(a) [3 Nf]
  HeldForces held_;
  std::vector<ObstacleMotion> motions_;        // empty where no obstacle moves
  ContactSet contacts_;                        // of the record
  std::vector<AffineMotion> contact_motions_;  // of their obstacles there, per contact; empty where no obstacle moves
  ImpulseBlocks impulses_;
};

}  // namespace clothid

#endif  // CLOTHID_SIM_DERIVATIVE_STEP_DERIVATIVE_H_
