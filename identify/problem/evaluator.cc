#include "identify/problem/evaluator.h"

#include <algorithm>
#include <chrono>
#include <iomanip>
#include <sstream>
#include <utility>

#include "identify/base/parallel_for.h"

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

// Of results that have rows.
template <typename Results>
void StackRows(const FitProblem& problem, const Eigen::VectorXd& coordinates, const Results& results,
               EvaluatedRows* rows) {
  const Eigen::VectorXd believed = problem.PriorResiduals(coordinates);
  Eigen::Index num_rows = believed.size();
  for (const auto& result : results) num_rows += result.rows.residuals.size();
  rows->residuals.resize(num_rows);
  rows->jacobian.setZero(num_rows, problem.num_blocks());
  rows->residuals.head(believed.size()) = believed;
  rows->jacobian.topRows(believed.size()) =
      problem.PriorRows(Eigen::MatrixXd(problem.num_unknowns(), 0)).leftCols(problem.num_blocks());
  for (int i = 0; i < problem.num_blocks(); ++i) {
    if (problem.blocks()[i].frozen) rows->jacobian.col(i).setZero();
  }
  Eigen::Index first = believed.size();
  for (int r = 0; r < problem.num_recordings(); ++r) {
    const EvaluatedRows& own = results[r].rows;
    rows->residuals.segment(first, own.residuals.size()) = own.residuals;
    rows->jacobian.middleRows(first, own.residuals.size())(Eigen::all, problem.block_indices(r)) = own.jacobian;
    first += own.residuals.size();
  }
}

// The columns of `combinations` that move an unknown of `rows`.
std::vector<int> MovingColumns(const Eigen::MatrixXd& combinations, const std::vector<int>& rows) {
  std::vector<int> columns;
  for (int i = 0; i < static_cast<int>(combinations.cols()); ++i) {
    const bool moves = std::any_of(rows.begin(), rows.end(), [&](int row) { return combinations(row, i) != 0.0; });
    if (moves) columns.push_back(i);
  }
  return columns;
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
  for (const double* at = coordinates.data() + num_blocks; parameters.size() < cost.parameter_block_sizes().size();) {
    const int size = cost.parameter_block_sizes()[parameters.size()];  // of an unknown start, of fields
    parameters.push_back(at);
    jacobians.push_back(nullptr);
    at += size;
  }
  RecordingResult result;
  result.ok = cost.Evaluate(parameters.data(), residuals.data(), jacobians.data());
  result.cost = 0.5 * residuals.squaredNorm();
  result.rows = {std::move(residuals), std::move(jacobian)};
  return result;
}

FitEvaluator::RecordingResult FitEvaluator::EvaluateRecording(int recording, const Eigen::VectorXd& coordinates,
                                                              Derivative derivative, Precision precision) const {
  const Eigen::VectorXd own = problem_->CoordinatesOf(recording, coordinates);
  RecordingResult result;
  if (derivative == Derivative::kExactRows) {
    Eigen::MatrixXd jacobian;
    Eigen::VectorXd residuals;
    if (!problem_->cost(recording, precision).Linearize(own, {}, &jacobian, &residuals)) return result;
  }
  if (HasRows(derivative)) return EvaluateRows(recording, own, precision);
  if (derivative == Derivative::kNone && purpose_ != EvaluationPurpose::kFit) {
    result.ok = problem_->cost(recording, precision).EvaluateCost(own, &result.cost);
    return result;
  }
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
  Eigen::VectorXd sum;
  *cost = Sum(results, coordinates, derivative, &sum);
  if (gradient != nullptr) *gradient = sum;
  Keep(coordinates, *cost, precision);
  if (derivative != Derivative::kNone && coordinates == best_.coordinates) best_gradient_norm_ = sum.norm();
  return true;
}

