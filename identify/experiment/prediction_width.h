// How wide the prediction of another motion would be by what a recording tells: a plan with a prediction in place of a
// parameter.
//
// With the coordinates q of the parameters and P [R x p], the derivatives by q of the places of the free nodes after
// every step of the motion that is predicted, of the nominal cloth,
//   width^2 = trace(C P^T P)/R,   C = (J^T J + B^-2)^-1 + diag(e^2):
// the root mean square of the standard deviations of its coordinates, to first order. J are the rows of a recording
// with everything else eliminated (identify/experiment/cloth_information.h), B what was believed before, the priors or
// the ranges between bounds, e the error of the time step. The mean is over the squares of all cloths. What a recording
// does not have, or has for itself alone, is known as well as it was believed. What no parameter spreads (start,
// missing force, step and mesh of the predicted scene) is the same whatever is recorded, and no part of it.
#ifndef CLOTHID_IDENTIFY_EXPERIMENT_PREDICTION_WIDTH_H_
#define CLOTHID_IDENTIFY_EXPERIMENT_PREDICTION_WIDTH_H_

#include <Eigen/Core>
#include <string>
#include <vector>

#include "identify/experiment/candidate.h"
#include "identify/experiment/expectation.h"

namespace clothid {

class MotionToPredict {
 public:
  // One forward sweep of `predicted` (`ReadPredicted`). Throws `Error` (kBadData) where it cannot be simulated, and
  // where it has none of the parameters.
  explicit MotionToPredict(const Candidate& predicted);

  const std::string& name() const { return name_; }
  // m, of cloths of a recording, or of two; `step_errors` [p] of q of its blocks, NaN where not known.
  double Width(const std::vector<ClothRows>& cloths, const Eigen::VectorXd& step_errors) const;
  // m, by what is believed alone.
  double BelievedWidth() const;

 private:
  // C of the blocks here, by a recorded cloth.
  Eigen::MatrixXd Covariance(const ClothRows& cloth, const Eigen::VectorXd& step_errors) const;

  std::string name_;
  std::vector<ParameterBlock> blocks_;  // [p]
  Eigen::MatrixXd gram_;                // P^T P/R [p x p] m^2
};

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_EXPERIMENT_PREDICTION_WIDTH_H_
