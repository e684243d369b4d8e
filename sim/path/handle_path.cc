#include "sim/path/handle_path.h"

#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>
#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "sim/base/row_error.h"
#include "sim/path/hermite.h"

namespace clothid {
namespace {

[[noreturn]] void FailOnPath(const std::string& message) {
  throw Error(ErrorKind::kBadData, "handle path: " + message);
}
[[noreturn]] void FailOnKnot(Eigen::Index knot, const std::string& message) {
  throw RowError(knot, "handle path: " + message);
}

void ValidateKnots(const Eigen::VectorXd& times, const Eigen::MatrixXd& positions) {
  if (times.size() == 0 || positions.cols() != times.size() || positions.rows() % 3 != 0) {
    FailOnPath("expected one position of every handle at each of " + std::to_string(times.size()) + " times");
  }
  for (Eigen::Index i = 0; i < times.size(); ++i) {
    if (!std::isfinite(times[i]) || (i > 0 && !(times[i] > times[i - 1]))) {
      FailOnKnot(i, "time " + std::to_string(i) + " is not a finite number above the time before it");
    }
    if (!positions.col(i).allFinite()) FailOnKnot(i, "the position at time " + std::to_string(i) + " is not finite");
  }
}

}  // namespace

HandlePath::HandlePath(const Eigen::VectorXd& times, const Eigen::MatrixXd& positions)
    : times_(times), positions_(positions) {
  ValidateKnots(times_, positions_);
  slopes_ = ParabolaSlopes(times_, positions_);
  if (!slopes_.allFinite()) FailOnPath("expected velocities that are finite numbers");
}

Eigen::VectorXd HandlePath::At(double time) const { return HermiteValue(times_, positions_, slopes_, time); }

// Slopes are linear in positions, and so is what lies between two knots.
Eigen::VectorXd HandlePath::RateAt(double time) const { return HermiteRate(times_, positions_, slopes_, time); }

Eigen::VectorXd HandlePath::KnotWeights(double time) const {
  // The two knots around it, and those that their slopes depend on.
  const Eigen::Index next = std::upper_bound(times_.begin(), times_.end(), time) - times_.begin();
  const Eigen::Index first = std::clamp<Eigen::Index>(next - 2, 0, std::max<Eigen::Index>(times_.size() - 3, 0));
  const Eigen::Index count = std::min<Eigen::Index>(std::max<Eigen::Index>(next + 2, 3), times_.size()) - first;
  const Eigen::VectorXd times = times_.segment(first, count);
  const Eigen::MatrixXd knots = Eigen::MatrixXd::Identity(count, count);
  Eigen::VectorXd weights = Eigen::VectorXd::Zero(times_.size());
  weights.segment(first, count) = HermiteValue(times, knots, ParabolaSlopes(times, knots), time);
  return weights;
}

// The natural cubic smoothing spline in Reinsch's form (Green and Silverman, Nonparametric Regression and Generalized
// Linear Models, 1994, section 2.3). With second differences Q [T x T-2] and their Gram matrix R [T-2 x T-2], which is
// the curvature's, the spline of weight lambda through y is
//   g = y - lambda Q gamma,   (R + lambda Q^T Q) gamma = Q^T y,
// and the trace of what it leaves over, tr(I - A) = lambda tr((R + lambda Q^T Q)^-1 Q^T Q), needs the five middle
// diagonals of the inverse alone (Hutchinson and de Hoog 1985).
namespace {

using SparseMatrix = Eigen::SparseMatrix<double>;

constexpr Eigen::Index kMinTimes = 5;

// Range of log10(lambda), with time in mean frame intervals: a wave of angular frequency w per frame is damped by
// 1/(1 + lambda w^4). The lower end leaves even the shortest wave (w = pi) within 1 %, the upper one damps waves of
// more than 600 frames.
constexpr double kMinLogWeight = -4.0;
constexpr double kMaxLogWeight = 8.0;
constexpr double kScanStep = 0.5;          // of log10(lambda): cross-validation may have several minima
constexpr double kWeightTolerance = 1e-2;  // of log10(lambda)

class SmoothingSpline {
 public:
  // times [T] in frame intervals, values [T].
  SmoothingSpline(const Eigen::VectorXd& times, const Eigen::VectorXd& values)
      : size_(times.size()), second_differences_(size_, size_ - 2), gram_(size_ - 2, size_ - 2) {
    std::vector<Eigen::Triplet<double>> differences, gram;
    for (Eigen::Index j = 0; j + 2 < size_; ++j) {
      const double before = times[j + 1] - times[j];
      const double after = times[j + 2] - times[j + 1];
      differences.emplace_back(j, j, 1.0 / before);
      differences.emplace_back(j + 1, j, -1.0 / before - 1.0 / after);
      differences.emplace_back(j + 2, j, 1.0 / after);
      gram.emplace_back(j, j, (before + after) / 3.0);
      if (j + 3 < size_) {
        gram.emplace_back(j + 1, j, after / 6.0);
        gram.emplace_back(j, j + 1, after / 6.0);
      }
    }
    second_differences_.setFromTriplets(differences.begin(), differences.end());
    gram_.setFromTriplets(gram.begin(), gram.end());
    penalty_ = second_differences_.transpose() * second_differences_;
    curvature_ = second_differences_.transpose() * values;
  }

