#include "identify/problem/memory_trial.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "identify/problem/evaluator.h"
#include "identify/problem/gauss_newton.h"
#include "sim/base/median.h"
#include "sim/matrix/dense.h"
#include "sim/mesh/mesh.h"

namespace clothid {
namespace {

constexpr double kFirstMemory = 2.0;  // in frame intervals
constexpr double kMemoryGrowth = 3.0;
constexpr double kLongestShare = 1.0 / 3.0;  // of a recording
constexpr std::size_t kMostMemories = 6;
// An estimate that moves by more jumps: a factor of 2, or this share of the range, and three standard deviations.
constexpr double kLargestMove = 0.7;
constexpr double kLargestShare = 0.125;
constexpr double kStds = 3.0;
// Resolutions of a parameter, 5 %: the step on from where a trial ended is taken where it is shorter.
constexpr double kNextStep = 5e4;
// Costs that differ by less are the same. What rollouts without corrections may cost where a fit of them is tried.
constexpr double kSameCost = 5e-3;
constexpr double kNearCost = 0.2;
// Of consecutive frames. Or what chance leaves of so many residuals, three standard deviations.
constexpr double kNoiseCorrelation = 0.05;
// Memories that are shorter by more than this factor say nothing of the drift.
constexpr double kDriftFactor = 5.0;

// Nothing but rounding is left, or there is nothing to compare with.
bool IsExact(const std::vector<MemoryTrial>& trials) {
  return trials.empty() || trials.back().residual_scale < kRoundingResiduals;
}

// Of what is measured, in its standard deviations.
double ResidualScale(const FitProblem& problem, double cost) {
  double num_measurements = 0.0;
  for (int r = 0; r < problem.num_recordings(); ++r) {
    num_measurements += problem.cost(r).model().observation().num_residuals();
  }
  const double freedom = num_measurements - static_cast<double>(problem.free_blocks().size());
  return std::sqrt(2.0 * cost / std::max(1.0, freedom));
}

}  // namespace

std::vector<double> MemoriesOf(const FitProblem& problem) {
  double interval = 0.0, duration = std::numeric_limits<double>::infinity();
  for (int r = 0; r < problem.num_recordings(); ++r) {
    const Eigen::VectorXd& times = problem.cost(r).model().times();
    if (times.size() < 2) return {};
    const Eigen::VectorXd intervals = times.tail(times.size() - 1) - times.head(times.size() - 1);
    interval = std::max(interval, Median(intervals));
    duration = std::min(duration, times[times.size() - 1] - times[0]);
  }
  std::vector<double> memories;
  for (double memory = kFirstMemory * interval; memory <= kLongestShare * duration; memory *= kMemoryGrowth) {
    if (memories.size() < kMostMemories) memories.push_back(memory);
  }
  return memories;
}

std::string WhyNotAssimilated(const FitProblem& problem) {
  for (int r = 0; r < problem.num_recordings(); ++r) {
    const std::string reason = problem.cost(r).model().WhyNotAssimilated();
    if (!reason.empty()) return problem.cost(r).model().name() + " " + reason;
  }
  return {};
}

MemoryTrial DescribeTrial(const FitProblem& problem, const FitEvaluator& evaluator, double memory) {
  MemoryTrial trial;
  trial.memory = memory;
  const FitPoint& best = evaluator.best();
  const QuadraticModel& model = evaluator.model();
  const bool has_model = model.coordinates.size() > 0 && model.coordinates == best.coordinates;
  const Eigen::VectorXd end = has_model ? NextPoint(problem, model, kNextStep) : best.coordinates;
  const Eigen::VectorXd step = (end - best.coordinates).head(problem.num_blocks());
  trial.coordinates = end.head(problem.num_blocks());
  trial.values = problem.Values(end);
  trial.cost = best.cost - problem.PriorCost(best.coordinates);
  if (has_model) trial.cost = std::max(0.0, trial.cost + 0.5 * model.gradient.dot(step));
  trial.residual_scale = ResidualScale(problem, trial.cost);
  trial.std = Eigen::VectorXd::Constant(problem.num_blocks(), std::numeric_limits<double>::quiet_NaN());
  trial.lower95 = trial.upper95 = trial.std;
  if (!has_model) return trial;
  std::vector<int> told;
  for (int i = 0; i < problem.num_blocks(); ++i) {
    if (model.hessian(i, i) > 0.0) told.push_back(i);
  }
  const Eigen::MatrixXd hessian = model.hessian(told, told);
  const Eigen::MatrixXd covariance = SymmetricFactor(hessian).Inverse();
  for (std::size_t i = 0; i < told.size(); ++i) {
    const double variance = covariance(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(i));
    if (variance > 0.0) trial.std[told[i]] = trial.residual_scale * std::sqrt(variance);
  }
  trial.lower95 = problem.Values(trial.coordinates - kNormal95 * trial.std);
  trial.upper95 = problem.Values(trial.coordinates + kNormal95 * trial.std);
  return trial;
}

bool AmplifiesBeyondTheCloth(const FitProblem& problem, const QuadraticModel& model) {
  if (model.hessian.size() == 0) return false;
  double bound = 0.0;
  for (int r = 0; r < problem.num_recordings(); ++r) {
    const RecordingModel& own = problem.cost(r).model();
    const double size = ClothSize(own.scene().mesh);
    for (int row = 0; row < own.observation().first_force_row(); ++row) {
      bound += std::pow(kMostMoved * size / own.observation().SigmaOf(row), 2);
    }
  }
  for (const int i : problem.free_blocks()) {
    if (!(model.hessian(i, i) <= bound)) return true;
  }
  return false;
}

bool Follows(const std::vector<ParameterBlock>& blocks, const MemoryTrial& last, const MemoryTrial& next) {
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    const auto index = static_cast<Eigen::Index>(i);
    if (std::isnan(last.std[index])) continue;  // nothing was told of it
    const double chance = std::hypot(last.std[index], std::isnan(next.std[index]) ? 0.0 : next.std[index]);
    const double largest = std::min(kLargestMove, kLargestShare * blocks[i].CoordinateRange());
    if (std::abs(next.coordinates[index] - last.coordinates[index]) > largest + kStds * chance) return false;
  }
  return true;
}

