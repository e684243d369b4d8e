// The equations of one implicit solve, a step or a stage of one (stage.h), here called a step (Eqs. (8) and (9) of the
// DiffCloth paper), in the velocity v = v_{n+1}:
//
//   g(v) = M (v - v_n) - h f_ext(v) - h f_int(x_n + h v; x_n) = J^T r,   (r, u = J v) in the contact law
//   Phi(v) = g(v) - J^T r(F(v)),  F = d (v - V) - g + (d gap_speed) n     its root is the step
//   K = dg/dv = M + h C + h^2 H(x_n + h v)
// Where the cloth may touch itself, the impulses r of those contacts are unknowns, too (sim/contact/self_contact.h):
// g(v) - sum_c J_c^T r_c stands for g(v) in the above, and R_c(v, r) = 0 beside Phi(v, r) = 0.
// f_ext is gravity, which does not see the added mass in M, the scene's node force, pressure (pressure_term.h) and
// drag: c_d a (w - v), and that by direction (directional_drag.h). C = c_d diag(a) + d2D/dv2. f_int = -d(E + W)/dx and
// H = d2(E + W)/dx2, E the energy of stretch, bending and, at the end of the step, seams, W the dissipation potential
// of internal damping, which alone depends on x_n and h as well (strain_rate_damping.h). The normals of drag by
// direction are those at the positions x^ = x_n + h v_n, handles at the end of the step; handles have there the
// velocity (x_{n+1} - x_n)/h. d_j = P_jj, the diagonal of PD's constant matrix P = M + h c_d diag(a) + h^2 (k L + k_b Q
// + Q_s) + h eta L, Q_s of seams. All vectors over free nodes [3 Nf] unless marked [3N].
#ifndef CLOTHID_SIM_STEP_STEP_PROBLEM_H_
#define CLOTHID_SIM_STEP_STEP_PROBLEM_H_

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "sim/cloth/cloth_model.h"
#include "sim/contact/step_contacts.h"
#include "sim/scene/parameters.h"
#include "sim/step/obstacle_motions.h"
#include "sim/step/stage.h"

namespace clothid {

// The equations evaluated at one velocity.
struct StepPoint : ContactPoint {
  Eigen::VectorXd velocities;         // v
  Eigen::VectorXd positions;          // x_n + h v [3N], handles at their path
  Eigen::VectorXd momentum_gradient;  // g
  Eigen::VectorXd residual;           // Phi
  double potential = 0.0;             // whose gradient is g, J: kinetic distance to v_n, drag, external energy, E and W
  double scale = 0.0;                 // largest of h |f_ext|, |M v_n|, h |dE/dx| and h |dW/dx|, N s
  double relative_residual = 0.0;     // |(Phi, R)| / scale
};

// Memory for the problems of one model, one at a time, and nobody's but theirs: from the second step on nothing is
// allocated, and what material and step size alone determine is computed when they change. Results do not depend on
// what it was used for before.
struct StepWorkspace {
  Material material;                 // what the next members belong to, with
  double time_step = 0.0;            // 0: to nothing yet
  Eigen::VectorXd masses;            // M, per free node
  Eigen::VectorXd drag;              // h C, per free node; empty without drag
  Eigen::VectorXd weights;           // d, per free node
  double weight_norm = 0.0;          // |d|
  Eigen::VectorXd external_impulse;  // h times the part of f_ext that does not depend on v
  double external_norm = 0.0;        // its size, N s

  Eigen::VectorXd start_positions;   // x_n [3N]
  Eigen::VectorXd start_velocities;  // v_n
  double start_momentum = 0.0;       // |M v_n|, N s
  Eigen::VectorXd handle_positions;  // at the end, in the order of the scene's handles
  Eigen::VectorXd all_velocities;    // [3N], those of handles set; empty where no force needs them
  HeldForces held;
  StepContacts contacts;
  Eigen::VectorXd force;  // [3N] scratch
};

// K at `point` overwrites `hessian`.
void AssembleStepHessian(const ClothModel& model, HessianKind kind, const ForcePoint& point, const HeldForces& held,
                         BlockMatrix* hessian);

class StepProblem {
 public:
  // Model, parameters and workspace must outlive the problem, which has the workspace for itself. `handle_offsets` (may
  // be null): added to the path of the handles.
  StepProblem(const ClothModel& model, const Parameters& parameters, const SolveStart& start, const SolveTimes& times,
              StepWorkspace* workspace, const HandlePath* handle_offsets = nullptr);

