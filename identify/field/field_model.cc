#include "identify/field/field_model.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "identify/base/parallel_for.h"
#include "identify/field/field_prior.h"
#include "identify/fit/problem.h"
#include "sim/base/error.h"

namespace clothid {
namespace {

// Of each of the two rollouts that a step compares, bytes for its steps and as many for their factors.
constexpr std::size_t kRolloutMemory = std::size_t{512} << 20;

bool IsLevel(const ParameterBlock& block, const std::vector<FieldRequest>& requests) {
  return std::any_of(requests.begin(), requests.end(),
                     [&](const FieldRequest& request) { return request.name == BaseName(block.name); });
}

// The blocks that are unknowns beside the fields.
std::vector<int> ScalarsOf(const std::vector<ParameterBlock>& blocks, const std::vector<FieldRequest>& requests) {
  ExpectInCommon(blocks, requests);
  std::vector<int> scalars;
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    if (!IsLevel(blocks[i], requests) && !blocks[i].frozen) scalars.push_back(static_cast<int>(i));
  }
  return scalars;
}

}  // namespace

FieldModel::FieldModel(const std::vector<RecordedMotion>& motions, const std::vector<ParameterBlock>& blocks,
                       const std::vector<FieldRequest>& requests, const FitOptions& options)
    : blocks_(blocks),
      requests_(requests),
      scalars_(ScalarsOf(blocks, requests)),
      adjoint_(options.adjoint),
      loss_(options.loss),
      cancel_(options.cancel),
      num_threads_(options.num_threads) {
  root_ = SmoothnessRoot(requests);
  for (const FieldRequest& request : requests) {
    for (const GridField& field : motions.front().scene.fields) {
      if (field.kind == request.kind) start_levels_.push_back(field.values(0, 0));
    }
  }
  prior_ = root_.transpose() * root_;
  for (std::size_t r = 0; r < motions.size(); ++r) {
    const RecordedMotion& motion = motions[r];
    if (IsUnknown(motion.start_source)) {
      throw Error(
          ErrorKind::kUsage,
          "--field: " + motion.name + ": its start is unknown; expected a scene that states it, or --initial smoothed");
    }
    std::vector<ParameterBlock> own;
    std::vector<int>& indices = model_blocks_.emplace_back();
    for (std::size_t i = 0; i < blocks.size(); ++i) {
      if (IsLevel(blocks[i], requests) || !Concerns(blocks[i], motion, static_cast<int>(r))) continue;
      own.push_back(blocks[i]);
      indices.push_back(static_cast<int>(i));
    }
    models_.push_back(std::make_unique<RecordingModel>(motion, std::move(own), PassObserver()));
    std::vector<Eigen::SparseMatrix<double>>& weights = weights_.emplace_back();
    for (const FieldRequest& request : requests) {
      weights.push_back(ControlWeights(motion.scene.mesh, request.rows, request.columns, motion.name));
    }
  }
}

int FieldModel::num_measurements() const {
  int sum = 0;
  for (const auto& model : models_) sum += model->observation().num_residuals();
  return sum;
}

bool FieldModel::sigma_is_known() const {
  return std::all_of(models_.begin(), models_.end(),
                     [](const auto& model) { return model->observation().sigma_is_known(); });
}

Eigen::VectorXd FieldModel::Start() const {
  Eigen::VectorXd unknowns = Eigen::VectorXd::Zero(size());
  for (int i = 0; i < num_scalars(); ++i) unknowns[i] = blocks_[scalars_[i]].ToCoordinate(blocks_[scalars_[i]].start);
  return unknowns;
}

Eigen::MatrixXd FieldModel::ValuesOf(int field, const Eigen::VectorXd& unknowns) const {
  int first = num_scalars();
  for (int k = 0; k < field; ++k) first += requests_[k].size();
  const FieldRequest& request = requests_[field];
  const Eigen::VectorXd logs = unknowns.segment(first, request.size());
  return start_levels_[field] * logs.reshaped(request.columns, request.rows).transpose().array().exp();
}

Eigen::MatrixXd FieldModel::BlockWeights(std::vector<int>* free_blocks) const {
  const Eigen::VectorXd areas = TriangleAreas(models_.front()->scene().mesh);
  free_blocks->clear();
  Eigen::MatrixXd weights = Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(blocks_.size()), size());
  for (std::size_t i = 0; i < blocks_.size(); ++i) {
    if (blocks_[i].frozen) continue;
    const auto row = static_cast<Eigen::Index>(free_blocks->size());
    free_blocks->push_back(static_cast<int>(i));
    int first = num_scalars();
    for (std::size_t k = 0; k < requests_.size(); ++k) {
      if (BaseName(blocks_[i].name) == requests_[k].name) {
        weights.row(row).segment(first, requests_[k].size()) =
            (weights_.front()[k].transpose() * areas / areas.sum()).transpose();
      }
      first += requests_[k].size();
    }
    const auto scalar = std::find(scalars_.begin(), scalars_.end(), static_cast<int>(i));
    if (scalar != scalars_.end()) weights(row, scalar - scalars_.begin()) = 1.0;
  }
  return weights.topRows(static_cast<Eigen::Index>(free_blocks->size()));
}

