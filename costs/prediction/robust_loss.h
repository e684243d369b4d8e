// Robust losses per observed point.
//
// A `ceres::LossFunction` would act on the residual block, which is a whole recording. Here rho acts on e_p, the
// whitened residual of one point in one frame (up to three coordinates), or of a reading of one group's force:
//   L = 1/2 sum_p rho(|e_p|^2).
// With weights w_p = sqrt(rho'(|e_p|^2)) the rows  w e  with Jacobian  w J  have the gradient of L, and one further row
// sqrt(2 L - |w e|^2) with zero Jacobian gives them its value: rho(s) >= s rho'(s) for a concave rho with rho(0) = 0,
// so the root is real.
//
// Where the model errs (datasets/observation/model_error.h), e_p is divided by its share of the noise: with the weights
// u of the rows, L = 1/2 sum_p rho(|u e_p|^2), and w = u sqrt(rho').
//
// Huber's influence w |e| stays at a for a gross error, and the cost of a linear model convex; Cauchy's falls off as
// a^2/|e|, so what is far away hardly pulls at all, but a start that is far away may end in another minimum.
#ifndef CLOTHID_COSTS_PREDICTION_ROBUST_LOSS_H_
#define CLOTHID_COSTS_PREDICTION_ROBUST_LOSS_H_

#include <Eigen/Core>
#include <string>

#include "costs/assimilation/assimilation.h"
#include "datasets/observation/observation.h"

namespace clothid {

struct RobustLoss {
  enum class Kind {
    kNone,    // rho(s) = s
    kHuber,   // rho(s) = s for s <= a^2, else 2 a sqrt(s) - a^2
    kCauchy,  // rho(s) = a^2 log(1 + s/a^2)
  };
  Kind kind = Kind::kNone;
  double scale = 0.0;  // a, in standard deviations

  bool is_robust() const { return kind != Kind::kNone; }
};

// "none", "huber:A" or "cauchy:A" with A > 0. Throws `Error` (kUsage) otherwise.
RobustLoss ParseRobustLoss(const std::string& text);

// rho'(s) and rho''(s), s = |e_p|^2: what a point may count where recordings correct rollouts.
Influence InfluenceOn(const RobustLoss& loss, double squared);

// For the rows first_row, first_row + 1, .. of the residual, which must be whole points: fills `weights` (of the size
// of `residuals`) with the w of each row and returns the rows' part of L.
double LossWeights(const RobustLoss& loss, const Observation& observation, int first_row,
                   const Eigen::VectorXd& residuals, Eigen::VectorXd* weights);

}  // namespace clothid

#endif  // CLOTHID_COSTS_PREDICTION_ROBUST_LOSS_H_
