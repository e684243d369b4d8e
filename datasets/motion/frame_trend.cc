#include "datasets/motion/frame_trend.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <optional>
#include <vector>

#include "sim/base/median.h"
#include "sim/matrix/dense.h"

namespace clothid {
namespace {

constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();

constexpr int kWindows[] = {3, 5, 8};
constexpr double kTrendLossScale = 3.0;  // of the weights, in standard deviations
constexpr double kInlier = 5.0;          // a point further off is none of the trend
constexpr double kInlierShare = 0.75;    // of the points of a trend at least
constexpr double kMostExcess = 2.5;      // the mean variance left over, in sigma^2: sigma may be off
constexpr double kChance = 2.0;          // standard deviations of a sum of squares
constexpr int kReweightings = 5;
constexpr double kVelocityChance = 4.0;  // standard deviations

enum class Trend { kConstant, kFromRest, kLinear, kQuadratic };

// The functions of time [K x b] of the coefficients of a trend: x, then v, then a, each where it has one.
Eigen::MatrixXd Basis(Trend trend, const Eigen::VectorXd& tau) {
  const Eigen::VectorXd ones = Eigen::VectorXd::Ones(tau.size()), squares = tau.cwiseAbs2();
  Eigen::MatrixXd basis = ones;
  const auto add = [&basis](const Eigen::VectorXd& column) {
    basis.conservativeResize(Eigen::NoChange, basis.cols() + 1);
    basis.rightCols(1) = column;
  };
  if (trend == Trend::kLinear || trend == Trend::kQuadratic) add(tau);
  if (trend == Trend::kFromRest || trend == Trend::kQuadratic) add(squares);
  return basis;
}

// One point over the frames in which it is seen.
struct PointTrend {
  Eigen::MatrixXd coefficients;  // [b x 3]
  Eigen::MatrixXd covariance;    // [b x b] for sigma = 1
  int num_seen = 0, num_inliers = 0;
  double squares = 0.0, degrees_of_freedom = 0.0;  // what the inliers leave over, in sigma^2
  double capped_squares = 0.0;                     // of all frames, none more than kInlier^2
};

Eigen::VectorXd Distances(const Eigen::MatrixXd& basis, const Eigen::MatrixXd& seen, double sigma,
                          const Eigen::MatrixXd& coefficients) {
  return (seen - basis * coefficients).rowwise().norm() / sigma;
}

// Through as many frames as there are coefficients, all choices of them: the one that passes nearest to most frames.
Eigen::MatrixXd LeastMedianFit(const Eigen::MatrixXd& basis, const Eigen::MatrixXd& seen) {
  const Eigen::Index count = basis.rows(), size = basis.cols();
  std::vector<char> chosen(static_cast<std::size_t>(count), 0);
  std::fill(chosen.begin(), chosen.begin() + size, 1);
  double least = std::numeric_limits<double>::infinity();
  Eigen::MatrixXd best = Eigen::MatrixXd::Zero(size, 3);
  do {
    std::vector<Eigen::Index> frames;
    for (Eigen::Index i = 0; i < count; ++i) {
      if (chosen[i] != 0) frames.push_back(i);
    }
    const Eigen::MatrixXd own = basis(frames, Eigen::all);
    const Eigen::MatrixXd coefficients =
        SymmetricFactor(own.transpose() * own).Solve(own.transpose() * seen(frames, Eigen::all));
    Eigen::VectorXd distances = Distances(basis, seen, 1.0, coefficients);
    const Eigen::Index middle = (count + size) / 2;
    std::nth_element(distances.begin(), distances.begin() + middle, distances.end());
    if (!(distances[middle] < least)) continue;
    least = distances[middle];
    best = coefficients;
  } while (std::prev_permutation(chosen.begin(), chosen.end()));
  return best;
}

// `all` [K x 3], NaN where not seen.
std::optional<PointTrend> FitPoint(const Eigen::MatrixXd& all_basis, const Eigen::MatrixXd& all, double sigma) {
  std::vector<Eigen::Index> frames;
  for (Eigen::Index i = 0; i < all.rows(); ++i) {
    if (all.row(i).allFinite()) frames.push_back(i);
  }
  const Eigen::MatrixXd basis = all_basis(frames, Eigen::all), seen = all(frames, Eigen::all);
  if (basis.rows() <= basis.cols()) return std::nullopt;
  PointTrend trend;
  trend.num_seen = static_cast<int>(seen.rows());
  trend.coefficients = LeastMedianFit(basis, seen);
  Eigen::VectorXd distances;
  for (int i = 0; i < kReweightings; ++i) {
    distances = Distances(basis, seen, sigma, trend.coefficients);
    const Eigen::VectorXd weights = (1.0 + (distances / kTrendLossScale).array().square()).inverse();
    const SymmetricFactor factor(basis.transpose() * weights.asDiagonal() * basis);
    trend.covariance = factor.Inverse();
    trend.coefficients = factor.Solve(basis.transpose() * weights.asDiagonal() * seen);
  }
  distances = Distances(basis, seen, sigma, trend.coefficients);
  const auto is_inlier = distances.array() < kInlier;
  trend.num_inliers = static_cast<int>(is_inlier.count());
  const double degrees = 3.0 * (trend.num_inliers - static_cast<double>(basis.cols()));
  trend.capped_squares = distances.array().square().min(kInlier * kInlier).sum();
  if (degrees > 0.0) {
    trend.degrees_of_freedom = degrees;
    trend.squares = is_inlier.select(distances.array().square(), 0.0).sum();
  }
  if (!trend.coefficients.allFinite() || !trend.covariance.allFinite()) return std::nullopt;
  return trend;
}

// All points with one trend.
struct Candidate {
  Trend trend = Trend::kConstant;
  int num_frames = 1;
  std::vector<std::optional<PointTrend>> points;
  double degrees_of_freedom = 0.0;
  double capped_squares = 0.0;
  int num_coefficients = 0;                                 // of all points
  double excess = std::numeric_limits<double>::infinity();  // the mean variance left over, in sigma^2
  double variance = 1.0;                                    // of x, the median, in sigma^2
};

Candidate FitCandidate(Trend trend, const Eigen::VectorXd& times, const Eigen::MatrixXd& positions,
                       const Eigen::VectorXd& sigma) {
  Candidate candidate;
  candidate.trend = trend;
  const Eigen::MatrixXd basis = Basis(trend, times.array() - times[0]);
  std::vector<double> variances;
  double squares = 0.0;
  int num_seen = 0, num_inliers = 0;
  for (Eigen::Index p = 0; p < sigma.size(); ++p) {
    const Eigen::MatrixXd path = positions.middleRows<3>(3 * p).transpose();
    const auto& point = candidate.points.emplace_back(FitPoint(basis, path, sigma[p]));
    if (!point) continue;
    num_seen += point->num_seen;
    num_inliers += point->num_inliers;
    candidate.degrees_of_freedom += point->degrees_of_freedom;
    candidate.capped_squares += point->capped_squares;
    candidate.num_coefficients += 3 * static_cast<int>(basis.cols());
    squares += point->squares;
    variances.push_back(point->covariance(0, 0));
  }
  const bool has_enough = candidate.degrees_of_freedom > 0.0 && num_inliers >= kInlierShare * num_seen;
  if (!has_enough) return candidate;
  candidate.excess = squares / candidate.degrees_of_freedom;
  candidate.variance = Median(variances);
  return candidate;
}

// The trends over the first `count` frames, the one that holds the others first; a quadratic needs more than three.
std::vector<Candidate> FitWindow(int count, const Eigen::VectorXd& times, const Eigen::MatrixXd& positions,
                                 const Eigen::VectorXd& sigma) {
  std::vector<Trend> trends = {Trend::kQuadratic, Trend::kLinear, Trend::kFromRest, Trend::kConstant};
  if (count == 3) trends = {Trend::kLinear, Trend::kConstant};
  std::vector<Candidate> candidates;
  for (const Trend trend : trends) {
    candidates.push_back(FitCandidate(trend, times.head(count), positions.leftCols(count), sigma));
    candidates.back().num_frames = count;
  }
  return candidates;
}

// Whether the trend leaves no more over than `widest`, which holds it, does with its further coefficients: what these
// take away is chi-square of their number.
bool IsAsGood(const Candidate& candidate, const Candidate& widest) {
  const double further = widest.num_coefficients - candidate.num_coefficients;
  const double gain = candidate.capped_squares - widest.capped_squares;
  return std::isfinite(candidate.excess) &&
         gain <= widest.excess * (further + kChance * std::sqrt(2.0 * std::max(0.0, further)));
}

// The first frame alone.
FrameTrend FirstFrame(const Eigen::MatrixXd& positions, const Eigen::VectorXd& sigma) {
  FrameTrend trend;
  trend.positions = positions.col(0).reshaped(3, sigma.size());
  trend.position_variances = sigma.cwiseAbs2();
  return trend;
}

void SetVelocities(const Candidate& candidate, const Eigen::VectorXd& sigma, FrameTrend* result) {
  if (candidate.trend != Trend::kLinear && candidate.trend != Trend::kQuadratic) return;
  Eigen::MatrixXd velocities = Eigen::MatrixXd::Constant(3, sigma.size(), kUnknown);
  Eigen::VectorXd variances = Eigen::VectorXd::Ones(sigma.size());
  double squares = 0.0, count = 0.0;
  for (Eigen::Index p = 0; p < sigma.size(); ++p) {
    const auto& point = candidate.points[p];
    if (!point) continue;
    velocities.col(p) = point->coefficients.row(1);
    variances[p] = sigma[p] * sigma[p] * point->covariance(1, 1);
    squares += velocities.col(p).squaredNorm() / variances[p];
    count += 3.0;
  }
  if (!(squares > count + kVelocityChance * std::sqrt(2.0 * count))) return;
  result->velocities = velocities;
  result->velocity_variances = variances;
}

}  // namespace

FrameTrend FitFrameTrend(const Eigen::VectorXd& times, const Eigen::MatrixXd& positions, const Eigen::VectorXd& sigma) {
  FrameTrend result = FirstFrame(positions, sigma);
  std::vector<std::vector<Candidate>> windows;
  double least_excess = kMostExcess;
  for (const int window : kWindows) {
    if (window > times.size()) break;
    windows.push_back(FitWindow(window, times, positions, sigma));
    least_excess = std::min(least_excess, windows.back().front().excess);
  }
  Candidate best;
  for (const std::vector<Candidate>& window : windows) {
    const Candidate& widest = window.front();
    const double chance = kChance * std::sqrt(2.0 / widest.degrees_of_freedom);
    if (!(widest.excess < std::min(kMostExcess, least_excess * (1.0 + chance)))) continue;
    for (const Candidate& candidate : window) {
      if (IsAsGood(candidate, widest) && candidate.variance < best.variance) best = candidate;
    }
  }
  if (best.points.empty()) return result;
  result.num_frames = best.num_frames;
  for (Eigen::Index p = 0; p < sigma.size(); ++p) {
    const auto& point = best.points[p];
    if (!point) continue;
    result.positions.col(p) = point->coefficients.row(0);
    result.position_variances[p] = sigma[p] * sigma[p] * point->covariance(0, 0);
  }
  SetVelocities(best, sigma, &result);
  return result;
}

}  // namespace clothid