Eigen::VectorXd FieldModel::BlockCoordinates(const Eigen::VectorXd& unknowns) const {
  std::vector<int> free_blocks;
  const Eigen::VectorXd moved = BlockWeights(&free_blocks) * unknowns;
  Eigen::VectorXd coordinates(static_cast<Eigen::Index>(blocks_.size()));
  for (std::size_t i = 0; i < blocks_.size(); ++i) {
    coordinates[static_cast<Eigen::Index>(i)] = blocks_[i].ToCoordinate(blocks_[i].start);
  }
  for (std::size_t j = 0; j < free_blocks.size(); ++j) {
    const ParameterBlock& block = blocks_[free_blocks[j]];
    double& coordinate = coordinates[free_blocks[j]];
    coordinate = moved[static_cast<Eigen::Index>(j)] + (IsLevel(block, requests_) ? coordinate : 0.0);
  }
  return coordinates;
}

Eigen::VectorXd FieldModel::CoordinatesOf(int recording, const Eigen::VectorXd& unknowns) const {
  const std::vector<int>& indices = model_blocks_[recording];
  Eigen::VectorXd coordinates(static_cast<Eigen::Index>(indices.size()));
  for (std::size_t i = 0; i < indices.size(); ++i) {
    const ParameterBlock& block = blocks_[indices[i]];
    const auto scalar = std::find(scalars_.begin(), scalars_.end(), indices[i]);
    coordinates[static_cast<Eigen::Index>(i)] =
        scalar == scalars_.end() ? block.ToCoordinate(block.start) : unknowns[scalar - scalars_.begin()];
  }
  return coordinates;
}

Eigen::MatrixXd FieldModel::OverTriangles(int recording, const Eigen::MatrixXd& theta) const {
  const std::vector<GridField>& fields = models_[recording]->scene().fields;
  const int num_faces = models_[recording]->scene().mesh.num_faces();
  Eigen::MatrixXd all = Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(fields.size()) * num_faces, theta.cols());
  int first = 0;
  for (std::size_t k = 0; k < requests_.size(); ++k) {
    for (std::size_t f = 0; f < fields.size(); ++f) {
      if (fields[f].kind != requests_[k].kind) continue;
      all.middleRows(static_cast<Eigen::Index>(f) * num_faces, num_faces) =
          weights_[recording][k] * theta.middleRows(first, requests_[k].size());
    }
    first += requests_[k].size();
  }
  return all;
}

void FieldModel::ForEachRecording(const std::function<void(int recording)>& work) const {
  ParallelFor(num_recordings(), num_threads_, work);
}

void FieldModel::Simulate(int recording, const Eigen::VectorXd& unknowns, Precision precision,
                          FieldRecordingPoint* at) {
  RecordingModel& model = *models_[recording];
  at->coordinates = CoordinatesOf(recording, unknowns);
  const Eigen::VectorXd logs = OverTriangles(recording, unknowns.tail(num_field_unknowns()));
  auto fields = std::make_shared<std::vector<FieldFactors>>(*model.scene().nominal_parameters().fields);
  const int num_faces = model.scene().mesh.num_faces();
  for (std::size_t f = 0; f < fields->size(); ++f) {
    (*fields)[f].log_factors += logs.segment(static_cast<Eigen::Index>(f) * num_faces, num_faces);
  }
  model.SetFields(std::move(fields));
  at->rollout = model.Simulate(at->coordinates, {precision, cancel_, 1}, {kRolloutMemory, /*keep_factors=*/true},
                               &at->predicted, &at->velocities, &at->forces);
  if (at->rollout.ok()) at->cost = CostOfPrediction(loss_, model.observation(), at->predicted, at->forces.predicted);
}

bool FieldModel::MoveTo(const Eigen::VectorXd& unknowns, Precision precision, FieldPoint* point) {
  point->unknowns = unknowns;
  point->precision = precision;
  point->data_cost = 0.0;
  point->recordings.clear();
  point->recordings.resize(models_.size());
  counts_.rollouts += num_recordings();
  ForEachRecording([&](int r) { Simulate(r, unknowns, precision, &point->recordings[r]); });
  for (int r = 0; r < num_recordings(); ++r) {
    const FieldRecordingPoint& at = point->recordings[r];
    if (!at.rollout.ok()) {
      failure_ = models_[r]->name() + ": " + at.rollout.failure->ToString();
      return false;
    }
    point->data_cost += at.cost.value;
  }
  failure_ = std::isfinite(point->data_cost) ? "" : "the cost is not finite";
  return failure_.empty();
}

}  // namespace clothid
