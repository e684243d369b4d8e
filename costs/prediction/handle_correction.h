// How far the handles of a recording are off, as offsets to the path of its scene, and their derivatives: the shifts
// and the turn of `Alignment` (alignment.h).
//
//   offset of handle i at a knot t = (R(turn) - I)(path_i(t) - c(t)) + handle_shift + handle_shift of its group
// c(t): the mean of the path of all handles at t. The knots are those of the path, between which offsets then lie as
// the path does; one is enough without a turn. Beside an unknown start, which has offsets of its own, they are the
// knots of those, between which the turn is interpolated.
#ifndef CLOTHID_COSTS_PREDICTION_HANDLE_CORRECTION_H_
#define CLOTHID_COSTS_PREDICTION_HANDLE_CORRECTION_H_

#include <Eigen/Core>
#include <vector>

#include "costs/prediction/alignment.h"
#include "sim/path/handle_path.h"
#include "sim/scene/scene.h"

namespace clothid {

// Handles that stand still have a path, too, as only a path can be corrected.
Scene WithHandlePath(Scene scene);

class HandleCorrection {
 public:
  // Of the H handles of `scene`, which have a path; `groups` [G] of them. `own_knots` s: those of an unknown start;
  // empty: it has no offsets. `turns`: whether there is a turn.
  HandleCorrection(const Scene& scene, std::vector<std::vector<int>> groups, const Eigen::VectorXd& own_knots,
                   bool turns);

  // The offsets at `alignment`, on top of `own` (may be null), those of an unknown start.
  HandlePath OffsetsAt(const Alignment& alignment, const HandlePath* own) const;
  // Their derivatives by `ids`, shifts and turns of handles [3 H K x q], those at the first knot first.
  Eigen::MatrixXd Columns(const Alignment& alignment, const std::vector<ParameterId>& ids) const;

 private:
  bool IsIn(int group, int handle) const;  // kWhole: all are; none is in one that there is not

  std::vector<int> nodes_;  // [H]
  std::vector<std::vector<int>> groups_;
  Eigen::VectorXd knots_;  // [K] s
  Eigen::MatrixXd arms_;   // path_i - c [3H x K] m
};

}  // namespace clothid

#endif  // CLOTHID_COSTS_PREDICTION_HANDLE_CORRECTION_H_
