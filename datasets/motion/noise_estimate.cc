#include "datasets/motion/noise_estimate.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <vector>

#include "sim/base/median.h"

namespace clothid {
namespace {

// Median |d| of a normal distribution to its standard deviation.
constexpr double kNormalMedian = 1.4826022185056018;

constexpr double kOutlier = 5.0;  // standard deviations

constexpr double kNoEstimate = std::numeric_limits<double>::quiet_NaN();

// 1.4826 median |d| of those below kOutlier times what all of them give: a jump spoils the differences of its
// neighbours, too, so few jumps spoil many differences.
double Spread(const std::vector<double>& differences) {
  const double first = kNormalMedian * Median(differences);
  std::vector<double> near;
  std::copy_if(differences.begin(), differences.end(), std::back_inserter(near),
               [first](double difference) { return difference <= kOutlier * first; });
  return near.empty() ? first : kNormalMedian * Median(near);
}

// d at the seen frame `i` from `reach` neighbours on either side; both vectors without gaps.
double Difference(const std::vector<double>& times, const std::vector<double>& values, std::size_t i,
                  std::size_t reach) {
  double difference = values[i], squares = 1.0;
  for (std::size_t k = i - reach; k <= i + reach; ++k) {
    if (k == i) continue;
    double weight = 1.0;
    for (std::size_t l = i - reach; l <= i + reach; ++l) {
      if (l != i && l != k) weight *= (times[i] - times[l]) / (times[k] - times[l]);
    }
    difference -= weight * values[k];
    squares += weight * weight;
  }
  return difference / std::sqrt(squares);
}

// |d| of one coordinate.
std::vector<double> Differences(const Eigen::VectorXd& times, const Eigen::VectorXd& values, std::size_t reach) {
  std::vector<double> seen_times, seen;
  for (Eigen::Index i = 0; i < times.size(); ++i) {
    if (!std::isfinite(values[i])) continue;
    seen_times.push_back(times[i]);
    seen.push_back(values[i]);
  }
  std::vector<double> differences;
  for (std::size_t i = reach; i + reach < seen.size(); ++i) {
    differences.push_back(std::abs(Difference(seen_times, seen, i, reach)));
  }
  return differences;
}

struct Estimate {
  Eigen::VectorXd variances;    // [P]; NaN: too few differences
  double pooled = kNoEstimate;  // of all points
};

Estimate EstimateWith(const Eigen::VectorXd& times, const Eigen::MatrixXd& positions, std::size_t reach) {
  const Eigen::Index num_points = positions.rows() / 3;
  Estimate estimate;
  estimate.variances = Eigen::VectorXd::Constant(num_points, kNoEstimate);
  std::vector<double> all[3];
  for (Eigen::Index p = 0; p < num_points; ++p) {
    double sum = 0.0;
    for (int axis = 0; axis < 3; ++axis) {
      std::vector<double> differences = Differences(times, positions.row(3 * p + axis).transpose(), reach);
      all[axis].insert(all[axis].end(), differences.begin(), differences.end());
      sum += differences.size() < kFewestDifferences ? kNoEstimate : std::pow(Spread(differences), 2);
    }
    estimate.variances[p] = sum / 3.0;
  }
  double sum = 0.0;
  for (std::vector<double>& axis : all) sum += axis.empty() ? kNoEstimate : std::pow(Spread(axis), 2);
  estimate.pooled = sum / 3.0;
  return estimate;
}

}  // namespace

Eigen::VectorXd EstimateSigma(const Eigen::VectorXd& times, const Eigen::MatrixXd& positions, double least) {
  Estimate best = EstimateWith(times, positions, 1);
  const Estimate cubic = EstimateWith(times, positions, 2);
  if (cubic.pooled < best.pooled) best = cubic;
  if (std::isnan(best.pooled)) return {};
  for (double& variance : best.variances) {
    if (std::isnan(variance)) variance = best.pooled;
  }
  return best.variances.cwiseSqrt().cwiseMax(least);
}

}  // namespace clothid
