#include "identify/fit/dent_check.h"

#include <Eigen/LU>
#include <cmath>

#include "identify/fit/evaluator.h"

namespace clothid {
namespace {

constexpr double kStepResolutions = 1e4;  // 1 % of what is logarithmic
constexpr double kNarrow = 1.0 / 3.0;
constexpr double kDentRise = 0.1;

// (C^-1)_ii of all parameters that have a standard deviation [p]; 0 of the others.
Eigen::VectorXd Precisions(const Uncertainty& uncertainty) {
  const Eigen::MatrixXd& correlation = uncertainty.independent_correlation;
  const Eigen::Index num = correlation.rows();
  Eigen::MatrixXd covariance = Eigen::MatrixXd::Identity(num, num);
  const auto std_of = [&](Eigen::Index i) { return uncertainty.parameters[i].independent_std; };
  for (Eigen::Index i = 0; i < num; ++i) {
    for (Eigen::Index k = 0; k < num; ++k) {
      if (std::isnan(std_of(i)) || std::isnan(std_of(k)) || std::isnan(correlation(i, k))) continue;
      covariance(i, k) = correlation(i, k) * std_of(i) * std_of(k);
    }
  }
  Eigen::VectorXd precisions = covariance.inverse().diagonal();
  for (Eigen::Index i = 0; i < num; ++i) {
    if (std::isnan(std_of(i))) precisions[i] = 0.0;
  }
  return precisions;
}

bool IsInside(const ParameterBlock& block, double coordinate) {
  return coordinate >= block.ToCoordinate(block.lower_bound) && coordinate <= block.ToCoordinate(block.upper_bound);
}

}  // namespace

bool DentCheck::is_dent() const { return std::fmin(rise_below, rise_above) < kDentRise * expected_rise; }

std::vector<DentCheck> CheckForDents(const std::vector<ParameterBlock>& blocks, const Eigen::VectorXd& coordinates,
                                     double cost, const Uncertainty& uncertainty, FitEvaluator* evaluator) {
  std::vector<DentCheck> checks;
  const Eigen::VectorXd precisions = Precisions(uncertainty);
  const double scale = uncertainty.residual_scale;
  for (Eigen::Index i = 0; i < precisions.size(); ++i) {
    const double step = kStepResolutions * blocks[i].Resolution(coordinates[i]);
    if (blocks[i].frozen || !(uncertainty.parameters[i].half_width95 < kNarrow * step)) continue;
    const auto rise_at = [&](double moved) {
      Eigen::VectorXd end = coordinates;
      end[i] += moved;
      double end_cost = 0.0;
      if (!IsInside(blocks[i], end[i]) ||
          !evaluator->Evaluate(end, FitEvaluator::Derivative::kNone, &end_cost, /*gradient=*/nullptr)) {
        return std::numeric_limits<double>::quiet_NaN();
      }
      return 2.0 * (end_cost - cost) / (scale * scale);
    };
    DentCheck check;
    check.parameter = static_cast<int>(i);
    check.step = step;
    check.expected_rise = step * step * precisions[i];
    check.rise_below = rise_at(-step);
    check.rise_above = rise_at(step);
    checks.push_back(check);
  }
  return checks;
}

}  // namespace clothid
