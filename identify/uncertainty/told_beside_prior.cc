#include "identify/uncertainty/told_beside_prior.h"

#include <algorithm>
#include <cmath>

#include "identify/uncertainty/priors.h"

namespace clothid {

ToldBesidePrior TellBesidePrior(const std::vector<ParameterBlock>& blocks, const Eigen::VectorXd& coordinates,
                                const Eigen::MatrixXd& jacobian, const std::vector<int>& moving, int index,
                                double coordinate_std, double scale, double widening, bool is_visible) {
  const ParameterBlock& block = blocks[index];
  ToldBesidePrior told;
  told.share = coordinate_std / block.PriorStd();
  if (!is_visible) return told;
  const Posterior other(blocks, jacobian, moving, index);
  const auto own = static_cast<Eigen::Index>(std::find(moving.begin(), moving.end(), index) - moving.begin());
  const double inverse_precision = other.jacobian().Covariance(own, own);
  if (!std::isfinite(inverse_precision)) return told;
  told.other_std = widening * std::sqrt(other.Covariance(own, own, scale));
  const double off = coordinates[index] - block.PriorCoordinate();
  const double pull = off * inverse_precision / std::pow(block.PriorStd(), 2);
  told.other_value = block.ToValue(coordinates[index] + pull);
  told.disagreement = std::abs(off + pull) / std::hypot(told.other_std, block.PriorStd());
  return told;
}

}  // namespace clothid
