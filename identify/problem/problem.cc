#include "identify/problem/problem.h"

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <map>
#include <utility>

#include "costs/field/field_prior.h"
#include "costs/rows/evaluation_journal.h"
#include "identify/base/fingerprint.h"
#include "identify/problem/problem_blocks.h"
#include "identify/uncertainty/priors.h"
#include "sim/base/error.h"
#include "sim/base/phase_seconds.h"
#include "sim/base/text_file.h"

namespace clothid {
namespace {

// Columns of a forward sweep, one per parameter, with which it is still cheap. With more of them the adjoint starts
// alone.
constexpr int kFewBlocks = 12;

std::shared_ptr<EvaluationJournal> OpenJournal(const FitOptions& options, const std::string& fingerprint,
                                               int recording) {
  const std::string tag = options.journal_tag.empty() ? "" : options.journal_tag + "_";
  const std::string name = kJournalPrefix + tag + std::to_string(recording + 1) + ".bin";
  return std::make_shared<EvaluationJournal>((std::filesystem::path(options.journal_folder) / name).string(),
                                             fingerprint, options.journal_room);
}

std::shared_ptr<EvaluationTracker> MakeTracker(const ProgressObserver& observer) {
  return std::make_shared<EvaluationTracker>(observer, SteadySeconds);
}

// What the costs of all recordings share.
RolloutCostOptions CostOptions(const FitOptions& options) {
  RolloutCostOptions cost_options;
  cost_options.jacobian = options.jacobian;
  cost_options.adjoint = options.adjoint;
  cost_options.loss = options.loss;
  cost_options.fields = options.fields;
  cost_options.cancel = options.cancel;
  return cost_options;
}

}  // namespace

FitProblem::FitProblem(const std::vector<RecordedMotion>& motions, const FitOptions& options, const FitProblem* whole)
    : fields_(options.fields) {
  if (motions.empty()) throw Error(ErrorKind::kUsage, "--target: expected at least one recording");
  options.Validate();
  blocks_ = MakeBlocks(motions, options);
  if (options.on_progress) tracker_ = MakeTracker(options.on_progress);
  OpenJournals(motions, options, whole);
  for (const RecordedMotion& motion : motions) {
    RolloutCostOptions cost_options = CostOptions(options);
    cost_options.num_threads = std::max(1, options.num_threads / static_cast<int>(motions.size()));
    if (!journals_.empty()) cost_options.journal = journals_[num_recordings()];
    AddCost(motion, std::move(cost_options));
  }
  AddFieldIndices();
  AddSmoothness(options);
  if (options.assimilate.kind == AssimilationOption::Kind::kMemory) {
    for (const auto& cost : costs_) {
      const std::string reason = cost->model().WhyNotAssimilated();
      if (reason.empty()) continue;
      throw Error(ErrorKind::kUsage, "--assimilate: " + cost->model().name() + " " + reason + "; expected off or auto");
    }
    Assimilate(options.assimilate.given);
  }
  finds_model_error_ = options.weighs_model_error;
  if (!options.model_errors.empty()) SetModelErrors(options.model_errors);
}

void FitProblem::OpenJournals(const std::vector<RecordedMotion>& motions, const FitOptions& options,
                              const FitProblem* whole) {
  if (options.journal_folder.empty()) return;
  if (whole != nullptr) {
    journals_ = whole->journals_;
    return;
  }
  const std::string fingerprint = FitFingerprint(motions, blocks_, options);
  for (int r = 0; r < static_cast<int>(motions.size()); ++r) journals_.push_back(OpenJournal(options, fingerprint, r));
}

void FitProblem::AddCost(const RecordedMotion& motion, RolloutCostOptions cost_options) {
  std::vector<int> indices;
  std::vector<ParameterBlock> blocks;
  for (int i = 0; i < num_blocks(); ++i) {
    if (!Concerns(blocks_[i], motion, num_recordings())) continue;
    indices.push_back(i);
    blocks.push_back(blocks_[i]);
  }
  cost_options.starts_with_sensitivities = static_cast<int>(indices.size()) <= kFewBlocks;
  if (tracker_ != nullptr) {
    cost_options.on_step = [tracker = tracker_, recording = num_recordings()](const PassStep& step) {
      tracker->AddStep(recording, step);
    };
  }
  costs_.push_back(std::make_unique<RolloutCost>(motion, std::move(blocks), cost_options));
  loose_costs_.push_back(costs_.back()->AtPrecision(Precision::kLoose));
  if (tracker_ != nullptr) tracker_->AddRecording(costs_.back()->model().num_steps());
  block_indices_.push_back(indices);
  const int num_unknowns = costs_.back()->model().num_start_unknowns();
  for (int i = 0; i < num_unknowns; ++i) indices.push_back(num_coordinates() + i);
  num_start_unknowns_ += num_unknowns;
  coordinate_indices_.push_back(std::move(indices));
}

// They stand behind all starts.
void FitProblem::AddFieldIndices() {
  for (const FieldRequest& field : fields_) num_field_unknowns_ += field.size();
  for (std::vector<int>& indices : coordinate_indices_) {
    for (int i = 0; i < num_field_unknowns_; ++i) indices.push_back(num_blocks() + num_start_unknowns_ + i);
  }
}

void FitProblem::AddSmoothness(const FitOptions& options) {
  if (HasLinks(blocks_)) {
    const double smoothness = options.wind_smoothness;
    const Eigen::SparseMatrix<double> root = (smoothness * LinkRows(blocks_)).sparseView();
    smoothness_.push_back({kWindPrior, 0, root, 1.0 / (smoothness * smoothness), options.chooses_wind_smoothness});
  }
  if (num_field_unknowns_ == 0) return;
  smoothness_.push_back({kFieldPrior, num_blocks() + num_start_unknowns_, SmoothnessRoot(fields_), options.field_weight,
                         options.field_weight == 0.0});
}

MeasuredConstant FitProblem::MeasuredOf(int block) const {
  for (int r = 0; r < num_recordings(); ++r) {
    if (std::count(block_indices_[r].begin(), block_indices_[r].end(), block) == 0) continue;
    const MeasuredConstant* measured = MeasuredOfAnyCloth(blocks_[block].id.kind, costs_[r]->model().scene());
    return measured == nullptr ? MeasuredConstant() : *measured;
  }
  return {};
}

bool FitProblem::has_few_blocks() const {
  return std::all_of(block_indices_.begin(), block_indices_.end(),
                     [](const std::vector<int>& blocks) { return static_cast<int>(blocks.size()) <= kFewBlocks; });
}

void FitProblem::SetStart(const Eigen::VectorXd& coordinates) {
  for (int i = 0; i < num_blocks(); ++i) {
    // A start that stays keeps its last digit, which it would lose on the way through the coordinate.
    if (blocks_[i].ToCoordinate(blocks_[i].start) != coordinates[i])
      blocks_[i].start = blocks_[i].ToValue(coordinates[i]);
  }
  start_unknowns_ = coordinates.tail(coordinates.size() - num_blocks());
}

Eigen::VectorXd FitProblem::StartCoordinates() const {
  Eigen::VectorXd coordinates = Eigen::VectorXd::Zero(num_coordinates());
  for (int i = 0; i < num_blocks(); ++i) coordinates[i] = blocks_[i].ToCoordinate(blocks_[i].start);
  coordinates.tail(start_unknowns_.size()) = start_unknowns_;
  return coordinates;
}

Eigen::VectorXd FitProblem::Values(const Eigen::VectorXd& coordinates) const {
  Eigen::VectorXd values(num_blocks());
  for (int i = 0; i < num_blocks(); ++i) values[i] = blocks_[i].ToValue(coordinates[i]);
  return values;
}

Eigen::VectorXd FitProblem::CoordinatesOf(int recording, const Eigen::VectorXd& coordinates) const {
  if (coordinates.size() == num_coordinates()) return coordinates(coordinate_indices_[recording]);
  const std::vector<int>& indices = block_indices_[recording];
  Eigen::VectorXd own = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(coordinate_indices_[recording].size()));
  own.head(static_cast<Eigen::Index>(indices.size())) = coordinates(indices);
  return own;
}

