#include "identify/checks/profile.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

namespace clothid {
namespace {

constexpr double kShareOfRange = 0.02;   // the first step where there is no standard deviation
constexpr double kRiseTolerance = 0.02;  // of the profile at the ends of the interval
constexpr int kMaxDoublings = 12;
constexpr int kMaxSearches = 8;

// Walks the profile of one parameter. The problem's block is frozen for its lifetime.
class Profiler {
 public:
  Profiler(const FitOptions& options, const FitSummary& summary, int index, FitProblem* problem,
           CostStatistics* statistics, Profile* profile)
      : options_(options),
        summary_(summary),
        index_(index),
        block_(problem->blocks()[index]),
        start_(problem->StartCoordinates()),
        problem_(problem),
        statistics_(statistics),
        profile_(profile) {
    options_.estimate_uncertainty = false;
    options_.on_iteration = nullptr;
    options_.on_stage = nullptr;
    options_.assimilate = problem->assimilation_option();
    problem_->SetFrozen(index_, true);
    problem_->HoldWeights(true);
  }
  ~Profiler() {
    problem_->SetFrozen(index_, false);
    problem_->HoldWeights(false);
    problem_->SetStart(start_);
  }
  Profiler(const Profiler&) = delete;
  Profiler& operator=(const Profiler&) = delete;

  // The value at which the profile reaches kChiSquare95 on one side, -1 below or +1 above the estimate; NaN: open.
  double FindEnd(int side) {
    const double estimate = summary_.coordinates[index_];
    const double bound = block_.ToCoordinate(side < 0 ? block_.lower_bound : block_.upper_bound);
    warm_start_ = summary_.coordinates;
    double inside = estimate, inside_rise = 0.0, step = FirstStep();
    for (int doubling = 0; doubling < kMaxDoublings && inside != bound; ++doubling, step *= 2.0) {
      const double outside = side < 0 ? std::max(bound, estimate - step) : std::min(bound, estimate + step);
      const std::optional<double> rise = RiseAt(outside);
      if (!rise) return std::numeric_limits<double>::quiet_NaN();
      if (*rise >= (1.0 - kRiseTolerance) * kChiSquare95)
        return block_.ToValue(Search(inside, inside_rise, outside, *rise));
      inside = outside;
      inside_rise = *rise;
    }
    return std::numeric_limits<double>::quiet_NaN();
  }

 private:
  double FirstStep() const {
    const double std = summary_.uncertainty->parameters[index_].coordinate_std;
    return std::isnan(std) ? kShareOfRange * block_.CoordinateRange() : kNormal95 * std;
  }

  // The square root of a profile is nearly linear in q.
  double Search(double inside, double inside_rise, double outside, double outside_rise) {
    double beyond = outside, beyond_rise = outside_rise;  // the point outside before the last
    for (int i = 0; i < kMaxSearches && std::abs(outside_rise - kChiSquare95) > kRiseTolerance * kChiSquare95; ++i) {
      const double low = std::sqrt(std::max(0.0, inside_rise)), high = std::sqrt(outside_rise);
      double share = std::clamp((std::sqrt(kChiSquare95) - low) / (high - low), 0.05, 0.95);
      // Where it is flat as far as `inside`, the line is that of the points outside.
      const bool is_flat = inside != summary_.coordinates[index_] && inside_rise < kRiseTolerance * kChiSquare95;
      if (is_flat) {
        const double slope = (std::sqrt(beyond_rise) - high) / (beyond - outside);
        share = 1.0 - (high - std::sqrt(kChiSquare95)) / (slope * (outside - inside));
        if (!(share > 0.0 && share < 1.0)) share = 0.5;
      }
      const double middle = inside + (outside - inside) * share;
      const std::optional<double> rise = RiseAt(middle);
      if (!rise) break;
      if (std::abs(*rise - kChiSquare95) <= kRiseTolerance * kChiSquare95) return middle;
      if (*rise < kChiSquare95) {
        inside = middle;
        inside_rise = *rise;
        continue;
      }
      beyond = std::exchange(outside, middle);
      beyond_rise = std::exchange(outside_rise, *rise);
    }
    return outside;
  }

  // From the best of the point before: profiles are continuous where the fit is.
  std::optional<double> RiseAt(double coordinate) {
    warm_start_[index_] = coordinate;
    problem_->SetStart(warm_start_);
    const FitSummary fit = Fit(options_, problem_);
    *statistics_ += fit.statistics;
    if (fit.status != FitStatus::kConverged) {
      ++profile_->num_failed;
      return std::nullopt;
    }
    warm_start_ = fit.coordinates;
    const ParameterUncertainty& held = summary_.uncertainty->parameters[index_];
    const double scale = std::max(held.cost_scale * held.widening, kRoundingResiduals);
    const double rise = 2.0 * (fit.cost - summary_.cost) / (scale * scale);
    profile_->points.push_back({block_.ToValue(coordinate), rise, fit.values()});
    return rise;
  }

  FitOptions options_;
  const FitSummary& summary_;
  int index_;
  const ParameterBlock block_;
  const Eigen::VectorXd start_;
  FitProblem* problem_;
  CostStatistics* statistics_;
  Profile* profile_;
  Eigen::VectorXd warm_start_;
};

}  // namespace

double ProfileEnd(const FitOptions& options, const FitSummary& summary, int index, int side, FitProblem* problem,
                  CostStatistics* statistics) {
  Profile profile;
  return Profiler(options, summary, index, problem, statistics, &profile).FindEnd(side);
}

Profile ProfileParameter(const FitOptions& options, const FitSummary& summary, const std::string& name,
                         FitProblem* problem, CostStatistics* statistics) {
  Profile profile;
  profile.parameter = name;
  const int index = FindFreeBlock(*problem, name, "--profile");
  const ParameterUncertainty& uncertainty = summary.uncertainty->parameters[index];
  if (IsResolution(problem->blocks()[index], summary.coordinates[index], uncertainty.coordinate_std)) {
    profile.has_no_noise = true;
    profile.points.push_back({summary.parameters[index].value, 0.0, summary.values()});
    profile.lower95 = uncertainty.lower95;
    profile.upper95 = uncertainty.upper95;
    return profile;
  }
  Profiler profiler(options, summary, index, problem, statistics, &profile);
  profile.points.push_back({summary.parameters[index].value, 0.0, summary.values()});
  profile.lower95 = profiler.FindEnd(-1);
  profile.upper95 = profiler.FindEnd(+1);
  std::sort(profile.points.begin(), profile.points.end(),
            [](const ProfilePoint& a, const ProfilePoint& b) { return a.value < b.value; });
  return profile;
}

}  // namespace clothid
