// The priors of parameters (`ParameterBlock::prior`) as residuals r_i = (q_i - centre_i)/std_i, and what they and the
// measurements together say.
//
// H = J^T J + L^T L + P,  P = diag(1/std^2), zero where there is no prior;  J [r x p] the whitened Jacobian of the
// measurements, L q the residuals (q_i - q_j)/std of blocks that are linked (`ParameterBlock::linked_to`): a profile
// over time is believed to be smooth. How smooth is told relative to the measurements, as the weight of the smoothness
// of a field is: where residuals have the standard deviation s, so have those of L.
#ifndef CLOTHID_IDENTIFY_UNCERTAINTY_PRIORS_H_
#define CLOTHID_IDENTIFY_UNCERTAINTY_PRIORS_H_

#include <Eigen/Core>
#include <vector>

#include "costs/prediction/parameter_block.h"
#include "identify/uncertainty/scaled_jacobian.h"

namespace clothid {

bool HasPriors(const std::vector<ParameterBlock>& blocks);  // links are none
bool HasLinks(const std::vector<ParameterBlock>& blocks);
bool IsKnot(const std::vector<ParameterBlock>& blocks, int index);  // at an end of a link

// The diagonal of P [p]; L, a row for every link; and P + L^T L [p x p].
Eigen::VectorXd PriorPrecisions(const std::vector<ParameterBlock>& blocks);
Eigen::MatrixXd LinkRows(const std::vector<ParameterBlock>& blocks);
Eigen::MatrixXd PriorHessian(const std::vector<ParameterBlock>& blocks);
// The residuals of priors and links, over frozen parameters, too, at `coordinates`, whose first p count, and their
// derivative [rows x p].
Eigen::VectorXd PriorResiduals(const std::vector<ParameterBlock>& blocks, const Eigen::VectorXd& coordinates);
Eigen::MatrixXd PriorRows(const std::vector<ParameterBlock>& blocks);
// Half the sum of their squares, and its gradient [p].
double PriorCost(const std::vector<ParameterBlock>& blocks, const Eigen::VectorXd& coordinates);
Eigen::VectorXd PriorGradient(const std::vector<ParameterBlock>& blocks, const Eigen::VectorXd& coordinates);

inline constexpr int kEveryPrior = -1;

// `jacobian` [r x p], or [r x (p + n)] with other unknowns behind, and below it `scale` times a row for every prior,
// and a row for every link, but for the prior of block `left_out`.
Eigen::MatrixXd WithPriorRows(const std::vector<ParameterBlock>& blocks, const Eigen::MatrixXd& jacobian, double scale,
                              int left_out = kEveryPrior);

// What moves the prediction, as `ScaledJacobian::VisibleChange` of `jacobian`, made with all rows of the above, but
// without the links of its block i: with H_o = H - U^T U, U the rows of these links,
//   H_o^-1 = H^-1 + H^-1 U^T (I - U H^-1 U^T)^-1 U H^-1.
double VisibleWithoutLinks(const std::vector<ParameterBlock>& blocks, const ScaledJacobian& jacobian, Eigen::Index i);

// H over the blocks `indices` [k], in whose order the numbers below count, without the prior of block `left_out`.
class Posterior {
 public:
  Posterior(const std::vector<ParameterBlock>& blocks, const Eigen::MatrixXd& jacobian, std::vector<int> indices,
            int left_out = kEveryPrior);

  const ScaledJacobian& jacobian() const { return jacobian_; }  // its (J^T J)^-1 is H^-1
  // H^-1 P H^-1 and H^-1 L^T L H^-1 at (i, j), and the covariance H^-1 (s^2 (J^T J + L^T L) + P) H^-1 of the estimate
  // where the residuals of the measurements have the standard deviation s: s^2 H^-1 + (1 - s^2) H^-1 P H^-1.
  double PriorPart(Eigen::Index i, Eigen::Index j) const;
  double LinkPart(Eigen::Index i, Eigen::Index j) const;
  double Covariance(Eigen::Index i, Eigen::Index j, double scale) const;

 private:
  ScaledJacobian jacobian_;
  Eigen::VectorXd precisions_;       // [k]
  Eigen::MatrixXd link_influences_;  // H^-1 L^T [k x links]
};

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_UNCERTAINTY_PRIORS_H_
