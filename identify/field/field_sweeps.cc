// The sweeps of FieldModel, along rollouts that are at hand: gradient, and products with the Jacobian.
#include <algorithm>
#include <utility>

#include "identify/field/field_model.h"

namespace clothid {

FieldModel::ActiveScalars FieldModel::ScalarsIn(int recording) const {
  ActiveScalars active;
  for (std::size_t i = 0; i < model_blocks_[recording].size(); ++i) {
    const auto scalar = std::find(scalars_.begin(), scalars_.end(), model_blocks_[recording][i]);
    if (scalar == scalars_.end()) continue;
    active.blocks.push_back(static_cast<int>(i));
    active.places.push_back(static_cast<int>(scalar - scalars_.begin()));
  }
  return active;
}

Eigen::VectorXd FieldModel::Pull(int recording, const FieldRecordingPoint& at, const Eigen::VectorXd& seeds,
                                 Precision precision) {
  RecordingModel& model = *models_[recording];
  const ActiveScalars own = ScalarsIn(recording);
  Eigen::MatrixXd by_triangle;
  const Eigen::MatrixXd by_block = model.PullBack(at.rollout, at.predicted, at.velocities, at.coordinates, own.blocks,
                                                  seeds, adjoint_, precision, &by_triangle, &at.forces);
  Eigen::VectorXd gradient = Eigen::VectorXd::Zero(size());
  for (std::size_t i = 0; i < own.places.size(); ++i) {
    gradient[own.places[i]] = by_block(static_cast<Eigen::Index>(i), 0);
  }
  const std::vector<GridField>& fields = model.scene().fields;
  const int num_faces = model.scene().mesh.num_faces();
  int first = num_scalars();
  for (std::size_t k = 0; k < requests_.size(); ++k) {
    for (std::size_t f = 0; f < fields.size(); ++f) {
      if (fields[f].kind != requests_[k].kind) continue;
      gradient.segment(first, requests_[k].size()) =
          weights_[recording][k].transpose() *
          by_triangle.col(0).segment(static_cast<Eigen::Index>(f) * num_faces, num_faces);
    }
    first += requests_[k].size();
  }
  return gradient;
}

Eigen::VectorXd FieldModel::PullAll(const FieldPoint& point, Precision precision,
                                    const std::function<Eigen::VectorXd(int recording)>& seeds) {
  std::vector<Eigen::VectorXd> parts(models_.size());
  counts_.sweeps += num_recordings();
  ForEachRecording([&](int r) { parts[r] = Pull(r, point.recordings[r], seeds(r), precision); });
  Eigen::VectorXd sum = Eigen::VectorXd::Zero(size());
  for (const Eigen::VectorXd& part : parts) sum += part;
  return sum;
}

Eigen::VectorXd FieldModel::DataGradient(const FieldPoint& point) {
  return PullAll(point, point.precision, [&](int r) { return point.recordings[r].cost.Gradient(); });
}

Eigen::VectorXd FieldModel::TimesTransposed(const std::vector<Eigen::VectorXd>& rows, const FieldPoint& point) {
  return PullAll(point, Precision::kLoose,
                 [&](int r) { return rows[r].cwiseProduct(point.recordings[r].cost.weights); });
}

void FieldModel::SetScalarRows(FieldPoint* point) {
  if (num_scalars() == 0 || point->recordings.front().scalar_rows.size() > 0) return;
  counts_.sweeps += num_recordings();
  ForEachRecording([&](int r) { SetScalarRows(r, &point->recordings[r]); });
}

void FieldModel::SetScalarRows(int recording, FieldRecordingPoint* at) {
  const ActiveScalars own = ScalarsIn(recording);
  at->scalar_rows = Eigen::MatrixXd::Zero(at->cost.weights.size(), num_scalars());
  if (own.blocks.empty()) return;
  models_[recording]->PushForward(
      at->rollout, at->coordinates, own.blocks,
      [&](int frame, const Eigen::VectorXd&, const Eigen::VectorXd&, const Eigen::MatrixXd& jacobian) {
        const int row = observation(recording).first_row(frame);
        for (std::size_t i = 0; i < own.places.size(); ++i) {
          at->scalar_rows.col(own.places[i]).segment(row, jacobian.rows()) =
              at->cost.weights.segment(row, jacobian.rows()).cwiseProduct(jacobian.col(static_cast<Eigen::Index>(i)));
        }
      },
      Precision::kLoose);
}

void FieldModel::PushColumns(
    int recording, const Eigen::MatrixXd& columns, const FieldRecordingPoint& at,
    const std::function<void(int frame, Eigen::Index row, const Eigen::MatrixXd& part)>& visit) {
  models_[recording]->PushForwardFields(
      at.rollout, at.coordinates, OverTriangles(recording, columns.bottomRows(num_field_unknowns())),
      [&](int frame, const Eigen::VectorXd&, const Eigen::VectorXd&, const Eigen::MatrixXd& jacobian) {
        const int row = observation(recording).first_row(frame);
        Eigen::MatrixXd part = at.cost.weights.segment(row, jacobian.rows()).asDiagonal() * jacobian;
        if (num_scalars() > 0) part += at.scalar_rows.middleRows(row, jacobian.rows()) * columns.topRows(num_scalars());
        visit(frame, row, part);
      },
      Precision::kLoose);
}

std::vector<Eigen::VectorXd> FieldModel::Times(const Eigen::VectorXd& v, FieldPoint* point) {
  SetScalarRows(point);
  std::vector<Eigen::VectorXd> rows(models_.size());
  counts_.sweeps += num_recordings();
  ForEachRecording([&](int r) {
    const FieldRecordingPoint& at = point->recordings[r];
    rows[r].resize(at.cost.weights.size());
    PushColumns(r, v, at, [&](int, Eigen::Index row, const Eigen::MatrixXd& part) {
      rows[r].segment(row, part.rows()) = part.col(0);
    });
  });
  return rows;
}

Eigen::MatrixXd FieldModel::Gram(const Eigen::MatrixXd& columns, FieldPoint* point,
                                 std::vector<Eigen::MatrixXd>* frame_scores) {
  SetScalarRows(point);
  std::vector<Eigen::MatrixXd> grams(models_.size()), scores(models_.size());
  counts_.sweeps += num_recordings();
  ForEachRecording([&](int r) {
    const FieldRecordingPoint& at = point->recordings[r];
    const Eigen::VectorXd residuals = at.cost.WeightedResiduals();
    grams[r] = Eigen::MatrixXd::Zero(columns.cols(), columns.cols());
    scores[r].setZero(columns.cols(), observation(r).num_frames());
    PushColumns(r, columns, at, [&](int frame, Eigen::Index row, const Eigen::MatrixXd& part) {
      grams[r].selfadjointView<Eigen::Lower>().rankUpdate(part.transpose());
      // Forces count with the frame that is nearest in time.
      const int reading = frame - observation(r).num_frames();
      const int score = reading < 0 ? frame : observation(r).forces().nearest_frame(reading);
      scores[r].col(score) += part.transpose() * residuals.segment(row, part.rows());
    });
  });
  Eigen::MatrixXd gram = Eigen::MatrixXd::Zero(columns.cols(), columns.cols());
  for (const Eigen::MatrixXd& own : grams) gram += own;
  if (frame_scores != nullptr) *frame_scores = std::move(scores);
  return gram.selfadjointView<Eigen::Lower>();
}

}  // namespace clothid
