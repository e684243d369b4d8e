#include "identify/checks/multi_start.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <iterator>
#include <mutex>
#include <numeric>
#include <random>
#include <utility>

#include "identify/base/parallel_for.h"
#include "identify/fit/continued_fit.h"
#include "identify/fit/fit.h"

namespace clothid {
namespace {

constexpr double kStartFactor = 10.0;      // from the own start to the farthest other one, in logarithmic coordinates
constexpr double kShareOfBounds = 0.5;     // of the way to the bounds of a recording's own parameter
constexpr double kMaxStartFriction = 1.0;  // beyond it most cloth sticks at once, and the cost is a plateau
constexpr double kSameMinimum = 1e-3;      // in an internal coordinate

// The coordinates between which block `block` may start.
std::pair<double, double> StartRange(const ParameterBlock& block) {
  if (block.is_signed) {
    const auto toward = [&](double bound) {
      return block.ToCoordinate(block.start + kShareOfBounds * (bound - block.start));
    };
    return {toward(block.lower_bound), toward(block.upper_bound)};
  }
  const bool is_log = block.scale == ParameterScale::kLog;
  const double low = is_log ? block.start / kStartFactor : 0.0;
  const double high = is_log ? block.start * kStartFactor : std::max(kMaxStartFriction, block.start);
  return {block.ToCoordinate(std::max(low, block.lower_bound)), block.ToCoordinate(std::min(high, block.upper_bound))};
}

StartResult Describe(const FitSummary& summary, const Eigen::VectorXd& start) {
  StartResult result;
  result.start = start;
  result.status = summary.status;
  if (!summary.has_estimate()) return result;
  result.values = summary.values();
  result.cost = summary.cost;
  result.rmse = summary.error.rmse();
  return result;
}

// Whether `candidate` is to be preferred to `best`.
bool IsBetter(const FitSummary& candidate, const FitSummary& best) {
  if (candidate.has_estimate() != best.has_estimate()) return candidate.has_estimate();
  const bool converged = candidate.status == FitStatus::kConverged;
  if (converged != (best.status == FitStatus::kConverged)) return converged;
  return candidate.cost < best.cost;
}

bool IsSameMinimum(const std::vector<ParameterBlock>& blocks, const std::optional<Uncertainty>& uncertainty,
                   const Eigen::VectorXd& a, const Eigen::VectorXd& b) {
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    double tolerance = kSameMinimum;
    if (uncertainty) {
      const ParameterUncertainty& parameter = uncertainty->parameters[i];
      // What the measurements do not determine ends anywhere.
      if (!parameter.visible) continue;
      if (parameter.coordinate_std > tolerance) tolerance = parameter.coordinate_std;
    }
    if (std::abs(blocks[i].ToCoordinate(a[i]) - blocks[i].ToCoordinate(b[i])) > tolerance) return false;
  }
  return true;
}

void FindMinima(const std::vector<ParameterBlock>& blocks, const FitSummary& best, MultiStart* result) {
  std::vector<StartResult*> by_cost;
  for (StartResult& start : result->starts) {
    if (start.status == FitStatus::kConverged) by_cost.push_back(&start);
  }
  std::stable_sort(by_cost.begin(), by_cost.end(),
                   [](const StartResult* a, const StartResult* b) { return a->cost < b->cost; });
  const double scale = best.uncertainty ? best.uncertainty->residual_scale * best.uncertainty->largest_widening() : 1.0;
  for (StartResult* start : by_cost) {
    std::vector<Minimum>& minima = result->minima;
    const auto found = std::find_if(minima.begin(), minima.end(), [&](const Minimum& minimum) {
      return IsSameMinimum(blocks, best.uncertainty, start->values, minimum.values);
    });
    start->minimum = static_cast<int>(found - minima.begin());
    if (found == minima.end()) {
      const double rise = 2.0 * (start->cost - by_cost.front()->cost) / (scale * scale);
      minima.push_back({start->values, start->cost, start->rmse, 0, rise});
    }
    ++minima[static_cast<std::size_t>(start->minimum)].num_starts;
  }
}

void FindAmbiguities(const std::vector<ParameterBlock>& blocks, MultiStart* result) {
  result->ambiguous.assign(blocks.size(), false);
  for (std::size_t m = 1; m < result->minima.size(); ++m) {
    if (result->minima[m].is_distinguishable()) continue;
    for (std::size_t i = 0; i < blocks.size(); ++i) {
      const double distance = blocks[i].ToCoordinate(result->minima[m].values[i]) -
                              blocks[i].ToCoordinate(result->minima.front().values[i]);
      if (!blocks[i].frozen && std::abs(distance) > kSameMinimum) result->ambiguous[i] = true;
    }
  }
}

}  // namespace

bool Minimum::is_distinguishable() const { return !(cost_rise <= kChiSquare95); }

std::vector<Eigen::VectorXd> StartPoints(const std::vector<ParameterBlock>& blocks, int count, std::uint64_t seed) {
  const Eigen::Index size = static_cast<Eigen::Index>(blocks.size());
  Eigen::VectorXd own(size);
  for (Eigen::Index i = 0; i < size; ++i) own[i] = blocks[i].ToCoordinate(blocks[i].start);
  std::vector<Eigen::VectorXd> points(static_cast<std::size_t>(count), own);
  std::mt19937_64 generator(seed);
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  for (Eigen::Index i = 0; i < size; ++i) {
    if (blocks[i].frozen) continue;
    const auto [low, high] = StartRange(blocks[i]);
    std::vector<int> strata(static_cast<std::size_t>(count - 1));
    std::iota(strata.begin(), strata.end(), 0);
    std::shuffle(strata.begin(), strata.end(), generator);
    for (std::size_t s = 0; s < strata.size(); ++s) {
      points[s + 1][i] = low + (high - low) * (strata[s] + uniform(generator)) / static_cast<double>(strata.size());
    }
  }
  return points;
}