  // What the spline of weight `weight` takes off the values [T].
  Eigen::VectorXd Residual(double weight) const { return Residual(weight, Factor(gram_ + weight * penalty_)); }

  // T |residual|^2 / tr(I - A)^2.
  double CrossValidation(double weight) const {
    const Factor factor(gram_ + weight * penalty_);
    const double trace = weight * InverseTrace(factor);
    return static_cast<double>(size_) * Residual(weight, factor).squaredNorm() / (trace * trace);
  }

 private:
  using Factor = Eigen::SimplicialLDLT<SparseMatrix, Eigen::Lower, Eigen::NaturalOrdering<int>>;

  Eigen::VectorXd Residual(double weight, const Factor& factor) const {
    return weight * (second_differences_ * factor.solve(curvature_));
  }

  // tr(B^-1 Q^T Q) from B = L D L^T: the entries of the inverse within the band, from the last row up.
  double InverseTrace(const Factor& factor) const {
    const SparseMatrix lower = factor.matrixL().nestedExpression();
    const Eigen::VectorXd pivots = factor.vectorD();
    const Eigen::Index rows = size_ - 2;
    const auto entry = [&](const SparseMatrix& matrix, Eigen::Index i, Eigen::Index j) {
      return i < rows ? matrix.coeff(i, j) : 0.0;
    };
    double trace = 0.0;
    double diagonal1 = 0.0, diagonal2 = 0.0, side1 = 0.0;  // S(i+1, i+1), S(i+2, i+2), S(i+1, i+2)
    for (Eigen::Index i = rows - 1; i >= 0; --i) {
      const double l1 = entry(lower, i + 1, i), l2 = entry(lower, i + 2, i);
      const double next = -l1 * diagonal1 - l2 * side1;
      const double after_next = -l1 * side1 - l2 * diagonal2;
      const double diagonal = 1.0 / pivots[i] - l1 * next - l2 * after_next;
      trace += diagonal * penalty_.coeff(i, i) +
               2.0 * (next * entry(penalty_, i + 1, i) + after_next * entry(penalty_, i + 2, i));
      diagonal2 = diagonal1;
      diagonal1 = diagonal;
      side1 = next;
    }
    return trace;
  }

  Eigen::Index size_;
  SparseMatrix second_differences_, gram_, penalty_;
  Eigen::VectorXd curvature_;
};

// Minimum of `f` between `low` and `high` by golden sections.
template <typename Function>
double GoldenSection(const Function& f, double low, double high) {
  const double ratio = 0.5 * (std::sqrt(5.0) - 1.0);
  double left = high - ratio * (high - low), right = low + ratio * (high - low);
  double f_left = f(left), f_right = f(right);
  while (high - low > kWeightTolerance) {
    if (f_left <= f_right) {
      high = right;
      right = left;
      f_right = f_left;
      f_left = f(left = high - ratio * (high - low));
    } else {
      low = left;
      left = right;
      f_left = f_right;
      f_right = f(right = low + ratio * (high - low));
    }
  }
  return f_left <= f_right ? left : right;
}

// The weight of least cross-validation: a scan, then golden sections around its best point.
double BestWeight(const SmoothingSpline& spline) {
  const auto score = [&](double log_weight) { return spline.CrossValidation(std::pow(10.0, log_weight)); };
  double best = kMinLogWeight;
  double best_score = std::numeric_limits<double>::infinity();
  for (double log_weight = kMinLogWeight; log_weight <= kMaxLogWeight; log_weight += kScanStep) {
    const double value = score(log_weight);
    if (value < best_score) {
      best_score = value;
      best = log_weight;
    }
  }
  if (best == kMinLogWeight) return std::pow(10.0, best);
  const double refined = GoldenSection(score, best - kScanStep, std::min(best + kScanStep, kMaxLogWeight));
  return std::pow(10.0, refined);
}

}  // namespace

Eigen::MatrixXd SmoothPath(const Eigen::VectorXd& times, const Eigen::MatrixXd& values) {
  const Eigen::Index count = times.size();
  if (count < kMinTimes || values.rows() == 0) return values;
  const double interval = (times[count - 1] - times[0]) / static_cast<double>(count - 1);
  const Eigen::VectorXd frames = (times.array() - times[0]) / interval;
  Eigen::MatrixXd result = values;
  for (Eigen::Index row = 0; row < values.rows(); ++row) {
    // A spline keeps constants; taking the first value off keeps them to the last bit.
    const SmoothingSpline spline(frames, (values.row(row).array() - values(row, 0)).transpose());
    result.row(row) -= spline.Residual(BestWeight(spline)).transpose();
  }
  return result;
}

}  // namespace clothid
