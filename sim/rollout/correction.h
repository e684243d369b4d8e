// Corrections of the state between steps: what a measurement says where the rollout has come to.
//
// At the end of some steps, after x_n and v_n were found,
//   x_n <- x_n + C(A e),   v_n <- v_n + C(B e),   e = y - P x,
// with e, A and B the business of whoever gives the correction (`Correction`): sim sees a change of the state that
// follows from the positions at the start and at the end of the step, and its derivatives. C is what contacts leave of
// that change, so that a correction neither opens nor closes any:
//   - A node that touches an obstacle moves along it: of d stays (I - n n^T) d, of the change of its velocity likewise,
//     with n of the obstacle at the corrected node's place before the correction.
//   - A node that does not, moves as far as the obstacle: where n . d < -phi, phi its gap, of d stays
//     (I - n n^T) d - max(phi, 0) n.
//   - Nodes of the cloth that touch each other, directly or by way of others, move together: by the mean of their
//     changes, or not at all where one of them touches an obstacle or is held.
// Handles stay on their path. A cloth that would cut itself through a correction gets half of A e and B e, a quarter,
// an eighth, or nothing.
#ifndef CLOTHID_SIM_ROLLOUT_CORRECTION_H_
#define CLOTHID_SIM_ROLLOUT_CORRECTION_H_

#include <Eigen/Core>
#include <vector>

#include "sim/obstacle/affine_motion.h"
#include "sim/obstacle/obstacle_motion.h"
#include "sim/scene/parameters.h"
#include "sim/step/stage.h"

namespace clothid {

class ClothModel;
struct StepRecord;

// Positions, or their changes in columns, at both ends of a step.
struct StepEnds {
  const Eigen::VectorXd& start;  // x_{n-1} [3N] m, corrected where that step was
  const Eigen::VectorXd& end;    // x_n [3N] m, before the correction
};

// Const functions must not depend on what was asked before, and may be called on several threads at once. Steps are
// counted from 1. Rows of handles are ignored.
class Correction {
 public:
  virtual ~Correction() = default;

  // Whether the end of `step` is corrected.
  virtual bool Corrects(int step) const = 0;
  // A e [3N] m and B e [3N] m/s.
  virtual void Evaluate(int step, const StepEnds& ends, Eigen::VectorXd* positions,
                        Eigen::VectorXd* velocities) const = 0;
  // Their changes [3N x s] along changes of x_{n-1} and of x_n [3N x s], handles included.
  virtual void Times(int step, const StepEnds& ends, const Eigen::MatrixXd& start_changes,
                     const Eigen::MatrixXd& end_changes, Eigen::MatrixXd* positions,
                     Eigen::MatrixXd* velocities) const = 0;
  // Of scalars with gradients `by_positions` and `by_velocities` [3N x s] by A e and B e: those by x_{n-1} and x_n
  // [3N x s], handles included.
  virtual void TimesTransposed(int step, const StepEnds& ends, const Eigen::MatrixXd& by_positions,
                               const Eigen::MatrixXd& by_velocities, Eigen::MatrixXd* by_start,
                               Eigen::MatrixXd* by_end) const = 0;
};

// A node whose change an obstacle limits.
struct CorrectionLimit {
  int node = 0;
  int obstacle = 0;
  bool touches = false;  // it is in contact; else it moves as far as the obstacle, if it is outside of it
  bool is_outside = false;
};

// Nodes that touch each other.
struct CorrectionGroup {
  std::vector<int> nodes;
  bool moves = true;
};

// The state after a correction, and what its derivative needs.
struct CorrectedState {
  Eigen::VectorXd positions, velocities;  // [3N] m, m/s
  double scale = 1.0;                     // of A e and B e
  std::vector<CorrectionLimit> limits;    // ascending
  std::vector<CorrectionGroup> groups;
};

// A e and B e of a step, times `scale`: zero at handles, and the same for the nodes of a group.
struct StateChange {
  Eigen::VectorXd positions, velocities;  // [3N] m, m/s
};
StateChange RequestedChange(const Correction& correction, int step, const StepEnds& ends, const ClothModel& model,
                            double scale, const std::vector<CorrectionGroup>& groups);

// Columns [3N x s] likewise: the mean over the nodes of each group, or zero. It is its own transpose.
void MoveTogether(const std::vector<CorrectionGroup>& groups, Eigen::Ref<Eigen::MatrixXd> columns);

// Of a solve that starts when `record` ends: it finds obstacles (ObstacleMotions) where corrections do.
SolveTimes TimesAfter(const StepRecord& record);
// The point of obstacle `index` that is closest to `position`; its gap counts from the contact distance. `motions`: of
// the obstacles; empty where none moves.
SurfacePoint ClosestOf(const ClothModel& model, const std::vector<ObstacleMotion>& motions, int index,
                       const Eigen::Vector3d& position);

// The state that `record`, the last of `step`, has, corrected with `scale`. `start`: positions [3N] at the start of the
// step.
CorrectedState CorrectState(const Correction& correction, int step, const Eigen::VectorXd& start,
                            const StepRecord& record, const Parameters& parameters, const ClothModel& model,
                            double scale);

}  // namespace clothid

#endif  // CLOTHID_SIM_ROLLOUT_CORRECTION_H_
