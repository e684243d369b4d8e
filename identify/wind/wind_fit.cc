#include "identify/wind/wind_fit.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "identify/fit/continued_fit.h"
#include "identify/fit/evaluator.h"
#include "identify/fit/fit.h"
#include "identify/uncertainty/marginal.h"
#include "identify/uncertainty/priors.h"
#include "sim/matrix/dense.h"

namespace clothid {
namespace {

constexpr int kMostFits = 5;
// Of the logarithm of the smoothness: between two fits, and within one linear model.
constexpr double kSettled = 0.2, kStationary = 1e-4;
constexpr int kMostRounds = 500;

// The linear model over the blocks that may move.
struct LinearModel {
  Eigen::MatrixXd curvature;  // J^T J
  Eigen::MatrixXd prior;      // P
  Eigen::MatrixXd links;      // L, for the smoothness 1
  Eigen::VectorXd gradient;   // J^T e
  Eigen::VectorXd prior_gradient;
  Eigen::VectorXd differences;  // L q at the point
  double squared_residual = 0.0, degrees = 0.0;
  bool sigma_is_known = true;

  double Next(double smoothness) const {
    const double weight = 1.0 / (smoothness * smoothness);
    const SymmetricFactor factor(curvature + prior + weight * links.transpose() * links);
    const Eigen::VectorXd step =
        -factor.SolveOne(gradient + prior_gradient + weight * (links.transpose() * differences));
    const double squared = squared_residual + 2.0 * gradient.dot(step) + step.dot(curvature * step);
    const double fitted = std::max(squared, 0.0) / degrees;
    const double scale = sigma_is_known ? std::max(1.0, fitted) : fitted;
    const double determined = static_cast<double>(links.rows()) -
                              weight * links.cwiseProduct(factor.Solve(links.transpose()).transpose()).sum();
    const double square = (differences + links * step).squaredNorm() / (std::max(determined, 1e-6) * scale);
    return std::clamp(std::sqrt(square), kLeastWindSmoothness, kMostWindSmoothness);
  }
};

std::vector<int> MovingBlocks(const std::vector<ParameterBlock>& blocks, const Eigen::VectorXd& coordinates) {
  std::vector<int> moving;
  for (int i = 0; i < static_cast<int>(blocks.size()); ++i) {
    if (!blocks[i].frozen && !blocks[i].IsAtBound(coordinates[i])) moving.push_back(i);
  }
  return moving;
}

// At the end of a fit: what its recordings say of the blocks, unknown starts eliminated.
std::optional<Linearization> Linearized(const FitOptions& options, const FitProblem& problem, FitSummary* summary) {
  std::optional<Linearization> all = summary->linearization;
  FitEvaluator evaluator(&problem, options.num_threads, EvaluationPurpose::kInterval);
  const bool ok = all || evaluator.Linearize(summary->coordinates, &all.emplace());
  summary->statistics += evaluator.statistics();
  summary->total_seconds += evaluator.seconds();
  if (!ok) return std::nullopt;
  return Marginalize(std::move(*all), problem.num_blocks()).parameters;
}

bool CanGoOn(const FitOptions& options, const FitSummary& summary) {
  return summary.has_estimate() && summary.status != FitStatus::kFailed && summary.status != FitStatus::kInterrupted &&
         !options.is_cancelled();
}

}  // namespace

double StationarySmoothness(const std::vector<ParameterBlock>& blocks, const Eigen::VectorXd& coordinates,
                            const Linearization& linearization, double smoothness) {
  const std::vector<int> moving = MovingBlocks(blocks, coordinates);
  const Eigen::MatrixXd links = smoothness * LinkRows(blocks), jacobian = linearization.jacobian(Eigen::all, moving);
  std::vector<ParameterBlock> unlinked = blocks;
  for (ParameterBlock& block : unlinked) block.linked_to = kNoBlock;
  LinearModel model;
  model.curvature = jacobian.transpose() * jacobian;
  model.prior = PriorHessian(unlinked)(moving, moving);
  model.links = links(Eigen::all, moving);
  model.gradient = linearization.gradient(moving);
  model.prior_gradient = PriorGradient(unlinked, coordinates)(moving);
  model.differences = links * coordinates.head(links.cols());
  model.squared_residual = linearization.squared_residual;
  model.degrees = std::max(1.0, linearization.num_measurements - static_cast<double>(moving.size()));
  model.sigma_is_known = linearization.sigma_is_known;
  for (int round = 0; round < kMostRounds; ++round) {
    const double next = model.Next(smoothness), change = std::log(next / smoothness);
    smoothness = std::sqrt(smoothness * next);
    if (std::abs(change) < kStationary) break;
  }
  return smoothness;
}

FitSummary FitWithChosenSmoothness(const std::vector<RecordedMotion>& motions, GrowingHorizon* horizon,
                                   FitOptions* options, std::unique_ptr<FitProblem>* problem, bool* is_chosen) {
  *is_chosen = false;
  FitOptions search = *options;
  search.estimate_uncertainty = false;
  FitSummary summary = Fit(search, problem->get(), horizon);
  for (int fit = 1; fit < kMostFits && CanGoOn(search, summary); ++fit) {
    const std::optional<Linearization> linearization = Linearized(search, **problem, &summary);
    if (!linearization) break;
    const Eigen::VectorXd blocks = summary.coordinates.head((*problem)->num_blocks());
    const double next = StationarySmoothness((*problem)->blocks(), blocks, *linearization, search.wind_smoothness);
    *is_chosen = true;
    if (std::abs(std::log(next / search.wind_smoothness)) < kSettled) break;
    search.wind_smoothness = next;
    search.journal_tag = "wind_" + std::to_string(fit);
    auto own = std::make_unique<FitProblem>(motions, search);
    own->SetStart(summary.coordinates);
    FitSummary after = Fit(search, own.get());
    if (!after.has_estimate()) break;
    AddEarlierFit(summary, &after);
    summary = std::move(after);
    *problem = std::move(own);
  }
  options->wind_smoothness = search.wind_smoothness;
  if (summary.has_estimate() && options->estimate_uncertainty) {
    AddUncertainty(*options, **problem, &summary);
    ContinueFromLowerPoints(*options, &Fit, problem->get(), &summary);
  }
  return summary;
}

}  // namespace clothid
