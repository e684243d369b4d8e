#include "identify/prediction/bands.h"

#include <algorithm>

namespace clothid {

BandRank RankOf(double quantile, Eigen::Index num_draws) {
  const double rank =
      std::clamp(quantile * static_cast<double>(num_draws + 1) - 1.0, 0.0, static_cast<double>(num_draws - 1));
  const auto below = static_cast<Eigen::Index>(rank);
  return {below, std::min(below + 1, num_draws - 1), rank - static_cast<double>(below)};
}

double Between(double below, double above, double share) {
  return share == 0.0 || above == below ? below : below + share * (above - below);
}

Eigen::MatrixXd BandsOf(const Eigen::MatrixXd& draws) {
  Eigen::MatrixXd bands(draws.rows(), static_cast<Eigen::Index>(kBandQuantiles.size()));
  for (Eigen::Index row = 0; row < draws.rows(); ++row) {
    Eigen::VectorXd sorted = draws.row(row).transpose();
    std::sort(sorted.begin(), sorted.end());
    for (std::size_t q = 0; q < kBandQuantiles.size(); ++q) {
      const BandRank rank = RankOf(kBandQuantiles[q], draws.cols());
      bands(row, static_cast<Eigen::Index>(q)) = Between(sorted[rank.below], sorted[rank.above], rank.share);
    }
  }
  return bands;
}

// In increasing order x_i is subtracted D - 1 - i times from a larger one and i times has a smaller one subtracted.
double RankedScore(const Eigen::VectorXd& draws, double seen) {
  Eigen::VectorXd sorted = draws;
  std::sort(sorted.begin(), sorted.end());
  const auto num_draws = static_cast<double>(sorted.size());
  double apart = 0.0;
  for (Eigen::Index i = 0; i < sorted.size(); ++i)
    apart += (2.0 * static_cast<double>(i) + 1.0 - num_draws) * sorted[i];
  return (draws.array() - seen).abs().mean() - apart / (num_draws * num_draws);
}

}  // namespace clothid
