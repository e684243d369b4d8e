// Corrections of the state (sim/rollout/correction.h) in sweeps.
//
// With d and dv what is asked for after scale and groups, n and phi of the obstacle that limits a node, [.] where the
// node does not touch it and is outside of it:
//   x+ = x + d - n (n . d) [- phi n]          v+ = v + dv - n (n . dv) where it touches it
// so that along changes of x, d, dv and of the obstacle's placement, dn = N' dx + n_theta, dphi = n . dx + phi_theta,
//   dx+ = dx + (I - n n^T) dd - dn (n . d) - n (dn . d) [- phi dn - n dphi]
//   dv+ = dv + (I - n n^T) ddv - dn (n . dv) - n (dn . dv)
// dn is along the obstacle, dn . n = 0.
#ifndef CLOTHID_SIM_DERIVATIVE_CORRECTION_DERIVATIVE_H_
#define CLOTHID_SIM_DERIVATIVE_CORRECTION_DERIVATIVE_H_

#include <Eigen/Core>
#include <vector>

#include "sim/derivative/handle_sweep.h"
#include "sim/derivative/second_start_derivative.h"
#include "sim/obstacle/obstacle_motion.h"
#include "sim/rollout/correction.h"
#include "sim/rollout/step_record.h"
#include "sim/scene/parameters.h"

namespace clothid {

class ClothModel;

// Of one corrected step. Everything must outlive the object.
class CorrectionDerivative {
 public:
  // `record` is the last of `step` and has a correction; `start` [3N]: positions at the start of the step.
  CorrectionDerivative(const Correction& correction, int step, const Eigen::VectorXd& start, const StepRecord& record,
                       const Parameters& parameters, const std::vector<ParameterId>& ids, const ClothModel& model);

  // `tangent` [3 Nf x s] goes from before the correction to after it; its first columns are those of `ids`.
  // `start_changes` and `end_changes` [3N x s]: of the positions at both ends, handles included.
  void Advance(const Eigen::MatrixXd& start_changes, const Eigen::MatrixXd& end_changes, StateColumns* tangent) const;

  // `lambda` [3 Nf x s], gradients by the corrected state, become those by the state before it at fixed A e and B e;
  // through these come `by_start` and `by_end` [3N x s], by the positions at both ends, handles included. Adds to the
  // rows of `ids` in `gradient` what it owes to placements.
  void PullBack(StateColumns* lambda, Eigen::MatrixXd* by_start, Eigen::MatrixXd* by_end,
                Eigen::MatrixXd* gradient) const;

 private:
  struct LimitedNode {
    CorrectionLimit limit;
    SurfacePoint point;
    // Of d and dv; dv only where the node touches the obstacle.
    Eigen::Vector3d change, velocity_change;
    // n_theta [3 x p] and phi_theta [p] of `ids`; empty where none is a placement of the obstacle.
    Eigen::MatrixXd normals;
    Eigen::RowVectorXd distances;

    double held_gap() const { return limit.touches || !limit.is_outside ? 0.0 : point.gap; }
  };

  void SetPlacement(const std::vector<ParameterId>& ids, LimitedNode* node) const;
  void AdvanceNode(const LimitedNode& node, const Eigen::MatrixXd& positions, const Eigen::MatrixXd& velocities,
                   StateColumns* tangent) const;
  // Takes `lambda` through a limit; `positions` and `velocities` [3N x s] are the gradients by d and dv.
  void PullBackNode(const LimitedNode& node, Eigen::MatrixXd* positions, Eigen::MatrixXd* velocities,
                    StateColumns* lambda, Eigen::MatrixXd* gradient) const;

  const Correction& correction_;
  const int step_;
  const StepEnds ends_;
  const StepRecord& record_;
  const Parameters& parameters_;
  const ClothModel& model_;
  std::vector<ObstacleMotion> motions_;  // empty where no obstacle moves
  std::vector<LimitedNode> nodes_;
};

// Takes the tangent of a forward sweep through the corrections of its steps. Does nothing without one.
class CorrectionTangent {
 public:
  // Everything must outlive the object; `correction` may be null.
  CorrectionTangent(const Correction* correction, const Parameters& parameters, const std::vector<ParameterId>& ids,
                    const HandleTangent* handles, const ClothModel& model)
      : correction_(correction), parameters_(parameters), ids_(ids), handles_(handles), model_(model) {}

  // Before the first solve of `step`, which starts at `time` from `positions` [3N].
  void StartStep(int step, double time, const Eigen::VectorXd& positions, const StateColumns& tangent);
  // After the last one, `record`. True: `tangent` is that of the corrected state.
  bool EndStep(int step, const StepRecord& record, StateColumns* tangent) const;

 private:
  Eigen::MatrixXd AllRows(double time, const StateColumns& tangent) const;  // dx [3N x s]

  const Correction* correction_;
  const Parameters& parameters_;
  const std::vector<ParameterId>& ids_;
  const HandleTangent* handles_;
  const ClothModel& model_;
  Eigen::VectorXd start_;          // of the step, where it is corrected
  Eigen::MatrixXd start_changes_;  // [3N x s] likewise
};

}  // namespace clothid

#endif  // CLOTHID_SIM_DERIVATIVE_CORRECTION_DERIVATIVE_H_