void FitProblem::SetWeight(int prior, double weight) {
  SmoothnessPrior& own = smoothness_[prior];
  if (own.name == kWindPrior) {
    for (ParameterBlock& block : blocks_) block.link_spread *= std::sqrt(own.weight / weight);
  }
  own.weight = weight;
}

double FitProblem::WeightOf(const std::string& name) const {
  for (const SmoothnessPrior& prior : smoothness_) {
    if (prior.name == name) return prior.weight;
  }
  return 0.0;
}

bool FitProblem::chooses_weights() const {
  return std::any_of(smoothness_.begin(), smoothness_.end(),
                     [](const SmoothnessPrior& prior) { return prior.is_chosen && !prior.is_held; });
}

void FitProblem::HoldWeights(bool hold) {
  for (SmoothnessPrior& prior : smoothness_) prior.is_held = hold;
  holds_model_error_ = hold;
}

void FitProblem::TakeWeights(const FitProblem& other) {
  for (int i = 0; i < static_cast<int>(smoothness_.size()); ++i) {
    if (other.smoothness_[i].weight > 0.0) SetWeight(i, other.smoothness_[i].weight);
  }
}

FitOptions FitProblem::WithWeights(FitOptions options) const {
  options.field_weight = WeightOf(kFieldPrior);
  if (const double weight = WeightOf(kWindPrior); weight > 0.0) options.wind_smoothness = 1.0 / std::sqrt(weight);
  options.chooses_wind_smoothness = false;
  options.weighs_model_error = false;
  options.model_errors = model_errors();
  options.assimilate = assimilation_option();
  return options;
}

