// Spearman's rank correlation: does one quantity grow with another, in whatever way?
#ifndef CLOTHID_TOOLS_BENCHMARK_FITS_RANK_CORRELATION_H_
#define CLOTHID_TOOLS_BENCHMARK_FITS_RANK_CORRELATION_H_

#include <limits>
#include <vector>

namespace clothid {

// Up to so many pairs the p-value is exact.
inline constexpr int kMaxExactPairs = 9;

struct RankCorrelation {
  // Pearson's correlation of the ranks, in [-1, 1]. NaN for fewer than three pairs and where all of one side are equal.
  double rho = std::numeric_limits<double>::quiet_NaN();
  // Two-sided: the chance of so large a |rho| where the pairing means nothing. NaN where rho is.
  double p_value = std::numeric_limits<double>::quiet_NaN();
};

// 1 for the smallest value; equal values share the mean of their ranks.
std::vector<double> AverageRanks(const std::vector<double>& values);

// Of the pairs (x_i, y_i), n of them, all finite; throws `std::invalid_argument` otherwise. The p-value is, for
// n <= kMaxExactPairs, the share of the n! orders of y with a |rho| at least as large; beyond, that of Student's t with
// n - 2 degrees of freedom at t = rho sqrt((n - 2)/(1 - rho^2)), at least 2/n!, the least that n! orders can give.
RankCorrelation SpearmanCorrelation(const std::vector<double>& x, const std::vector<double>& y);

}  // namespace clothid

#endif  // CLOTHID_TOOLS_BENCHMARK_FITS_RANK_CORRELATION_H_