namespace {

using Points = std::vector<Eigen::VectorXd>;

// One after the other, on the problem itself, so that its journals hold all of them. Ends with the first that is
// interrupted.
std::vector<FitSummary> FitInTurn(const FitOptions& options, const std::vector<RecordedMotion>& motions,
                                  const Points& points, int num_before, FitProblem* problem) {
  std::vector<FitSummary> fits;
  for (std::size_t s = 0; s < points.size(); ++s) {
    if (options.on_start) options.on_start(num_before + static_cast<int>(s));
    problem->SetStart(points[s]);
    problem->Forget();
    fits.push_back(Fit(options, problem, &motions));
    if (fits.back().status == FitStatus::kInterrupted) break;
  }
  return fits;
}

// Side by side, each on a problem of its own: fits of one problem do not depend on those before them.
std::vector<FitSummary> FitSideBySide(const FitOptions& options, const std::vector<RecordedMotion>& motions,
                                      const Points& points, int num_before) {
  FitOptions each = options;
  each.num_threads = 1;
  each.on_iteration = nullptr;  // whose iterations these are nobody could tell
  each.on_progress = nullptr;
  each.on_stage = nullptr;
  std::vector<FitSummary> fits(points.size());
  std::mutex mutex;
  int num_begun = num_before;
  ParallelFor(static_cast<int>(points.size()), options.num_threads, [&](int s) {
    if (options.on_start) {
      const std::lock_guard<std::mutex> lock(mutex);
      options.on_start(num_begun++);
    }
    FitProblem problem(motions, each);
    problem.SetStart(points[s]);
    fits[s] = Fit(each, &problem, &motions);
  });
  return fits;
}

// The best of `fits`, with the counts and seconds of all.
FitSummary TakeBest(std::vector<FitSummary> fits, std::size_t* best_start) {
  CostStatistics statistics, lead;
  double total_seconds = 0.0, solver_seconds = 0.0;
  std::string interruption;
  *best_start = 0;
  for (std::size_t s = 0; s < fits.size(); ++s) {
    statistics += fits[s].statistics;
    lead += fits[s].lead;
    total_seconds += fits[s].total_seconds;
    solver_seconds += fits[s].solver_seconds;
    if (fits[s].status == FitStatus::kInterrupted) interruption = fits[s].message;
    if (IsBetter(fits[s], fits[*best_start])) *best_start = s;
  }
  FitSummary best = std::move(fits[*best_start]);
  best.statistics = statistics;
  best.lead = lead;
  best.total_seconds = total_seconds;
  best.solver_seconds = solver_seconds;
  if (!interruption.empty()) {
    best.status = FitStatus::kInterrupted;
    best.message = interruption;
  }
  return best;
}

}  // namespace

FitSummary FitFromStarts(const FitOptions& options, const std::vector<RecordedMotion>& motions, FitProblem* problem,
                         MultiStart* result) {
  FitOptions each = options;
  each.estimate_uncertainty = false;
  const FitOptions choosing = each;
  const Points points = StartPoints(problem->blocks(), options.num_starts, options.seed);
  const bool side_by_side = options.num_threads > 1 && options.journal_folder.empty();
  const auto begin = std::chrono::steady_clock::now();
  // The others have the weights of smoothness that the first has chosen, so that their costs compare.
  std::vector<FitSummary> fits;
  const bool chooses = problem->chooses_weights();
  if (chooses) {
    fits = FitInTurn(each, motions, {points.front()}, 0, problem);
    problem->HoldWeights(true);
    each = problem->WithWeights(each);
  }
  const auto num_before = static_cast<int>(fits.size());
  const Points others(points.begin() + num_before, points.end());
  if (fits.empty() || !options.is_cancelled()) {
    std::vector<FitSummary> rest = side_by_side ? FitSideBySide(each, motions, others, num_before)
                                                : FitInTurn(each, motions, others, num_before, problem);
    std::move(rest.begin(), rest.end(), std::back_inserter(fits));
  }
  problem->HoldWeights(false);
  const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - begin;
  for (std::size_t s = 0; s < fits.size(); ++s) {
    result->starts.push_back(Describe(fits[s], problem->Values(points[s])));
  }
  std::size_t best_start = 0;
  FitSummary best = TakeBest(std::move(fits), &best_start);
  best.total_seconds = elapsed.count();
  if (chooses && best_start > 0 && best.has_estimate() && !options.is_cancelled()) {
    problem->SetStart(best.coordinates);
    FitSummary last = Fit(choosing, problem);
    if (last.has_estimate()) {
      AddEarlierFit(best, &last);
      best = std::move(last);
    }
  }
  problem->SetStart(points.front());
  problem->Forget();
  if (options.estimate_uncertainty && best.has_estimate()) {
    FinishFit(options, problem, &best, &motions);
    // Costs of frames that are weighed do not compare with those of the other starts.
    StartResult& start = result->starts[best_start];
    if (best.num_continuations > 0 && !problem->has_model_error()) start = Describe(best, start.start);
  }
  FindMinima(problem->blocks(), best, result);
  FindAmbiguities(problem->blocks(), result);
  return best;
}

}  // namespace clothid
