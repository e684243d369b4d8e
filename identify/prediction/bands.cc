#include "identify/prediction/bands.h"

#include <algorithm>
#include <vector>

namespace clothid {

Eigen::MatrixXd BandsOf(const Eigen::MatrixXd& draws) {
  const Eigen::Index num_draws = draws.cols();
  Eigen::MatrixXd bands(draws.rows(), static_cast<Eigen::Index>(kBandQuantiles.size()));
  std::vector<double> sorted(static_cast<std::size_t>(num_draws));
  for (Eigen::Index row = 0; row < draws.rows(); ++row) {
    for (Eigen::Index d = 0; d < num_draws; ++d) sorted[static_cast<std::size_t>(d)] = draws(row, d);
    std::sort(sorted.begin(), sorted.end());
    for (std::size_t q = 0; q < kBandQuantiles.size(); ++q) {
      const double rank = std::clamp(kBandQuantiles[q] * static_cast<double>(num_draws + 1) - 1.0, 0.0,
                                     static_cast<double>(num_draws - 1));
      const auto below = static_cast<std::size_t>(rank);
      const double above = sorted[std::min(below + 1, sorted.size() - 1)];
      const double share = rank - static_cast<double>(below);
      bands(row, static_cast<Eigen::Index>(q)) =
          share == 0.0 || above == sorted[below] ? sorted[below] : sorted[below] + share * (above - sorted[below]);
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
