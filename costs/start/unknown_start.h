// The start of a recording as unknowns of a fit: where the cloth was, how fast, and where its handles were.
//
// A recording that was imported shows its cloth first in a noisy frame. With base x_b, v_b (the scene's start, see
// datasets/motion/start_state.h) and unknowns s = (q, c, p):
//   x_0 = x_b + sum_m q_m phi_m + sum_j c_j w_j(t_0) psi_j,   v_0 = v_b + sum_m p_m phi_m (StartSource::kMoving alone),
//   handles at time t: their path + sum_j c_j w_j(t).
// phi: smooth modes (smooth_modes.h), one per coordinate each. c: the values at a few knots in time of what the path of
// the handles is off, w the interpolation between them (HandlePath): of every handle, or, where these are too many for
// the knots that the path asks for, of the patterns of several handles that bend and strain the cloth least. psi: how
// the cloth about a handle goes along, -A_ff^-1 A_fh with A = L/(e^2 a) + Q/(3 b^2) + (weights of the points).
//
// What is believed beforehand: strain and bending of x_0, and their rates of v_0, are those of a cloth, and handles are
// where they were measured:
//   sum over triangles |F - R|^2/(2 e^2) + x_0^T Q x_0/(6 b^2)                     e = 0.03, b = 0.1
//   the same of v_0, to second order about x_b, with                               e = 0.6/s, b = 6/s
//   sum over measurements of handles |offset - deviation|^2/(2 sigma^2)            datasets/motion/recorded_motion.h
// a the mean area of triangles, L and Q the matrices of sim/cloth/, Q by edges; by patches it counts three times. Taken
// to second order about the base:
//   prior(s) = 1/2 (s - m)^T P (s - m) = 1/2 |U (s - m)|^2.
// Independent priors on the modes would leave velocities of 1 to 2 m/s open. A strain of 1 % in place of 3 % would bias
// the stiffness: gravity strains a cloth, too. Rates of half the size would pull friction by a third of its deviation
// in a cloth that is on its way, without telling it any better.
#ifndef CLOTHID_COSTS_START_UNKNOWN_START_H_
#define CLOTHID_COSTS_START_UNKNOWN_START_H_

#include <Eigen/Core>
#include <optional>

#include "datasets/motion/recorded_motion.h"
#include "sim/derivative/adjoint.h"
#include "sim/derivative/sensitivity.h"
#include "sim/path/handle_path.h"

namespace clothid {

class ShapePrior;
struct QuadraticPrior;

// Modes per coordinate of positions and of velocities. Twice as many neither cover better nor narrow an interval. A
// mesh of fewer free nodes has as many.
inline constexpr int kPositionModes = 30;
inline constexpr int kVelocityModes = 20;

class UnknownStart {
 public:
  // Of a recording whose start is unknown (`IsUnknown`). Keeps no reference to it. Throws `std::runtime_error` where
  // its modes are not found.
  explicit UnknownStart(const RecordedMotion& motion);

  int size() const { return static_cast<int>(mean_.size()); }   // n
  int num_position_unknowns() const { return num_positions_; }  // q, which come first
  int num_handle_unknowns() const { return num_offsets_; }      // c, which come next
  // Of the offsets of handles, s; empty where their path is exact.
  const Eigen::VectorXd& handle_knots() const { return knot_times_; }

  // At unknowns s [n]: x_0 and v_0 [3N]. Zero is the base.
  Eigen::VectorXd PositionsAt(const Eigen::VectorXd& unknowns) const;
  Eigen::VectorXd VelocitiesAt(const Eigen::VectorXd& unknowns) const;
  // What to add to the path of the handles; absent where their path is exact.
  std::optional<HandlePath> HandleOffsetsAt(const Eigen::VectorXd& unknowns) const;

  // Of the columns of a forward sweep, d/ds [.. x n]; no parameters.
  const SensitivityDirections& directions() const { return directions_; }
  // Of combinations of them [n x c]: c columns.
  SensitivityDirections DirectionsAlong(const Eigen::MatrixXd& combinations) const;
  // From the gradients of a reverse sweep: dC/ds [n x s].
  Eigen::MatrixXd PullBack(const RolloutGradient& gradient) const;

  // How far handles are from where they were measured, root mean square over their unknowns, in standard deviations of
  // what was measured; 0 where their path is exact.
  double HandleError(const Eigen::VectorXd& unknowns) const;

  double PriorAt(const Eigen::VectorXd& unknowns) const;
  // U (s - m) [u] and its Jacobian U [u x n], u <= n.
  Eigen::VectorXd PriorResiduals(const Eigen::VectorXd& unknowns) const { return root_ * (unknowns - mean_); }
  const Eigen::MatrixXd& prior_jacobian() const { return root_; }
  // What of it was measured of the handles, alone: a root [r x c] of its precision of c, empty where their path is
  // exact.
  const Eigen::MatrixXd& handle_jacobian() const { return handle_root_; }

 private:
  // Of the constructor: the directions of the handles and what was measured of them; and U and m.
  void AddHandles(const RecordedMotion& motion, const ShapePrior& shape, QuadraticPrior* prior);
  void SetPrior(const QuadraticPrior& prior);

  Eigen::VectorXd base_positions_, base_velocities_;  // [3N]
  Eigen::VectorXd knot_times_;                        // s; empty: exact handles
  int num_positions_ = 0, num_offsets_ = 0;
  SensitivityDirections directions_;
  Eigen::MatrixXd root_;  // U [u x n]
  Eigen::VectorXd mean_;  // m [n]
  // What was measured of the handles, for c alone: a root of its precision [r x c] and its mean [c].
  Eigen::MatrixXd handle_root_;
  Eigen::VectorXd handle_mean_;
};

}  // namespace clothid

#endif  // CLOTHID_COSTS_START_UNKNOWN_START_H_
