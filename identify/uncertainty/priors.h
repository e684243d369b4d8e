// The priors of parameters (`ParameterBlock::prior`) as residuals r_i = (q_i - centre_i)/std_i, and what they and the
// measurements together say.
//
// H = J^T J + P,  P = diag(1/std^2), zero where there is no prior;  J [r x p] the whitened Jacobian of the
// measurements.
#ifndef CLOTHID_IDENTIFY_UNCERTAINTY_PRIORS_H_
#define CLOTHID_IDENTIFY_UNCERTAINTY_PRIORS_H_

#include <Eigen/Core>
#include <vector>

#include "costs/prediction/parameter_block.h"
#include "identify/uncertainty/scaled_jacobian.h"

namespace clothid {

bool HasPriors(const std::vector<ParameterBlock>& blocks);

// The diagonal of P [p].
Eigen::VectorXd PriorPrecisions(const std::vector<ParameterBlock>& blocks);
// Of L = 1/2 sum r_i^2, over frozen parameters, too, at `coordinates`, whose first p count: L and dL/dq [p].
double PriorCost(const std::vector<ParameterBlock>& blocks, const Eigen::VectorXd& coordinates);
Eigen::VectorXd PriorGradient(const std::vector<ParameterBlock>& blocks, const Eigen::VectorXd& coordinates);

inline constexpr int kEveryPrior = -1;

// `jacobian` [r x p] and below it `scale` times a row for every prior, but for that of block `left_out`.
Eigen::MatrixXd WithPriorRows(const std::vector<ParameterBlock>& blocks, const Eigen::MatrixXd& jacobian, double scale,
                              int left_out = kEveryPrior);

// H over the blocks `indices` [k], in whose order the numbers below count, without the prior of block `left_out`.
class Posterior {
 public:
  Posterior(const std::vector<ParameterBlock>& blocks, const Eigen::MatrixXd& jacobian, std::vector<int> indices,
            int left_out = kEveryPrior);

  const ScaledJacobian& jacobian() const { return jacobian_; }  // its (J^T J)^-1 is H^-1
  // H^-1 P H^-1 at (i, j), and the covariance H^-1 (s^2 J^T J + P) H^-1 of the estimate where the residuals of the
  // measurements have the standard deviation s: s^2 H^-1 + (1 - s^2) H^-1 P H^-1.
  double PriorPart(Eigen::Index i, Eigen::Index j) const;
  double Covariance(Eigen::Index i, Eigen::Index j, double scale) const;

 private:
  ScaledJacobian jacobian_;
  Eigen::VectorXd precisions_;  // [k]
};

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_UNCERTAINTY_PRIORS_H_
