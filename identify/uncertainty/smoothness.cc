#include "identify/uncertainty/smoothness.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "sim/matrix/dense.h"

namespace clothid {
namespace {

constexpr double kSmallestShare = 1e-12;  // of the largest weight
constexpr double kStationary = 1e-5;
constexpr double kRankRounding = 1e-10;  // of the largest eigenvalue of R^T R
constexpr double kTiny = std::numeric_limits<double>::min();

std::vector<int> Columns(const std::vector<Eigen::MatrixXd>& roots, Eigen::Index count, bool touched) {
  std::vector<int> columns;
  for (Eigen::Index i = 0; i < count; ++i) {
    const bool is_touched = std::any_of(
        roots.begin(), roots.end(), [i](const Eigen::MatrixXd& root) { return (root.col(i).array() != 0.0).any(); });
    if (is_touched == touched) columns.push_back(static_cast<int>(i));
  }
  return columns;
}

SmoothnessModel WithoutUntouched(const SmoothnessModel& all) {
  const std::vector<int> own = Columns(all.roots, all.gradient.size(), true);
  const std::vector<int> others = Columns(all.roots, all.gradient.size(), false);
  SmoothnessModel model = all;
  model.curvature = all.curvature(own, own);
  model.gradient = all.gradient(own);
  for (Eigen::MatrixXd& root : model.roots) root = root(Eigen::all, own).eval();
  if (others.empty()) return model;
  const SymmetricFactor factor(all.curvature(others, others));
  const Eigen::MatrixXd coupling = all.curvature(others, own);
  const Eigen::VectorXd gradient = all.gradient(others), step = factor.SolveOne(gradient);
  model.curvature -= coupling.transpose() * factor.Solve(coupling);
  model.gradient -= coupling.transpose() * step;
  model.squared_residual -= gradient.dot(step);
  return model;
}

}  // namespace

SmoothnessChooser::SmoothnessChooser(const SmoothnessModel& model) : model_(WithoutUntouched(model)) {
  const auto count = static_cast<Eigen::Index>(model_.roots.size());
  ranks_ = largest_ = Eigen::VectorXd::Zero(count);
  for (Eigen::Index g = 0; g < count; ++g) {
    const Spectrum spectrum = SymmetricSpectrum(Eigen::MatrixXd(model_.roots[g].transpose() * model_.roots[g]));
    const Eigen::VectorXd& values = spectrum.values;
    const Eigen::Index rank = (values.array() > kRankRounding * values[values.size() - 1]).count();
    const Eigen::MatrixXd told =
        spectrum.vectors.rightCols(rank) * values.tail(rank).cwiseSqrt().cwiseInverse().asDiagonal();
    ranks_[g] = static_cast<double>(rank);
    largest_[g] = std::max(kTiny, SymmetricEigenvalues(told.transpose() * model_.curvature * told).maxCoeff());
  }
}

SmoothnessChooser::Solution SmoothnessChooser::SolveFor(const Eigen::VectorXd& weights) const {
  Eigen::MatrixXd hessian = model_.curvature;
  Eigen::VectorXd gradient = model_.gradient;
  for (Eigen::Index g = 0; g < weights.size(); ++g) {
    hessian += weights[g] * model_.roots[g].transpose() * model_.roots[g];
    gradient += weights[g] * (model_.roots[g].transpose() * model_.values[g]);
  }
  const SymmetricFactor factor(hessian);
  const Eigen::VectorXd step = -factor.SolveOne(gradient);
  Solution solution{Eigen::VectorXd(weights.size()), Eigen::VectorXd(weights.size())};
  for (Eigen::Index g = 0; g < weights.size(); ++g) {
    const Eigen::MatrixXd& root = model_.roots[g];
    solution.determined[g] =
        ranks_[g] - weights[g] * root.cwiseProduct(factor.Solve(root.transpose()).transpose()).sum();
    solution.roughness[g] = (model_.values[g] + root * step).squaredNorm();
  }
  const double squared = model_.squared_residual + 2.0 * model_.gradient.dot(step) + step.dot(model_.curvature * step);
  const double degrees = std::max(1.0, model_.degrees_of_freedom - solution.determined.sum());
  const double fitted = std::max(squared, 0.0) / degrees;
  solution.squared_scale = model_.sigma_is_known ? std::max(1.0, fitted) : fitted;
  return solution;
}

Eigen::VectorXd SmoothnessChooser::NumDetermined(const Eigen::VectorXd& weights) const {
  return SolveFor(weights).determined;
}

Eigen::VectorXd SmoothnessChooser::Follow(Eigen::VectorXd weights, const std::vector<bool>& is_chosen,
                                          int most_rounds) const {
  for (Eigen::Index g = 0; g < weights.size(); ++g) {
    if (is_chosen[g] && !(weights[g] > 0.0)) weights[g] = largest_[g];
  }
  for (int round = 0; round < most_rounds; ++round) {
    const Solution solution = SolveFor(weights);
    double change = 0.0;
    for (Eigen::Index g = 0; g < weights.size(); ++g) {
      if (!is_chosen[g]) continue;
      const double determined = std::max(solution.determined[g], kSmallestShare);
      const double next = std::clamp(solution.squared_scale * determined / std::max(solution.roughness[g], kTiny),
                                     kSmallestShare * largest_[g], largest_[g]);
      change = std::max(change, std::abs(std::log(next / weights[g])));
      weights[g] = next;
    }
    if (change < kStationary) break;
  }
  return weights;
}

}  // namespace clothid