bool LeavesNoise(const FitProblem& problem, const std::vector<Eigen::MatrixXd>& predicted, double cost) {
  if (ResidualScale(problem, cost) < kRoundingResiduals) return true;
  PredictionError error;
  for (int r = 0; r < problem.num_recordings(); ++r) {
    error += problem.cost(r).model().observation().Compare(predicted[static_cast<std::size_t>(r)]);
  }
  const double by_chance = kStds / std::sqrt(std::max(1.0, error.num_coordinates + error.cloud.num_successive));
  return !(error.autocorrelation() > std::max(kNoiseCorrelation, by_chance));
}

bool LeavesAsLittle(double uncorrected_cost, const std::vector<MemoryTrial>& trials) {
  return IsExact(trials) || uncorrected_cost <= (1.0 + kNearCost) * trials.back().cost;
}

bool MayBeNoise(const std::vector<MemoryTrial>& trials) {
  if (IsExact(trials)) return true;
  const auto least = std::min_element(trials.begin(), trials.end(),
                                      [](const MemoryTrial& a, const MemoryTrial& b) { return a.cost < b.cost; });
  return trials.back().cost <= (1.0 + kSameCost) * least->cost;
}

bool IsNoWorse(double uncorrected_cost, const std::vector<MemoryTrial>& trials) {
  if (trials.empty()) return true;
  const MemoryTrial& last = trials.back();
  const double rounding = last.residual_scale > 0.0 ? kRoundingResiduals / last.residual_scale : 1.0;
  return uncorrected_cost <= std::max(1.0 + kSameCost, rounding * rounding) * last.cost;
}

double FirstMemoryOfDrift(const std::vector<MemoryTrial>& trials) {
  const double least = trials.back().memory / kDriftFactor;
  return std::find_if(trials.begin(), trials.end(), [&](const MemoryTrial& trial) { return trial.memory >= least; })
      ->memory;
}

Eigen::VectorXd DriftOf(const std::vector<MemoryTrial>& trials, const Eigen::VectorXd& coordinates) {
  Eigen::VectorXd drift = Eigen::VectorXd::Zero(coordinates.size());
  for (const MemoryTrial& trial : trials) {
    if (trial.memory < FirstMemoryOfDrift(trials)) continue;
    drift = drift.cwiseMax((trial.coordinates - coordinates).cwiseAbs());
  }
  return drift;
}

}  // namespace clothid
