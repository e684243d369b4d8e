#include "costs/assimilation/recording_correction.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "sim/shell/triangle_element.h"

namespace clothid {
namespace {

// Of the diagonal, where nothing of a piece of cloth is ever seen: it stays where it is.
constexpr double kUnseen = 1e-9;

// P of all points that have a row, as a sum over one axis: [P' x N].
Eigen::SparseMatrix<double> SeenPoints(const Observation& observation) {
  std::vector<bool> is_seen(static_cast<std::size_t>(observation.num_points()), false);
  for (const SeenCoordinate& seen : observation.coordinates()) {
    if (seen.point < observation.num_points()) is_seen[seen.point] = true;
  }
  std::vector<Eigen::Triplet<double>> entries;
  for (int p = 0; p < observation.num_points(); ++p) {
    const ObservedPoint& point = observation.points()[p];
    for (int k = 0; is_seen[p] && k < point.num_nodes; ++k) entries.emplace_back(p, point.nodes[k], point.weights[k]);
  }
  Eigen::SparseMatrix<double> points(observation.num_points(), observation.num_nodes());
  points.setFromTriplets(entries.begin(), entries.end());
  return points;
}

// From the values of `nodes` to those of all [N x n].
Eigen::SparseMatrix<double> Selection(const std::vector<int>& nodes, int num_nodes) {
  Eigen::SparseMatrix<double> selection(num_nodes, static_cast<Eigen::Index>(nodes.size()));
  std::vector<Eigen::Triplet<double>> entries;
  for (std::size_t i = 0; i < nodes.size(); ++i) entries.emplace_back(nodes[i], static_cast<int>(i), 1.0);
  selection.setFromTriplets(entries.begin(), entries.end());
  return selection;
}

}  // namespace

RecordingCorrection::RecordingCorrection(const Assimilation& assimilation, InfluenceOf influence,
                                         const Observation& observation, const Eigen::VectorXd& times,
                                         const ClothModel& model)
    : influence_(std::move(influence)), free_nodes_(model.free_nodes()) {
  const std::vector<FrameStencil>& stencils = observation.stencils();
  double last_time = model.scene().start_time;
  for (int i = 0; i < observation.num_frames();) {
    const int step = stencils[i].last_step(), first = i;
    while (i < observation.num_frames() && stencils[i].last_step() == step) ++i;
    const bool is_seen = observation.first_row(first) < observation.first_cloud_row(i - 1);
    if (step < 1 || !is_seen || !(times[i - 1] > last_time) || times[i - 1] > assimilation.until) continue;
    AddStep(observation, first, i, GainsOver(times[i - 1] - last_time, assimilation.memory));
    last_time = times[i - 1];
  }
  Factor(observation, assimilation.smoothing.value_or(std::sqrt(model.node_areas().mean())), model);
}

void RecordingCorrection::AddStep(const Observation& observation, int first_frame, int end_frame,
                                  const CorrectionGains& gains) {
  CorrectedStep own;
  own.step = observation.stencils()[first_frame].last_step();
  own.gains = gains;
  own.share = 1.0 / (end_frame - first_frame);
  std::vector<int> rows;  // of the residual
  for (int frame = first_frame; frame < end_frame; ++frame) {
    for (int row = observation.first_row(frame); row < observation.first_cloud_row(frame); ++row) {
      const SeenCoordinate& seen = observation.coordinates()[row];
      const bool goes_on = !rows.empty() && observation.coordinates()[rows.back()].frame == frame &&
                           observation.coordinates()[rows.back()].point == seen.point;
      if (!goes_on) own.first_rows.push_back(static_cast<int>(rows.size()));
      rows.push_back(row);
    }
  }
  const auto num_rows = static_cast<Eigen::Index>(rows.size());
  own.first_rows.push_back(static_cast<int>(num_rows));
  own.measured.resize(num_rows);
  own.sigma.resize(num_rows);
  own.of_start.setZero(num_rows);
  own.of_end.resize(num_rows);
  std::vector<Eigen::Triplet<double>> entries;
  for (Eigen::Index i = 0; i < num_rows; ++i) {
    const SeenCoordinate& seen = observation.coordinates()[rows[i]];
    const ObservedPoint& point = observation.points()[seen.point];
    for (int k = 0; k < point.num_nodes; ++k) {
      entries.emplace_back(static_cast<int>(i), 3 * point.nodes[k] + seen.axis, point.weights[k]);
    }
    own.sigma[i] = observation.sigma(seen);
    own.measured[i] = observation.whitened_measured()[rows[i]] * own.sigma[i];
    const FrameStencil& stencil = observation.stencils()[seen.frame];
    own.of_end[i] = stencil.weight(stencil.last_step());
    if (stencil.size > 1) own.of_start[i] = stencil.weights[0];
  }
  own.has_start = own.of_start.cwiseAbs().maxCoeff() > 0.0;
  own.points.resize(num_rows, 3 * observation.num_nodes());
  own.points.setFromTriplets(entries.begin(), entries.end());
  steps_.push_back(std::move(own));
}

void RecordingCorrection::Factor(const Observation& observation, double smoothing, const ClothModel& model) {
  const int num_nodes = model.num_nodes();
  const Eigen::SparseMatrix<double> free = Selection(free_nodes_, num_nodes);
  const Eigen::SparseMatrix<double> seen = SeenPoints(observation) * free;
  Eigen::SparseMatrix<double> matrix = seen.transpose() * seen;
  if (smoothing > 0.0) {
    const Eigen::SparseMatrix<double> all = LaplacianMatrix(model.triangles(), num_nodes);
    const Eigen::SparseMatrix<double> laplacian = free.transpose() * all * free;
    const Eigen::VectorXd areas = free.transpose() * model.node_areas();
    const Eigen::SparseMatrix<double> squared =
        laplacian.transpose() * Eigen::SparseMatrix<double>(areas.cwiseInverse().asDiagonal() * laplacian);
    matrix += std::pow(smoothing, 4) / model.node_areas().mean() * squared;
  }
  for (Eigen::Index i = 0; i < matrix.rows(); ++i) matrix.coeffRef(i, i) += kUnseen;
  factor_.compute(matrix);
  if (factor_.info() != Eigen::Success) throw std::runtime_error("the smoothing of corrections has no factor");
}

const RecordingCorrection::CorrectedStep* RecordingCorrection::Find(int step) const {
  const auto found = std::lower_bound(steps_.begin(), steps_.end(), step,
                                      [](const CorrectedStep& own, int value) { return own.step < value; });
  return found != steps_.end() && found->step == step ? &*found : nullptr;
}

Eigen::MatrixXd RecordingCorrection::Predicted(const CorrectedStep& step, const Eigen::MatrixXd& start,
                                               const Eigen::MatrixXd& end) {
  Eigen::MatrixXd predicted = step.of_end.asDiagonal() * (step.points * end);
  if (step.has_start) predicted += step.of_start.asDiagonal() * (step.points * start);
  return predicted;
}

Eigen::VectorXd RecordingCorrection::Innovations(const CorrectedStep& step, const StepEnds& ends) {
  return step.measured - Predicted(step, ends.start, ends.end).col(0);
}

Eigen::VectorXd RecordingCorrection::Counted(const CorrectedStep& step, const Eigen::VectorXd& innovations) const {
  if (!influence_) return innovations;
  Eigen::VectorXd counted = innovations;
  for (std::size_t p = 0; p + 1 < step.first_rows.size(); ++p) {
    const int first = step.first_rows[p], size = step.first_rows[p + 1] - first;
    const double squared = innovations.segment(first, size).squaredNorm() / std::pow(step.sigma[first], 2);
    counted.segment(first, size) *= influence_(squared).factor;
  }
  return counted;
}

void RecordingCorrection::TimesSlopes(const CorrectedStep& step, const Eigen::VectorXd& innovations,
                                      Eigen::MatrixXd* rows) const {
  if (!influence_) return;
  for (std::size_t p = 0; p + 1 < step.first_rows.size(); ++p) {
    const int first = step.first_rows[p], size = step.first_rows[p + 1] - first;
    const auto innovation = innovations.segment(first, size);
    const double variance = std::pow(step.sigma[first], 2);
    const Influence influence = influence_(innovation.squaredNorm() / variance);
    const Eigen::RowVectorXd along = innovation.transpose() * rows->middleRows(first, size);
    rows->middleRows(first, size) *= influence.factor;
    rows->middleRows(first, size) += (2.0 * influence.slope / variance) * innovation * along;
  }
}

Eigen::MatrixXd RecordingCorrection::Smooth(const Eigen::MatrixXd& columns) const {
  const auto num_free = static_cast<Eigen::Index>(free_nodes_.size());
  Eigen::MatrixXd gathered(num_free, 3 * columns.cols());
  for (Eigen::Index c = 0; c < columns.cols(); ++c) {
    for (Eigen::Index i = 0; i < num_free; ++i) {
      for (int axis = 0; axis < 3; ++axis) gathered(i, 3 * c + axis) = columns(3 * free_nodes_[i] + axis, c);
    }
  }
  gathered = factor_.solve(gathered).eval();
  Eigen::MatrixXd smooth = Eigen::MatrixXd::Zero(columns.rows(), columns.cols());
  for (Eigen::Index c = 0; c < columns.cols(); ++c) {
    for (Eigen::Index i = 0; i < num_free; ++i) {
      for (int axis = 0; axis < 3; ++axis) smooth(3 * free_nodes_[i] + axis, c) = gathered(i, 3 * c + axis);
    }
  }
  return smooth;
}

Eigen::MatrixXd RecordingCorrection::Spread(const CorrectedStep& step, const Eigen::MatrixXd& rows) const {
  return Smooth(step.share * (step.points.transpose() * rows));
}

Eigen::MatrixXd RecordingCorrection::Gather(const CorrectedStep& step, const Eigen::MatrixXd& columns) const {
  return step.share * (step.points * Smooth(columns));
}

void RecordingCorrection::Evaluate(int step, const StepEnds& ends, Eigen::VectorXd* positions,
                                   Eigen::VectorXd* velocities) const {
  const CorrectedStep& own = At(step);
  const Eigen::VectorXd spread = Spread(own, Counted(own, Innovations(own, ends)));
  *positions = own.gains.positions * spread;
  *velocities = own.gains.velocities * spread;
}

void RecordingCorrection::Times(int step, const StepEnds& ends, const Eigen::MatrixXd& start_changes,
                                const Eigen::MatrixXd& end_changes, Eigen::MatrixXd* positions,
                                Eigen::MatrixXd* velocities) const {
  const CorrectedStep& own = At(step);
  Eigen::MatrixXd changes = -Predicted(own, start_changes, end_changes);
  TimesSlopes(own, Innovations(own, ends), &changes);
  const Eigen::MatrixXd spread = Spread(own, changes);
  *positions = own.gains.positions * spread;
  *velocities = own.gains.velocities * spread;
}

void RecordingCorrection::TimesTransposed(int step, const StepEnds& ends, const Eigen::MatrixXd& by_positions,
                                          const Eigen::MatrixXd& by_velocities, Eigen::MatrixXd* by_start,
                                          Eigen::MatrixXd* by_end) const {
  const CorrectedStep& own = At(step);
  Eigen::MatrixXd seeds = -Gather(own, own.gains.positions * by_positions + own.gains.velocities * by_velocities);
  TimesSlopes(own, Innovations(own, ends), &seeds);
  *by_end = own.points.transpose() * (own.of_end.asDiagonal() * seeds);
  by_start->setZero(by_positions.rows(), by_positions.cols());
  if (own.has_start) *by_start = own.points.transpose() * (own.of_start.asDiagonal() * seeds);
}

}  // namespace clothid
