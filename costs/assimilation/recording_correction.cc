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
// The same beside points that are compared with the surface, which tell a node one direction.
constexpr double kUnseenBySurface = 1e-3;

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
    : influence_(std::move(influence)), clouds_(observation.clouds()), free_nodes_(model.free_nodes()) {
  const std::vector<FrameStencil>& stencils = observation.stencils();
  double last_time = model.scene().start_time;
  for (int i = 0; i < observation.num_frames();) {
    const int step = stencils[i].last_step(), first = i;
    while (i < observation.num_frames() && stencils[i].last_step() == step) ++i;
    const bool is_seen = observation.first_row(first) < observation.first_cloud_row(i - 1) + clouds_.num_rows(i - 1);
    if (step < 1 || !is_seen || !(times[i - 1] > last_time) || times[i - 1] > assimilation.until) continue;
    AddStep(observation, first, i, GainsOver(times[i - 1] - last_time, assimilation.memory));
    last_time = times[i - 1];
  }
  FactorSmoothing(observation, assimilation.smoothing.value_or(std::sqrt(model.node_areas().mean())), model);
}

void RecordingCorrection::AddStep(const Observation& observation, int first_frame, int end_frame,
                                  const CorrectionGains& gains) {
  CorrectedStep own;
  own.step = observation.stencils()[first_frame].last_step();
  own.gains = gains;
  own.share = 1.0 / (end_frame - first_frame);
  std::vector<int> rows;  // of the residual
  for (int frame = first_frame; frame < end_frame; ++frame) {
    if (clouds_.num_rows(frame) > 0) {
      const FrameStencil& stencil = observation.stencils()[frame];
      own.surface_frames.push_back(
          {frame, stencil.size > 1 ? stencil.weights[0] : 0.0, stencil.weight(stencil.last_step())});
    }
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
  own.has_start = (own.of_start.array() != 0.0).any();
  own.points.resize(num_rows, 3 * observation.num_nodes());
  own.points.setFromTriplets(entries.begin(), entries.end());
  steps_.push_back(std::move(own));
}

void RecordingCorrection::FactorSmoothing(const Observation& observation, double smoothing, const ClothModel& model) {
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
  const double unseen = clouds_.empty() ? kUnseen : kUnseenBySurface;
  for (Eigen::Index i = 0; i < matrix.rows(); ++i) matrix.coeffRef(i, i) += unseen;
  factor_.compute(matrix);
  if (factor_.info() != Eigen::Success) throw std::runtime_error("the smoothing of corrections has no factor");
  if (!clouds_.empty()) KeepInOrder(matrix, model.scene().mesh);
}

// Pairs change K from step to step, and join its axes: its order need not be found again, and it has the places of all.
void RecordingCorrection::KeepInOrder(const Eigen::SparseMatrix<double>& matrix, const Mesh& mesh) {
  const Eigen::PermutationMatrix<Eigen::Dynamic, Eigen::Dynamic, int> order = factor_.permutationP();
  std::vector<int> nodes(free_nodes_.size());
  places_.assign(static_cast<std::size_t>(mesh.num_nodes()), -1);
  for (std::size_t i = 0; i < free_nodes_.size(); ++i) {
    const int place = order.indices()[static_cast<Eigen::Index>(i)];
    nodes[static_cast<std::size_t>(place)] = free_nodes_[i];
    places_[free_nodes_[i]] = place;
  }
  free_nodes_ = std::move(nodes);
  faces_ = mesh.faces;
  const Eigen::SparseMatrix<double> ordered = order * matrix * order.transpose();
  factor_.compute(ordered);
  std::vector<Eigen::Triplet<double>> entries;
  for (Eigen::Index column = 0; column < ordered.outerSize(); ++column) {
    for (Eigen::SparseMatrix<double>::InnerIterator entry(ordered, column); entry; ++entry) {
      for (int axis = 0; axis < 3; ++axis) {
        entries.emplace_back(3 * static_cast<int>(entry.row()) + axis, 3 * static_cast<int>(column) + axis,
                             entry.value());
      }
    }
  }
  for (const auto& corners : faces_.colwise()) {
    for (int i = 0; i < 9; ++i) {
      const int row = places_[corners[i / 3]], column = places_[corners[i % 3]];
      for (int k = 0; row >= 0 && column >= 0 && k < 9; ++k) {
        entries.emplace_back(3 * row + k / 3, 3 * column + k % 3, 0.0);
      }
    }
  }
  Eigen::SparseMatrix<double> all(3 * matrix.rows(), 3 * matrix.cols());
  all.setFromTriplets(entries.begin(), entries.end());
  matrix_ = all.triangularView<Eigen::Lower>();
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

RecordingCorrection::StepPairs RecordingCorrection::Pair(const CorrectedStep& step, const StepEnds& ends) const {
  StepPairs pairs;
  if (step.surface_frames.empty()) return pairs;
  Eigen::SparseMatrix<double> matrix = matrix_;
  for (const SurfaceFrame& own : step.surface_frames) {
    const Eigen::VectorXd nodes = own.of_start * ends.start + own.of_end * ends.end;
    pairs.frames.emplace_back(clouds_, own.frame, &faces_, nodes, step.share, influence_);
    pairs.frames.back().AddMatrix([&](int row, int column, const Eigen::Matrix3d& block) {
      const int i = places_[row], k = places_[column];
      if (k < 0 || i < k) return;
      for (int b = 0; b < 3; ++b) {
        for (int a = i == k ? b : 0; a < 3; ++a) matrix.coeffRef(3 * i + a, 3 * k + b) += block(a, b);
      }
    });
  }
  auto factor = std::make_unique<OrderedFactor>();
  factor->compute(matrix);
  if (factor->info() != Eigen::Success) throw std::runtime_error("the smoothing of corrections has no factor");
  pairs.factor = std::move(factor);
  return pairs;
}

RecordingCorrection::StepPairs RecordingCorrection::PairWithDerivatives(const CorrectedStep& step,
                                                                        const StepEnds& ends) const {
  StepPairs pairs = Pair(step, ends);
  if (pairs.frames.empty()) return pairs;
  const Eigen::VectorXd solution = Smooth(pairs, RightSide(step, ends, pairs));
  for (SurfacePairs& own : pairs.frames) own.SetSolution(solution);
  return pairs;
}

Eigen::VectorXd RecordingCorrection::RightSide(const CorrectedStep& step, const StepEnds& ends,
                                               const StepPairs& pairs) const {
  Eigen::VectorXd right = step.share * (step.points.transpose() * Counted(step, Innovations(step, ends)));
  for (const SurfacePairs& own : pairs.frames) own.AddRight(&right);
  return right;
}

Eigen::MatrixXd RecordingCorrection::Smooth(const StepPairs& pairs, const Eigen::MatrixXd& columns) const {
  const auto num_free = static_cast<Eigen::Index>(free_nodes_.size());
  if (pairs.factor) return SmoothTogether(*pairs.factor, columns);
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

Eigen::MatrixXd RecordingCorrection::SmoothTogether(const OrderedFactor& factor, const Eigen::MatrixXd& columns) const {
  const auto num_free = static_cast<Eigen::Index>(free_nodes_.size());
  Eigen::MatrixXd gathered(3 * num_free, columns.cols());
  for (Eigen::Index i = 0; i < num_free; ++i) {
    gathered.middleRows<3>(3 * i) = columns.middleRows<3>(3 * free_nodes_[i]);
  }
  gathered = factor.solve(gathered).eval();
  Eigen::MatrixXd smooth = Eigen::MatrixXd::Zero(columns.rows(), columns.cols());
  for (Eigen::Index i = 0; i < num_free; ++i) {
    smooth.middleRows<3>(3 * free_nodes_[i]) = gathered.middleRows<3>(3 * i);
  }
  return smooth;
}

void RecordingCorrection::Evaluate(int step, const StepEnds& ends, Eigen::VectorXd* positions,
                                   Eigen::VectorXd* velocities) const {
  const CorrectedStep& own = At(step);
  const StepPairs pairs = Pair(own, ends);
  const Eigen::VectorXd spread = Smooth(pairs, RightSide(own, ends, pairs));
  *positions = own.gains.positions * spread;
  *velocities = own.gains.velocities * spread;
}

void RecordingCorrection::Times(int step, const StepEnds& ends, const Eigen::MatrixXd& start_changes,
                                const Eigen::MatrixXd& end_changes, Eigen::MatrixXd* positions,
                                Eigen::MatrixXd* velocities) const {
  const CorrectedStep& own = At(step);
  const StepPairs pairs = PairWithDerivatives(own, ends);
  Eigen::MatrixXd rows = -Predicted(own, start_changes, end_changes);
  TimesSlopes(own, Innovations(own, ends), &rows);
  Eigen::MatrixXd right = own.share * (own.points.transpose() * rows);
  for (std::size_t i = 0; i < pairs.frames.size(); ++i) {
    const SurfaceFrame& frame = own.surface_frames[i];
    pairs.frames[i].AddTimes(frame.of_start * start_changes + frame.of_end * end_changes, &right);
  }
  const Eigen::MatrixXd spread = Smooth(pairs, right);
  *positions = own.gains.positions * spread;
  *velocities = own.gains.velocities * spread;
}

void RecordingCorrection::TimesTransposed(int step, const StepEnds& ends, const Eigen::MatrixXd& by_positions,
                                          const Eigen::MatrixXd& by_velocities, Eigen::MatrixXd* by_start,
                                          Eigen::MatrixXd* by_end) const {
  const CorrectedStep& own = At(step);
  const StepPairs pairs = PairWithDerivatives(own, ends);
  const Eigen::MatrixXd by_right =
      Smooth(pairs, own.gains.positions * by_positions + own.gains.velocities * by_velocities);
  Eigen::MatrixXd seeds = -own.share * (own.points * by_right);
  TimesSlopes(own, Innovations(own, ends), &seeds);
  *by_end = own.points.transpose() * (own.of_end.asDiagonal() * seeds);
  by_start->setZero(by_positions.rows(), by_positions.cols());
  if (own.has_start) *by_start = own.points.transpose() * (own.of_start.asDiagonal() * seeds);
  for (std::size_t i = 0; i < pairs.frames.size(); ++i) {
    const SurfaceFrame& frame = own.surface_frames[i];
    Eigen::MatrixXd by_nodes = Eigen::MatrixXd::Zero(by_positions.rows(), by_positions.cols());
    pairs.frames[i].AddTimesTransposed(by_right, &by_nodes);
    *by_end += frame.of_end * by_nodes;
    *by_start += frame.of_start * by_nodes;
  }
}

}  // namespace clothid
