// The start of the second stage of an SDIRK2 step (sim/step/second_start.h), linearised for both sweeps:
//
//   dx_s = dx_n + kappa (dx_1 - dx_n)
//   dv_s = dv_n + kappa (dv_1 - dv_n - du)
//   du   = U_c (dv_1 - dv_n) + U_r dr_1 + U_x dx_n + u_m dM   at the nodes whose impact the first stage has stopped
// with the blocks of sim/contact/impact_share.h. The solved first stage has r_1 = g, so with the matrices of
// step_derivative.h, b = h (H + V) dx_n - M dv_n + dg/dtheta being what does not come by dv_1:
//   dr_1 = K dv_1 + b
// Pairs of the cloth with itself that meet add theirs, with their own impulses, of handles among their nodes by x_n and
// v_1 - v_n as well; dr_1 of an obstacle's contact is then K dv_1 + b - J^T dr of them.
// A gradient by r_1, rho = U_r^T (..), goes back through that: K rho to v_1, and to all else as -rho does in y.
#ifndef CLOTHID_SIM_DERIVATIVE_SECOND_START_DERIVATIVE_H_
#define CLOTHID_SIM_DERIVATIVE_SECOND_START_DERIVATIVE_H_

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <vector>

#include "sim/contact/impact_share.h"
#include "sim/derivative/step_derivative.h"

namespace clothid {

// Columns over the free nodes [3 Nf x s]: derivatives of a state, or of scalars by it.
struct StateColumns {
  Eigen::MatrixXd positions, velocities;
};

class SecondStartDerivative {
 public:
  // After the first stage that `first` ends, from `start`, of which `step` is the derivative.
  SecondStartDerivative(const StepRecord& first, const SolveStart& start, const StepDerivative& step,
                        const Parameters& parameters, const ClothModel& model);

  bool has_impacts() const { return !impacts_.empty() || !cloth_impacts_.empty(); }  // else r_1, masses do not count
  bool reaches_handles() const;  // whether handles are among the nodes of impacts

  // dx_s and dv_s from those of the step's start and of the end of its first stage, without what impacts add.
  StateColumns Times(const StateColumns& start, const StateColumns& first) const;
  // Takes kappa du off dv_s. `impulses`: dr_1 [3 Nf x s], and dr of the pairs in the first stage.
  void SubtractImpacts(const StateColumns& start, const StateColumns& first, const StepColumns& impulses,
                       StateColumns* second) const;
  // Takes what comes by the handles among the nodes of pairs off the last columns of `velocities`, dv_s: by columns of
  // their dx_n and d(v_1 - v_n) [3H x s].
  void SubtractHandleImpacts(const Eigen::MatrixXd& positions, const Eigen::MatrixXd& changes,
                             Eigen::MatrixXd* velocities) const;
  // Takes that through a change of the nodes' masses [N] kg off column `column` of dv_s.
  void SubtractMasses(int column, const Eigen::VectorXd& masses, StateColumns* second) const;

  // kappa du/dtheta [3 Nf] at fixed x_n, v_n, v_1 and r_1, where theta is how an obstacle's path is placed and
  // `changes` are what it changes at the contacts of the first stage.
  Eigen::VectorXd MotionDerivative(const std::vector<MotionChange>& changes) const;

  // The transpose, of gradients by x_s and v_s: adds to those by the start and by the end of the first stage.
  void AddTransposed(const StateColumns& second, StateColumns* start, StateColumns* first) const;
  // With impacts: likewise, and returns the gradients by r_1 [3 Nf x s] and by the impulses of pairs.
  StepColumns AddImpactsTransposed(const StateColumns& second, StateColumns* start, StateColumns* first) const;
  // Adds the gradients by the handles' x_n and v_1 - v_n to columns [3H x s].
  void AddHandleImpactsTransposed(const StateColumns& second, Eigen::MatrixXd* positions,
                                  Eigen::MatrixXd* changes) const;
  // By a parameter of which the nodes' masses have the derivatives `slopes` [N], of each column [1 x s].
  Eigen::RowVectorXd MassGradient(const Eigen::VectorXd& slopes, const StateColumns& second) const;
  // Adds that by every node's mass to `gradient` [N x s].
  void AddMassGradient(const StateColumns& second, Eigen::MatrixXd* gradient) const;

 private:
  // Of a contact of the first stage that has stopped an impact.
  template <int kNodes, class Derivative>
  struct Impact {
    std::array<int, kNodes> nodes;    // -1: none
    std::array<int, kNodes> blocks;   // of the nodes among the free ones, or -1
    std::array<int, kNodes> handles;  // likewise among the handles
    std::size_t contact;              // among those of its kind
    Derivative derivative;            // times kappa
  };
  using ObstacleImpact = Impact<1, ObstacleImpactDerivative>;
  using ClothImpact = Impact<4, ImpactDerivative<4>>;

  template <class Function>
  void ForEach(const Function& function) const {
    for (const ObstacleImpact& impact : impacts_) function(impact);
    for (const ClothImpact& impact : cloth_impacts_) function(impact);
  }

  std::vector<ObstacleImpact> impacts_;
  std::vector<ClothImpact> cloth_impacts_;
  Eigen::Index num_impulses_ = 0;  // 3c
  Eigen::Index num_rows_ = 0;      // 3 Nf
};

}  // namespace clothid

#endif  // CLOTHID_SIM_DERIVATIVE_SECOND_START_DERIVATIVE_H_
