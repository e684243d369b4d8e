#include "identify/fit/evaluator.h"

#include <algorithm>
#include <chrono>

#include "identify/base/parallel_for.h"

namespace clothid {
namespace {

CostStatistics Total(const FitProblem& problem) {
  CostStatistics sum;
  for (int r = 0; r < problem.num_recordings(); ++r) sum += problem.cost(r).statistics();
  return sum;
}

}  // namespace

FitEvaluator::FitEvaluator(const FitProblem* problem, int num_threads, EvaluationPurpose purpose)
    : problem_(problem), num_threads_(num_threads), purpose_(purpose), statistics_before_(Total(*problem)) {}

FitEvaluator::RecordingResult FitEvaluator::EvaluateRows(int recording, const Eigen::VectorXd& coordinates,
                                                         Precision precision) const {
  const RolloutCost& cost = problem_->cost(recording, precision);
  const std::vector<int>& indices = problem_->block_indices(recording);
  Eigen::VectorXd residuals(cost.num_residuals());
  Eigen::MatrixXd jacobian = Eigen::MatrixXd::Zero(cost.num_residuals(), coordinates.size());
  std::vector<const double*> parameters;
  std::vector<double*> jacobians;
  for (Eigen::Index i = 0; i < coordinates.size(); ++i) {
    parameters.push_back(coordinates.data() + i);
    jacobians.push_back(problem_->blocks()[indices[i]].frozen ? nullptr : jacobian.col(i).data());
  }
  RecordingResult result;
  result.ok = cost.Evaluate(parameters.data(), residuals.data(), jacobians.data());
  result.cost = 0.5 * residuals.squaredNorm();
  result.gradient = jacobian.transpose() * residuals;
  result.hessian = jacobian.transpose() * jacobian;
  return result;
}

FitEvaluator::RecordingResult FitEvaluator::EvaluateRecording(int recording, const Eigen::VectorXd& coordinates,
                                                              Derivative derivative, Precision precision) const {
  const Eigen::VectorXd own = problem_->CoordinatesOf(recording, coordinates);
  if (derivative == Derivative::kRows) return EvaluateRows(recording, own, precision);
  RecordingResult result;
  const bool with_gradient = derivative == Derivative::kGradient;
  result.ok = problem_->cost(recording, precision)
                  .EvaluateGradient(own, &result.cost, with_gradient ? &result.gradient : nullptr);
  return result;
}

bool FitEvaluator::ForEachRecording(const std::function<bool(int recording)>& work) {
  const auto start = std::chrono::steady_clock::now();
  const int num_recordings = problem_->num_recordings();
  std::vector<char> ok(static_cast<std::size_t>(num_recordings));
  EvaluationTracker* const tracker = problem_->tracker();
  if (tracker != nullptr) tracker->Begin(purpose_);
  ParallelFor(num_recordings, num_threads_, [&](int recording) {
    ok[recording] = work(recording) ? 1 : 0;
    if (tracker != nullptr) tracker->End(recording);
  });
  seconds_ += std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  const auto failed = std::find(ok.begin(), ok.end(), 0);
  if (failed == ok.end()) return true;
  ++num_failures_;
  last_failure_ = problem_->cost(static_cast<int>(failed - ok.begin())).last_failure();
  return false;
}

bool FitEvaluator::Evaluate(const Eigen::VectorXd& coordinates, Derivative derivative, double* cost,
                            Eigen::VectorXd* gradient, Precision precision) {
  std::vector<RecordingResult> results(static_cast<std::size_t>(problem_->num_recordings()));
  const bool ok = ForEachRecording([&](int recording) {
    results[recording] = EvaluateRecording(recording, coordinates, derivative, precision);
    return results[recording].ok;
  });
  if (!ok) return false;
  const QuadraticModel model = Sum(results, coordinates);
  *cost = model.cost;
  if (gradient != nullptr) *gradient = model.gradient;
  if (derivative == Derivative::kRows) model_ = model;
  Keep(coordinates, *cost, precision);
  if (derivative != Derivative::kNone && coordinates == best_.coordinates) best_gradient_norm_ = model.gradient.norm();
  return true;
}

QuadraticModel FitEvaluator::Sum(const std::vector<RecordingResult>& results,
                                 const Eigen::VectorXd& coordinates) const {
  const int num_blocks = problem_->num_blocks();
  QuadraticModel sum;
  sum.coordinates = coordinates;
  sum.gradient = Eigen::VectorXd::Zero(num_blocks);
  sum.hessian = Eigen::MatrixXd::Zero(num_blocks, num_blocks);
  for (int r = 0; r < problem_->num_recordings(); ++r) {
    const RecordingResult& result = results[r];
    const std::vector<int>& indices = problem_->block_indices(r);
    sum.cost += result.cost;
    if (result.gradient.size() > 0) sum.gradient(indices) += result.gradient;
    if (result.hessian.size() > 0) sum.hessian(indices, indices) += result.hessian;
  }
  return sum;
}

void FitEvaluator::Keep(const Eigen::VectorXd& coordinates, double cost, Precision precision) {
  if (best_.is_valid() && !best_is_superseded_ && !(cost < best_.cost)) return;
  best_is_superseded_ = false;
  best_.coordinates = coordinates;
  best_.cost = cost;
  best_gradient_norm_ = std::numeric_limits<double>::quiet_NaN();
  best_.predicted.resize(static_cast<std::size_t>(problem_->num_recordings()));
  best_.counts = RolloutCounts();
  for (int r = 0; r < problem_->num_recordings(); ++r) {
    RolloutCounts counts;
    problem_->cost(r, precision).Predict(problem_->CoordinatesOf(r, coordinates), &best_.predicted[r], &counts);
    best_.counts += counts;
  }
  if (!first_.is_valid()) first_ = best_;
}

bool FitEvaluator::Linearize(const Eigen::VectorXd& coordinates, Linearization* linearization) {
  const int num_recordings = problem_->num_recordings();
  std::vector<Eigen::MatrixXd> jacobians(static_cast<std::size_t>(num_recordings));
  std::vector<Eigen::VectorXd> residuals(static_cast<std::size_t>(num_recordings));
  std::vector<Eigen::MatrixXd> scores(static_cast<std::size_t>(num_recordings));
  const bool ok = ForEachRecording([&](int recording) {
    return problem_->cost(recording).Linearize(problem_->CoordinatesOf(recording, coordinates), &jacobians[recording],
                                               &residuals[recording], &scores[recording]);
  });
  if (!ok) return false;
  *linearization = Linearization();
  linearization->gradient = Eigen::VectorXd::Zero(coordinates.size());
  for (int r = 0; r < num_recordings; ++r) {
    Eigen::MatrixXd& all = linearization->jacobian;
    const Eigen::Index num_rows = all.rows();
    all.conservativeResize(num_rows + jacobians[r].rows(), coordinates.size());
    all.bottomRows(jacobians[r].rows()).setZero();
    all.bottomRows(jacobians[r].rows())(Eigen::all, problem_->block_indices(r)) = jacobians[r];
    linearization->gradient(problem_->block_indices(r)) += jacobians[r].transpose() * residuals[r];
    Eigen::MatrixXd& own = linearization->frame_scores.emplace_back();
    own.setZero(coordinates.size(), scores[r].cols());
    own(problem_->block_indices(r), Eigen::all) = scores[r];
    linearization->squared_residual += residuals[r].squaredNorm();
    linearization->num_measurements += problem_->cost(r).model().observation().num_residuals();
    linearization->sigma_is_known &= problem_->cost(r).model().observation().sigma_is_known();
  }
  return true;
}

CostStatistics FitEvaluator::statistics() const {
  CostStatistics since = Total(*problem_);
  since -= statistics_before_;
  return since;
}

}  // namespace clothid
