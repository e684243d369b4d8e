// The acceleration that a solve may have, from those of the solves before it: what Newton's method starts from.
//
// The two solves of an SDIRK2 step each resemble that of the step before, more than they resemble one another, so each
// stage has a past of its own. Three guesses compete: no acceleration, the last one, and the line through the last two,
// which in smooth motion is nearer by orders of magnitude and in rough motion farther. The one that would have been
// the best for the last solve is made for the next.
#ifndef CLOTHID_SIM_STEP_PAST_ACCELERATIONS_H_
#define CLOTHID_SIM_STEP_PAST_ACCELERATIONS_H_

#include <Eigen/Core>
#include <array>

#include "sim/step/stage.h"

namespace clothid {

class PastAccelerations {
 public:
  void Clear();
  // Of a solve of `stage` [3 Nf] m/s^2.
  void Add(Stage stage, Eigen::VectorXd acceleration);
  // For a solve of `stage`; empty: none is likely to be better than no acceleration. Before there was a solve of that
  // stage, the acceleration of the last one.
  Eigen::VectorXd Guess(Stage stage) const;

 private:
  enum class Kind { kNone, kLast, kLine };
  struct Past {
    Eigen::VectorXd last, before;  // empty: none
    Kind guess = Kind::kLast;
  };
  std::array<Past, 3> pasts_;  // by stage
  Stage last_stage_ = Stage::kOnly;
};

}  // namespace clothid

#endif  // CLOTHID_SIM_STEP_PAST_ACCELERATIONS_H_