  // The same step with every friction coefficient times `share`, on the same workspace.
  StepProblem WithFriction(double share) const;

  double time_step() const { return time_step_; }
  double end_time() const { return end_time_; }
  Stage stage() const { return stage_; }
  const Eigen::VectorXd& start_velocities() const { return work_.start_velocities; }  // v_n
  const StepContacts& contacts() const { return work_.contacts; }                     // that there may be
  double friction_coefficient(int candidate) const;                                   // mu of its obstacle
  const std::vector<double>& friction_coefficients() const {                          // mu of every obstacle
    return eased_friction_.empty() ? parameters_.friction_coefficients : eased_friction_;
  }
  double self_friction() const { return is_eased_ ? eased_self_friction_ : parameters_.self_friction; }
  bool has_friction() const;

  // At `velocities`, and the impulses that `point` has for every pair.
  void Evaluate(const Eigen::VectorXd& velocities, StepPoint* point) const;

  // `team` (may be null) shares the work.
  void AssembleHessian(HessianKind kind, const StepPoint& point, BlockMatrix* hessian,
                       ThreadTeam* team = nullptr) const;

  // Smallest relative residual that rounding allows at `point`: 0.6 eps sqrt(3) |d| |x|_max/(h scale), times what
  // forces have stiffened by.
  double RoundingFloor(const StepPoint& point) const;

  // What is to fall along an iteration: |Phi|, or, where the cloth may touch itself, whose equations have other units,
  // (sum |Phi_i|^2/d_i + sum |R_c|^2/d_c)^1/2.
  double ResidualSize(const StepPoint& point) const;

  // What contacts add to the potential where normal impulses are held as at `lagged`. A step minimises the sum of both.
  double HeldPotential(const StepPoint& lagged, const Eigen::VectorXd& velocities) const {
    return work_.contacts.HeldPotential(friction(), lagged, velocities);
  }

  // The sticking and slipping nodes at `point`, and all of its pairs, those that leave as well.
  ContactSet ContactsAt(const StepPoint& point) const;
  void FindContacts(const StepPoint& point, ContactSet* contacts) const;  // which they overwrite

  // Adds the pairs that thinning has left out and that `point` brings too near, without friction. True:
  // there are some, and the step has to be solved again, with rows that may depend on each other.
  bool TakesBackPairs(const StepPoint& point) { return work_.contacts.TakeBack(point.velocities); }

  // The velocities [3N] of the step, with those of the handles.
  Eigen::VectorXd AllVelocities(const StepPoint& point) const;

 private:
  // Of the constructor.
  void SetConstants();
  void SetExternalImpulse();
  void SetHandles(const HandlePath* offsets);
  void HoldForces(const SolveStart& start);

  void FindContactsToBe(const SolveStart& start, const SolveTimes& times);

  // v, x, and the terms of g and its potential that are neither drag nor an internal force.
  void MoveTo(const Eigen::VectorXd& velocities, StepPoint* point) const;
  void PlaceHandles(Eigen::VectorXd* positions) const;  // [3N], at the end
  void AddDrag(StepPoint* point) const;
  // Takes the forces of a group over the step off the gradient and adds their potential and the size of their impulse.
  void AddForces(ForceGroup group, StepPoint* point) const;
  ForcePoint ForcesAt(const StepPoint& point) const;  // sets the velocities in the workspace where forces need them
  ContactFriction friction() const { return {friction_coefficients(), self_friction()}; }

  const ClothModel& model_;
  const Parameters& parameters_;
  StepWorkspace& work_;
  double time_step_, end_time_;
  Stage stage_;
  std::vector<double> eased_friction_;  // of WithFriction; empty: that of the parameters
  double eased_self_friction_ = 0.0;    // likewise, where
  bool is_eased_ = false;
};

}  // namespace clothid

#endif  // CLOTHID_SIM_STEP_STEP_PROBLEM_H_