AssimilationOption FitProblem::assimilation_option() const {
  if (!assimilation_.is_on()) return {};
  return {AssimilationOption::Kind::kMemory, assimilation_};
}

void FitProblem::Assimilate(const Assimilation& assimilation) {
  assimilation_ = assimilation;
  for (const auto& cost : costs_) cost->Assimilate(assimilation);
}

void FitProblem::SetModelErrors(const std::vector<ModelError>& errors) {
  for (int r = 0; r < num_recordings(); ++r) costs_[r]->SetModelError(errors[r]);
}

std::vector<ModelError> FitProblem::model_errors() const {
  std::vector<ModelError> errors;
  for (const auto& cost : costs_) errors.push_back(cost->model().observation().model_error());
  return errors;
}

bool FitProblem::has_model_error() const {
  return std::any_of(costs_.begin(), costs_.end(),
                     [](const auto& cost) { return !cost->model().observation().model_error().is_zero(); });
}

Eigen::VectorXd FitProblem::PriorResiduals(const Eigen::VectorXd& coordinates) const {
  const Eigen::VectorXd of_blocks = clothid::PriorResiduals(blocks_, coordinates);
  const Eigen::VectorXd of_fields = FieldRows(coordinates.tail(num_unknowns()));
  Eigen::VectorXd residuals(of_blocks.size() + of_fields.size());
  residuals << of_blocks, of_fields;
  return residuals;
}

Eigen::MatrixXd FitProblem::PriorRows(const Eigen::MatrixXd& combinations) const {
  const Eigen::MatrixXd of_blocks = clothid::PriorRows(blocks_), of_fields = FieldRows(combinations);
  Eigen::MatrixXd rows =
      Eigen::MatrixXd::Zero(of_blocks.rows() + of_fields.rows(), of_blocks.cols() + of_fields.cols());
  rows.topLeftCorner(of_blocks.rows(), of_blocks.cols()) = of_blocks;
  rows.bottomRightCorner(of_fields.rows(), of_fields.cols()) = of_fields;
  return rows;
}

double FitProblem::PriorCost(const Eigen::VectorXd& coordinates) const {
  return 0.5 * PriorResiduals(coordinates).squaredNorm();
}

Eigen::VectorXd FitProblem::PriorGradient(const Eigen::VectorXd& coordinates) const {
  Eigen::VectorXd gradient = Eigen::VectorXd::Zero(num_coordinates());
  gradient.head(num_blocks()) = clothid::PriorGradient(blocks_, coordinates);
  if (num_field_unknowns_ > 0) {
    const SmoothnessPrior& of_fields = smoothness_.back();
    gradient.tail(num_field_unknowns_) =
        of_fields.weight * (of_fields.root.transpose() * (of_fields.root * coordinates.tail(num_field_unknowns_)));
  }
  return gradient;
}

Eigen::MatrixXd FitProblem::FieldRows(const Eigen::MatrixXd& combinations) const {
  if (num_field_unknowns_ == 0) return Eigen::MatrixXd(0, combinations.cols());
  const SmoothnessPrior& of_fields = smoothness_.back();
  return std::sqrt(of_fields.weight) * (of_fields.root * combinations.bottomRows(num_field_unknowns_));
}

Eigen::SparseMatrix<double> FitProblem::FieldPrecision() const {
  const SmoothnessPrior& of_fields = smoothness_.back();
  return of_fields.weight * Eigen::SparseMatrix<double>(of_fields.root.transpose() * of_fields.root);
}

void FitProblem::Restart() {
  for (const auto& cost : costs_) cost->Restart();
}

void FitProblem::Forget() {
  for (const auto& cost : costs_) cost->Forget();
}

void FitProblem::KeepOnly(const Eigen::VectorXd& coordinates) const {
  for (int r = 0; r < num_recordings(); ++r) cost(r).KeepOnly(CoordinatesOf(r, coordinates));
}

void FitProblem::CheckJournals() const {
  for (const auto& cost : costs_) cost->CheckJournal();
}

std::vector<int> FitProblem::free_blocks() const {
  std::vector<int> free;
  for (int i = 0; i < num_blocks(); ++i) {
    if (!blocks_[i].frozen) free.push_back(i);
  }
  return free;
}

bool IsHeld(const ParameterBlock& block, double coordinate, double gradient) {
  return (coordinate <= block.ToCoordinate(block.lower_bound) && gradient > 0.0) ||
         (coordinate >= block.ToCoordinate(block.upper_bound) && gradient < 0.0);
}

int FindFreeBlock(const FitProblem& problem, const std::string& name, const std::string& flag) {
  for (int i = 0; i < problem.num_blocks(); ++i) {
    if (problem.blocks()[i].name != name) continue;
    if (problem.blocks()[i].frozen) throw Error(ErrorKind::kUsage, flag + ": '" + name + "' is frozen by the scene");
    return i;
  }
  throw Error(ErrorKind::kUsage, flag + ": '" + name + "' is not among the fitted parameters");
}

}  // namespace clothid
