// The weights of what is believed to be smooth, chosen anew at a step of a fit.
#ifndef CLOTHID_IDENTIFY_PROBLEM_WEIGHT_CHOICE_H_
#define CLOTHID_IDENTIFY_PROBLEM_WEIGHT_CHOICE_H_

#include <Eigen/Core>

#include "identify/problem/problem.h"
#include "identify/problem/unknown_basis.h"

namespace clothid {

struct WeightChoice {
  bool is_steady = true;        // the weights are where they are to stay
  double num_determined = 0.0;  // effective number of differences that the measurements determine, of all priors
};

// Sets those weights of `problem` that are to be chosen as identify/uncertainty/smoothness.h has them, over the basis
// of `known`, whose gradient and |e|^2 are those at `coordinates` [p + n + f]. A weight falls to a tenth at the least;
// one that was not chosen yet becomes the largest, since the roughness of what was never fitted tells nothing.
WeightChoice ChooseWeights(const BasisLinearization& known, const Eigen::VectorXd& coordinates, FitProblem* problem);

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_PROBLEM_WEIGHT_CHOICE_H_
