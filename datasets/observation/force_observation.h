// The forces of a recording as measurements of a fit: the way from forces after steps to residuals, and back.
//
// A force at a recorded time is linear in time between the forces after the steps around it
// (sim/rollout/handle_forces.h, datasets/observation/frame_stencil.h), its residual
//   (predicted - measured)/sigma
// for every component that was measured. Forces are on the clock of the scene and along its axes, as handles are: what
// a fit corrects of the clock and the frame of reference of the positions does not concern them.
#ifndef CLOTHID_DATASETS_OBSERVATION_FORCE_OBSERVATION_H_
#define CLOTHID_DATASETS_OBSERVATION_FORCE_OBSERVATION_H_

#include <Eigen/Core>
#include <vector>

#include "datasets/motion/recorded_motion.h"
#include "datasets/observation/frame_stencil.h"

namespace clothid {

// How far predicted forces are from the measured ones; the errors of recordings add up.
struct ForceError {
  double squared_error = 0.0;  // N^2
  double num_components = 0.0;
  double successive_products = 0.0;  // N^2: errors of a component in one reading and the next in which it was measured
  double successive_squares = 0.0;   // N^2: the mean of their squares, summed likewise

  double rms() const;              // N, of a component; NaN where there is none
  double autocorrelation() const;  // of a component's errors from reading to reading; NaN without two, or without error
  ForceError& operator+=(const ForceError& other);
};

// A component of a group's force that was measured, a row of the residual.
struct SeenForce {
  int reading = 0;
  int row = 0;  // 3 group + axis
};

class ForceObservation {
 public:
  ForceObservation() = default;
  // Of a valid recording; empty where it has no forces. Keeps no reference.
  explicit ForceObservation(const RecordedMotion& motion);

  bool is_empty() const { return stencils_.empty(); }
  int num_groups() const { return static_cast<int>(groups_.size()); }      // G
  int num_readings() const { return static_cast<int>(stencils_.size()); }  // F
  int num_residuals() const { return static_cast<int>(seen_.size()); }
  const std::vector<std::vector<int>>& groups() const { return groups_; }  // [G] nodes, handles all
  const std::vector<FrameStencil>& stencils() const { return stencils_; }  // [F]
  int last_step() const { return stencils_.back().last_step(); }
  double sigma(int group) const { return sigma_[group]; }  // N

  // The rows of the residual, ordered by reading, then group, then axis. Reading i has the rows first_row(i) ..
  // first_row(i + 1) - 1, from 0 on.
  const std::vector<SeenForce>& seen() const { return seen_; }
  int first_row(int reading) const { return first_row_[static_cast<std::size_t>(reading)]; }
  int nearest_frame(int reading) const { return nearest_frame_[static_cast<std::size_t>(reading)]; }

  // Forces [3G x F] over sigma, and less the measured ones.
  Eigen::VectorXd Whiten(const Eigen::MatrixXd& forces) const;
  Eigen::VectorXd Residuals(const Eigen::MatrixXd& forces) const;
  ForceError Compare(const Eigen::MatrixXd& forces) const;
  // One reading with derivatives, as Observation::LinearizeFrame: forces [3G x (1 + q)].
  void LinearizeReading(int reading, const Eigen::MatrixXd& forces, Eigen::VectorXd* residuals,
                        Eigen::MatrixXd* jacobian) const;
  // (d residuals of the reading/d forces)^T seeds, of all rows of forces [m x s]: [3G x s].
  Eigen::MatrixXd PullBack(int reading, const Eigen::Ref<const Eigen::MatrixXd>& seeds) const;

 private:
  std::vector<std::vector<int>> groups_;
  Eigen::VectorXd sigma_;  // [G]
  std::vector<FrameStencil> stencils_;
  std::vector<SeenForce> seen_;
  std::vector<int> first_row_, nearest_frame_;
  Eigen::VectorXd measured_;  // over sigma
};

}  // namespace clothid

#endif  // CLOTHID_DATASETS_OBSERVATION_FORCE_OBSERVATION_H_