double FitEvaluator::Sum(const std::vector<RecordingResult>& results, const Eigen::VectorXd& coordinates,
                         Derivative derivative, Eigen::VectorXd* gradient) {
  double cost = problem_->PriorCost(coordinates);
  for (const RecordingResult& result : results) cost += result.cost;
  if (derivative == Derivative::kGradient) {
    *gradient = problem_->PriorGradient(coordinates);
    for (int r = 0; r < problem_->num_recordings(); ++r) {
      (*gradient)(problem_->coordinate_indices(r)) += results[r].gradient;
    }
    for (int i = 0; i < problem_->num_blocks(); ++i) {
      if (problem_->blocks()[i].frozen) (*gradient)[i] = 0.0;
    }
  }
  if (!HasRows(derivative)) return cost;
  StackRows(*problem_, coordinates, results, &rows_);
  model_.coordinates = coordinates;
  model_.cost = cost;
  model_.gradient = rows_.jacobian.transpose() * rows_.residuals;
  model_.hessian = rows_.jacobian.transpose() * rows_.jacobian;
  *gradient = model_.gradient;
  return cost;
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

void FitEvaluator::SupersedeBest() {
  best_is_superseded_ = true;
  first_compares_ = false;
}

void FitEvaluator::SupersedeLoose() {
  if (best_.precision == Precision::kLoose) SupersedeBest();
}

void FitEvaluator::Keep(const Eigen::VectorXd& coordinates, double cost, Precision precision) {
  if (best_.is_valid() && !best_is_superseded_) {
    const bool is_better = precision == best_.precision ? cost < best_.cost : precision == Precision::kFull;
    if (!is_better) return;
  }
  best_is_superseded_ = false;
  best_ = PointOf(coordinates, cost, precision);
  best_gradient_norm_ = std::numeric_limits<double>::quiet_NaN();
  if (first_.is_valid()) return;
  first_ = best_;
  first_compares_ = precision == Precision::kFull;
}

FitPoint FitEvaluator::PointOf(const Eigen::VectorXd& coordinates, double cost, Precision precision) const {
  FitPoint point;
  point.coordinates = coordinates;
  point.cost = cost;
  point.precision = precision;
  if (purpose_ != EvaluationPurpose::kFit) return point;
  point.predicted.resize(static_cast<std::size_t>(problem_->num_recordings()));
  point.forces.resize(point.predicted.size());
  for (int r = 0; r < problem_->num_recordings(); ++r) {
    RolloutCounts counts;
    problem_->cost(r, precision)
        .Predict(problem_->CoordinatesOf(r, coordinates), &point.predicted[r], &counts, &point.forces[r]);
    point.counts += counts;
  }
  return point;
}

bool FitEvaluator::SetFirst(const Eigen::VectorXd& coordinates) {
  double cost = 0.0;
  if (!Evaluate(coordinates, Derivative::kNone, &cost, nullptr)) return false;
  first_ = PointOf(coordinates, cost, Precision::kFull);
  first_compares_ = true;
  return true;
}

bool FitEvaluator::LinearizeRecording(int recording, const Eigen::VectorXd& coordinates,
                                      const Eigen::MatrixXd& combinations, Precision precision,
                                      RecordingLinearization* part) const {
  const std::vector<int>& blocks = problem_->block_indices(recording);
  std::vector<int> unknowns;
  for (const int i : problem_->coordinate_indices(recording)) {
    if (i >= problem_->num_blocks()) unknowns.push_back(i - problem_->num_blocks());
  }
  const std::vector<int> columns = MovingColumns(combinations, unknowns);
  part->columns = blocks;
  for (const int column : columns) part->columns.push_back(problem_->num_blocks() + column);
  const Eigen::MatrixXd own = columns.empty() ? Eigen::MatrixXd() : Eigen::MatrixXd(combinations(unknowns, columns));
  return problem_->cost(recording, precision)
      .Linearize(problem_->CoordinatesOf(recording, coordinates), own, &part->jacobian, &part->residuals,
                 &part->frame_scores);
}

Linearization FitEvaluator::Collect(const std::vector<RecordingLinearization>& parts, Eigen::Index num_columns) const {
  Linearization sum;
  sum.gradient = Eigen::VectorXd::Zero(num_columns);
  for (std::size_t r = 0; r < parts.size(); ++r) {
    const RecordingLinearization& part = parts[r];
    const Observation& observation = problem_->cost(static_cast<int>(r)).model().observation();
    const Eigen::Index num_rows = sum.jacobian.rows();
    sum.jacobian.conservativeResize(num_rows + part.jacobian.rows(), num_columns);
    sum.jacobian.bottomRows(part.jacobian.rows()).setZero();
    sum.jacobian.bottomRows(part.jacobian.rows())(Eigen::all, part.columns) = part.jacobian;
    sum.gradient(part.columns) += part.jacobian.transpose() * part.residuals;
    Eigen::MatrixXd& own = sum.frame_scores.emplace_back();
    own.setZero(num_columns, part.frame_scores.cols());
    own(part.columns, Eigen::all) = part.frame_scores;
    sum.squared_residual += part.residuals.squaredNorm();
    sum.num_measurements += observation.num_residuals();
    sum.sigma_is_known &= observation.sigma_is_known();
  }
  return sum;
}

bool FitEvaluator::Linearize(const Eigen::VectorXd& coordinates, const Eigen::MatrixXd& combinations,
                             Linearization* linearization, Precision precision) {
  std::vector<RecordingLinearization> parts(static_cast<std::size_t>(problem_->num_recordings()));
  const bool ok =
      ForEachRecording([&](int r) { return LinearizeRecording(r, coordinates, combinations, precision, &parts[r]); });
  if (ok) *linearization = Collect(parts, problem_->num_blocks() + combinations.cols());
  return ok;
}

bool FitEvaluator::TimesCurvature(const Eigen::VectorXd& coordinates, const Eigen::VectorXd& direction,
                                  Eigen::VectorXd* product, Precision precision) {
  std::vector<Eigen::VectorXd> parts(static_cast<std::size_t>(problem_->num_recordings()));
  const bool ok = ForEachRecording([&](int r) {
    const RolloutCost& cost = problem_->cost(r, precision);
    const Eigen::VectorXd own = problem_->CoordinatesOf(r, direction);
    if (!cost.TimesCurvature(problem_->CoordinatesOf(r, coordinates), own, &parts[r])) return false;
    if (const UnknownStart* const start = cost.model().unknown_start()) {
      const Eigen::MatrixXd& prior = start->prior_jacobian();
      parts[r].segment(cost.model().num_blocks(), start->size()) +=
          prior.transpose() * (prior * cost.model().StartUnknowns(own));
    }
    return true;
  });
  if (ok) *product = SumOf(parts);
  return ok;
}

bool FitEvaluator::PullBackChange(const Eigen::VectorXd& coordinates, const std::vector<Eigen::MatrixXd>& changed,
                                  const std::vector<Eigen::MatrixXd>& forces, Eigen::VectorXd* product) {
  std::vector<Eigen::VectorXd> parts(static_cast<std::size_t>(problem_->num_recordings()));
  const bool ok = ForEachRecording([&](int r) {
    const Eigen::VectorXd own = problem_->CoordinatesOf(r, coordinates);
    return problem_->cost(r).PullBackChange(own, changed[r], forces[r], &parts[r]);
  });
  if (ok) *product = SumOf(parts);
  return ok;
}

Eigen::VectorXd FitEvaluator::SumOf(const std::vector<Eigen::VectorXd>& parts) const {
  Eigen::VectorXd sum = Eigen::VectorXd::Zero(problem_->num_coordinates());
  for (int r = 0; r < problem_->num_recordings(); ++r) sum(problem_->coordinate_indices(r)) += parts[r];
  return sum;
}

CostStatistics FitEvaluator::statistics() const {
  CostStatistics since = Total(*problem_);
  since -= statistics_before_;
  return since;
}

}  // namespace clothid
