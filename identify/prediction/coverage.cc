#include "identify/prediction/coverage.h"

#include <algorithm>
#include <numeric>

#include "identify/prediction/bands.h"

namespace clothid {

// Sorted draws but number i are the sorted ones without place i: what lies at places from i on moves up by one.
ByOthers::ByOthers(const Eigen::VectorXd& draws) : held(draws.size()), missed(draws.size()) {
  std::vector<Eigen::Index> order(static_cast<std::size_t>(draws.size()));
  std::iota(order.begin(), order.end(), 0);
  std::sort(order.begin(), order.end(), [&](Eigen::Index a, Eigen::Index b) { return draws[a] < draws[b]; });
  const Eigen::VectorXd sorted = draws(order);
  for (Eigen::Index i = 0; i < draws.size(); ++i) {
    const auto other = [&](Eigen::Index place) { return sorted[place < i ? place : place + 1]; };
    const auto quantile = [&](std::size_t q) {
      const BandRank rank = RankOf(kBandQuantiles[q], draws.size() - 1);
      return Between(other(rank.below), other(rank.above), rank.share);
    };
    const Eigen::Index draw = order[static_cast<std::size_t>(i)];
    held[draw] = quantile(0) <= sorted[i] && sorted[i] <= quantile(4) ? 1.0 : 0.0;
    missed[draw] = sorted[i] - quantile(2);
  }
}

LeaveOneOut::LeaveOneOut(int num_draws) : held_(Eigen::ArrayXd::Zero(num_draws)), squares_(held_), num_(held_) {}

void LeaveOneOut::Add(const ByOthers& said, const std::vector<int>& draws, double unit) {
  for (std::size_t i = 0; i < draws.size(); ++i) {
    const auto at = static_cast<Eigen::Index>(i);
    const double missed = unit * said.missed[at];
    held_[draws[i]] += said.held[at];
    squares_[draws[i]] += missed * missed;
    num_[draws[i]] += 1.0;
  }
}

Eigen::VectorXd LeaveOneOut::Shares() const { return Means(held_); }

Eigen::VectorXd LeaveOneOut::Errors() const { return Means(squares_).cwiseSqrt(); }

Eigen::VectorXd LeaveOneOut::Means(const Eigen::ArrayXd& sums) const {
  Eigen::VectorXd means(num_.size());
  Eigen::Index num_means = 0;
  for (Eigen::Index d = 0; d < num_.size(); ++d) {
    if (num_[d] > 0.0) means[num_means++] = sums[d] / num_[d];
  }
  return means.head(num_means);
}

RightRange RangeOf(const Eigen::VectorXd& numbers) {
  const Eigen::MatrixXd quantiles = BandsOf(numbers.transpose());
  return {quantiles(0, 0), quantiles(0, quantiles.cols() - 1)};
}

}  // namespace clothid
