#include "identify/problem/weight_choice.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "identify/uncertainty/smoothness.h"
#include "sim/matrix/dense.h"

namespace clothid {
namespace {

constexpr int kMostRounds = 100;     // towards the fixed point at once
constexpr double kLeastShare = 0.1;  // of itself that a weight may fall to
constexpr double kSteady = 0.5;      // change of its logarithm

// R over the columns of the basis, in no more rows than these.
Eigen::MatrixXd RootOver(const UnknownBasis& basis, const SmoothnessPrior& prior, const FitProblem& problem) {
  Eigen::MatrixXd root = Eigen::MatrixXd::Zero(prior.root.rows(), basis.size());
  if (prior.name == kWindPrior) {
    root.leftCols(problem.num_blocks()) = Eigen::MatrixXd(prior.root);
  } else {
    root.rightCols(basis.combinations.cols()) =
        prior.root * basis.combinations.bottomRows(problem.num_field_unknowns());
  }
  return root.rows() > root.cols() ? UpperFactor(root) : root;
}

SmoothnessModel ModelAt(const BasisLinearization& known, const Eigen::VectorXd& coordinates,
                        const FitProblem& problem) {
  const Linearization& measured = known.linearization;
  SmoothnessModel model;
  model.curvature = measured.jacobian.transpose() * measured.jacobian;
  model.gradient = measured.gradient;
  model.squared_residual = measured.squared_residual;
  model.degrees_of_freedom = measured.num_measurements - static_cast<double>(problem.num_blocks());
  model.sigma_is_known = measured.sigma_is_known;
  for (int i = 0; i < problem.num_blocks(); ++i) {
    const ParameterBlock& block = problem.blocks()[i];
    model.curvature(i, i) += std::pow(block.CoordinateRange(), -2);  // what nothing tells is within its bounds
    if (!block.prior.is_given()) continue;
    const double precision = std::pow(block.PriorStd(), -2);
    model.curvature(i, i) += precision;
    model.gradient[i] += precision * (coordinates[i] - block.PriorCoordinate());
  }
  for (const SmoothnessPrior& prior : problem.smoothness()) {
    model.roots.push_back(RootOver(known.basis, prior, problem));
    // Of what is in the basis alone: with the roughness of other modes, which gamma does not count, weights fall and
    // fall.
    model.values.push_back(model.roots.back() * known.basis.Restrict(coordinates));
  }
  return model;
}

}  // namespace

WeightChoice ChooseWeights(const BasisLinearization& known, const Eigen::VectorXd& coordinates, FitProblem* problem) {
  const SmoothnessChooser chooser(ModelAt(known, coordinates, *problem));
  const std::vector<SmoothnessPrior>& priors = problem->smoothness();
  const auto count = static_cast<int>(priors.size());
  Eigen::VectorXd weights(count);
  std::vector<bool> is_chosen;
  for (int g = 0; g < count; ++g) {
    weights[g] = priors[g].weight;
    is_chosen.push_back(priors[g].is_chosen && !priors[g].is_held);
  }
  const Eigen::VectorXd stationary = chooser.Follow(weights, is_chosen, kMostRounds);
  WeightChoice choice;
  for (int g = 0; g < count; ++g) {
    if (!is_chosen[g]) continue;
    const bool is_first = !(weights[g] > 0.0);
    const double next = is_first ? chooser.LargestWeight(g) : std::max(stationary[g], kLeastShare * weights[g]);
    choice.is_steady = choice.is_steady && !is_first && std::abs(std::log(next / weights[g])) < kSteady;
    problem->SetWeight(g, next);
    weights[g] = next;
  }
  choice.num_determined = chooser.NumDetermined(weights).sum();
  return choice;
}

}  // namespace clothid
