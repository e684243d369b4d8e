#include "identify/checks/repeated_fit.h"

#include <algorithm>
#include <cmath>

namespace clothid {
namespace {

// Of the cost. A standard deviation lowers the cost of m residuals by 1/m of it: at 1e5 of them this is a tenth of one
// deviation, and steps are superlinear.
constexpr double kFunctionTolerance = 1e-7;

}  // namespace

Eigen::VectorXd ChangesBetween(const FitProblem& problem, const Eigen::VectorXd& from, const Eigen::VectorXd& to) {
  Eigen::VectorXd changes = to - from;
  for (int i = 0; i < problem.num_blocks(); ++i) {
    const ParameterBlock& block = problem.blocks()[i];
    changes[i] = block.scale == ParameterScale::kLog ? std::expm1(changes[i]) : block.unit * changes[i];
  }
  return changes;
}

RepeatedFit RepeatFit(const std::vector<RecordedMotion>& motions, const FitOptions& options, const std::string& tag,
                      const FitProblem& problem, const Eigen::VectorXd& coordinates, bool from_bases) {
  FitOptions repeat = problem.WithWeights(options);
  repeat.estimate_uncertainty = false;
  repeat.on_iteration = nullptr;
  repeat.on_stage = nullptr;
  repeat.journal_tag = tag;
  repeat.function_tolerance = std::max(options.function_tolerance, kFunctionTolerance);
  // Made from the same starting values, because bounds that are not given depend on them.
  FitProblem own_problem(motions, repeat);
  Eigen::VectorXd start = coordinates;
  if (from_bases) {
    start = Eigen::VectorXd::Zero(own_problem.num_coordinates());
    start.head(problem.num_blocks()) = coordinates.head(problem.num_blocks());
    start.tail(problem.num_field_unknowns()) = coordinates.tail(problem.num_field_unknowns());
  }
  own_problem.SetStart(start);
  const FitSummary fit = Fit(repeat, &own_problem);

  RepeatedFit result;
  result.status = fit.status;
  result.statistics = fit.statistics;
  if (!fit.has_estimate()) return result;
  result.coordinates = fit.coordinates.head(problem.num_blocks());
  result.values = fit.values();
  result.rmse = fit.error.rmse();
  result.changes = ChangesBetween(problem, coordinates.head(problem.num_blocks()), result.coordinates);
  return result;
}

}  // namespace clothid
