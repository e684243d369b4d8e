#include "identify/fit/evaluator.h"

#include <algorithm>
#include <chrono>
#include <iomanip>
#include <sstream>

#include "identify/base/parallel_for.h"
#include "identify/uncertainty/priors.h"

namespace clothid {
namespace {

CostStatistics Total(const FitProblem& problem) {
  CostStatistics sum;
  for (int r = 0; r < problem.num_recordings(); ++r) sum += problem.cost(r).statistics();
  return sum;
}

bool HasRows(FitEvaluator::Derivative derivative) {
  return derivative == FitEvaluator::Derivative::kRows || derivative == FitEvaluator::Derivative::kExactRows;
}

}  // namespace

FitEvaluator::FitEvaluator(const FitProblem* problem, int num_threads, EvaluationPurpose purpose)
    : problem_(problem), num_threads_(num_threads), purpose_(purpose), statistics_before_(Total(*problem)) {}

FitEvaluator::RecordingResult FitEvaluator::EvaluateRows(int recording, const Eigen::VectorXd& coordinates,
                                                         Precision precision) const {
  const RolloutCost& cost = problem_->cost(recording, precision);
  const std::vector<int>& indices = problem_->block_indices(recording);
  Eigen::VectorXd residuals(cost.num_residuals());
  const auto num_blocks = static_cast<Eigen::Index>(indices.size());
  Eigen::MatrixXd jacobian = Eigen::MatrixXd::Zero(cost.num_residuals(), num_blocks);
  std::vector<const double*> parameters;
  std::vector<double*> jacobians;
  for (Eigen::Index i = 0; i < num_blocks; ++i) {
    parameters.push_back(coordinates.data() + i);
    jacobians.push_back(problem_->blocks()[indices[i]].frozen ? nullptr : jacobian.col(i).data());
  }
  parameters.push_back(coordinates.data() + num_blocks);  // of an unknown start
  jacobians.push_back(nullptr);
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
  RecordingResult result;
  if (derivative == Derivative::kExactRows) {
    Eigen::MatrixXd jacobian;
    Eigen::VectorXd residuals;
    if (!problem_->cost(recording, precision).Linearize(own, &jacobian, &residuals)) return result;
  }
  if (HasRows(derivative)) return EvaluateRows(recording, own, precision);
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
  if (!ok) {
    last_failure_ += PlaceText(coordinates);
    return false;
  }
  const QuadraticModel model = Sum(results, coordinates, derivative);
  *cost = model.cost;
  if (gradient != nullptr) *gradient = model.gradient;
  if (HasRows(derivative)) model_ = model;
  Keep(coordinates, *cost, precision);
  if (derivative != Derivative::kNone && coordinates == best_.coordinates) best_gradient_norm_ = model.gradient.norm();
  return true;
}

QuadraticModel FitEvaluator::Sum(const std::vector<RecordingResult>& results, const Eigen::VectorXd& coordinates,
                                 Derivative derivative) const {
  const int num_blocks = problem_->num_blocks();
  QuadraticModel sum;
  sum.coordinates = coordinates;
  sum.gradient = Eigen::VectorXd::Zero(derivative == Derivative::kGradient ? problem_->num_coordinates() : num_blocks);
  sum.hessian = Eigen::MatrixXd::Zero(num_blocks, num_blocks);
  for (int r = 0; r < problem_->num_recordings(); ++r) {
    const RecordingResult& result = results[r];
    const std::vector<int>& blocks = problem_->block_indices(r);
    sum.cost += result.cost;
    if (derivative == Derivative::kGradient) sum.gradient(problem_->coordinate_indices(r)) += result.gradient;
    if (!HasRows(derivative)) continue;
    sum.gradient(blocks) += result.gradient;
    sum.hessian(blocks, blocks) += result.hessian;
  }
  AddPriors(derivative, &sum);
  return sum;
}

void FitEvaluator::AddPriors(Derivative derivative, QuadraticModel* sum) const {
  const std::vector<ParameterBlock>& blocks = problem_->blocks();
  if (!HasPriors(blocks) && !HasLinks(blocks)) return;
  sum->cost += PriorCost(blocks, sum->coordinates);
  if (derivative == Derivative::kNone) return;
  const Eigen::VectorXd gradient = PriorGradient(blocks, sum->coordinates);
  Eigen::MatrixXd hessian;
  if (HasRows(derivative)) hessian = PriorHessian(blocks);
  for (int i = 0; i < problem_->num_blocks(); ++i) {
    if (blocks[i].frozen) continue;
    sum->gradient[i] += gradient[i];
    for (int j = 0; j < static_cast<int>(hessian.cols()); ++j) {
      if (!blocks[j].frozen) sum->hessian(i, j) += hessian(i, j);
    }
  }
}

std::string FitEvaluator::PlaceText(const Eigen::VectorXd& coordinates) const {
  constexpr int kHandful = 6;
  std::ostringstream text;
  text << std::setprecision(4);
  const Eigen::VectorXd values = problem_->Values(coordinates);
  for (int i = 0; i < problem_->num_blocks(); ++i) {
    const MeasuredConstant measured = problem_->MeasuredOf(i);
    const bool is_far = measured.IsFarFrom(values[i]);
    if (problem_->blocks()[i].frozen || (problem_->num_blocks() > kHandful && !is_far)) continue;
    text << (text.tellp() == 0 ? ", at " : ", ") << problem_->blocks()[i].name << " " << values[i];
    if (is_far) {
      text << " " << measured.unit << " (" << measured.lowest << " to " << measured.highest << " " << measured.unit
           << " were measured of cloth)";
    }
  }
  return text.str();
}

void FitEvaluator::Keep(const Eigen::VectorXd& coordinates, double cost, Precision precision) {
  if (best_.is_valid() && !best_is_superseded_ && !(cost < best_.cost)) return;
  best_is_superseded_ = false;
  best_.coordinates = coordinates;
  best_.cost = cost;
  best_gradient_norm_ = std::numeric_limits<double>::quiet_NaN();
  best_.predicted.resize(static_cast<std::size_t>(problem_->num_recordings()));
  best_.forces.resize(best_.predicted.size());
  best_.counts = RolloutCounts();
  for (int r = 0; r < problem_->num_recordings(); ++r) {
    RolloutCounts counts;
    problem_->cost(r, precision)
        .Predict(problem_->CoordinatesOf(r, coordinates), &best_.predicted[r], &counts, &best_.forces[r]);
    best_.counts += counts;
  }
  if (!first_.is_valid()) first_ = best_;
}

Linearization FitEvaluator::Collect(const std::vector<RecordingLinearization>& parts,
                                    const std::vector<std::vector<int>>& indices, Eigen::Index num_columns) const {
  Linearization sum;
  sum.gradient = Eigen::VectorXd::Zero(num_columns);
  for (std::size_t r = 0; r < parts.size(); ++r) {
    const RecordingLinearization& part = parts[r];
    const Observation& observation = problem_->cost(static_cast<int>(r)).model().observation();
    const Eigen::Index num_rows = sum.jacobian.rows();
    sum.jacobian.conservativeResize(num_rows + part.jacobian.rows(), num_columns);
    sum.jacobian.bottomRows(part.jacobian.rows()).setZero();
    sum.jacobian.bottomRows(part.jacobian.rows())(Eigen::all, indices[r]) = part.jacobian;
    sum.gradient(indices[r]) += part.jacobian.transpose() * part.residuals;
    Eigen::MatrixXd& own = sum.frame_scores.emplace_back();
    own.setZero(num_columns, part.frame_scores.cols());
    own(indices[r], Eigen::all) = part.frame_scores;
    sum.squared_residual += part.residuals.squaredNorm();
    sum.num_measurements += observation.num_residuals();
    sum.sigma_is_known &= observation.sigma_is_known();
  }
  return sum;
}

bool FitEvaluator::Linearize(const Eigen::VectorXd& coordinates, Linearization* linearization, Precision precision) {
  std::vector<RecordingLinearization> parts(static_cast<std::size_t>(problem_->num_recordings()));
  std::vector<std::vector<int>> indices;
  for (int r = 0; r < problem_->num_recordings(); ++r) indices.push_back(problem_->coordinate_indices(r));
  const bool ok = ForEachRecording([&](int r) {
    return problem_->cost(r, precision)
        .Linearize(problem_->CoordinatesOf(r, coordinates), &parts[r].jacobian, &parts[r].residuals,
                   &parts[r].frame_scores);
  });
  if (ok) *linearization = Collect(parts, indices, problem_->num_coordinates());
  return ok;
}

bool FitEvaluator::LinearizeAlong(const Eigen::VectorXd& coordinates, const Eigen::MatrixXd& follow,
                                  Linearization* linearization) {
  std::vector<RecordingLinearization> parts(static_cast<std::size_t>(problem_->num_recordings()));
  std::vector<std::vector<int>> indices;
  std::vector<Eigen::MatrixXd> own_follow;
  Eigen::Index first = 0;
  for (int r = 0; r < problem_->num_recordings(); ++r) {
    indices.push_back(problem_->block_indices(r));
    const int num_unknowns = problem_->cost(r).model().num_start_unknowns();
    own_follow.push_back(follow.middleRows(first, num_unknowns)(Eigen::all, indices.back()));
    first += num_unknowns;
  }
  const bool ok = ForEachRecording([&](int r) {
    return problem_->cost(r).LinearizeAlong(problem_->CoordinatesOf(r, coordinates), own_follow[r], &parts[r].jacobian,
                                            &parts[r].residuals, &parts[r].frame_scores);
  });
  if (ok) *linearization = Collect(parts, indices, problem_->num_blocks());
  return ok;
}

CostStatistics FitEvaluator::statistics() const {
  CostStatistics since = Total(*problem_);
  since -= statistics_before_;
  return since;
}

}  // namespace clothid
