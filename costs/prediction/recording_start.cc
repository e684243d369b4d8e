// The part of RecordingModel that is about starts and handles: what a rollout has in place of the scene's, and the
// derivatives along that.
#include <utility>
#include <vector>

#include "costs/prediction/recording_model.h"
#include "sim/cloth/cloth_model.h"

namespace clothid {
namespace {

// [3N x q]: in every column each of N vectors is one of the unit vectors `axes` [q].
Eigen::MatrixXd AlongAxes(Eigen::Index num_vectors, const std::vector<int>& axes) {
  Eigen::MatrixXd columns(3 * num_vectors, static_cast<Eigen::Index>(axes.size()));
  for (std::size_t i = 0; i < axes.size(); ++i) {
    columns.col(static_cast<Eigen::Index>(i)) = Eigen::Vector3d::Unit(axes[i]).replicate(num_vectors, 1);
  }
  return columns;
}

// Zero columns before those of `columns`, if it has any.
void PutBehind(Eigen::Index num_columns, Eigen::MatrixXd* columns) {
  if (columns->cols() == 0 || num_columns == 0) return;
  Eigen::MatrixXd wider = Eigen::MatrixXd::Zero(columns->rows(), num_columns + columns->cols());
  wider.rightCols(columns->cols()) = *columns;
  *columns = std::move(wider);
}

// Sets the columns from `first` on. `all` may be empty: it then gets `num_columns`, the others zero.
void SetColumns(const Eigen::MatrixXd& columns, Eigen::Index first, Eigen::Index num_columns, Eigen::MatrixXd* all) {
  if (columns.cols() == 0) return;
  if (all->cols() == 0) *all = Eigen::MatrixXd::Zero(columns.rows(), num_columns);
  all->middleCols(first, columns.cols()) = columns;
}

}  // namespace

RecordingModel::RolloutStart RecordingModel::StartAt(const Eigen::VectorXd& coordinates) const {
  RolloutStart start;
  if (start_ != nullptr) {
    const Eigen::VectorXd unknowns = StartUnknowns(coordinates);
    start.positions = start_->PositionsAt(unknowns);
    start.velocities = start_->VelocitiesAt(unknowns);
    start.handle_offsets = start_->HandleOffsetsAt(unknowns);
  }
  if (handle_correction_) MoveHandles(values_.AlignmentAt(coordinates), &start);
  if (values_.Find(ParameterTerm::kStart) == nullptr) return start;
  const Eigen::Vector3d velocity = values_.AlignmentAt(coordinates).start_velocity;
  if (!start.velocities) start.velocities = scene().initial_velocities;
  for (int node : simulator_.model().free_nodes()) start.velocities->segment<3>(3 * node) += velocity;
  return start;
}

void RecordingModel::MoveHandles(const Alignment& alignment, RolloutStart* start) const {
  const std::vector<int>& nodes = scene().handles.nodes;
  const HandlePath moved = handle_correction_->OffsetsAt(alignment, nullptr);
  const Eigen::VectorXd at_start = moved.At(scene().start_time);
  if (!start->positions) start->positions = scene().initial_positions;
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    start->positions->segment<3>(3 * nodes[i]) += at_start.segment<3>(3 * static_cast<Eigen::Index>(i));
  }
  start->handle_offsets =
      start->handle_offsets ? handle_correction_->OffsetsAt(alignment, &*start->handle_offsets) : moved;
}

SensitivityDirections RecordingModel::DirectionsOf(const Eigen::VectorXd& coordinates, const SortedBlocks& blocks,
                                                   const Eigen::MatrixXd& combinations) const {
  SensitivityDirections directions;
  const auto num_axes = static_cast<Eigen::Index>(blocks.velocity_axes.size());
  const auto num_first = num_axes + static_cast<Eigen::Index>(blocks.handles.size());
  const Eigen::Index num_columns = num_first + combinations.cols();
  if (combinations.cols() > 0) {
    if (start_ != nullptr) directions = start_->DirectionsAlong(combinations.topRows(num_start_unknowns()));
    if (fields_) directions.fields = fields_->OverTriangles(combinations.bottomRows(num_field_unknowns()));
    PutBehind(num_first, &directions.initial_positions);
    PutBehind(num_first, &directions.initial_velocities);
    PutBehind(num_first, &directions.handle_offsets);
    PutBehind(num_first, &directions.fields);
  }
  directions.parameters = blocks.parameters;
  SetColumns(AlongAxes(observation_.num_nodes(), blocks.velocity_axes), 0, num_columns, &directions.initial_velocities);
  if (blocks.handles.empty()) return directions;
  SetColumns(handle_correction_->Columns(values_.AlignmentAt(coordinates), blocks.handles), num_axes, num_columns,
             &directions.handle_offsets);
  return directions;
}

void RecordingModel::SetStartRows(const RolloutGradient& gradient, const Eigen::VectorXd& coordinates,
                                  const SortedBlocks& active, Eigen::MatrixXd* all) const {
  if (!active.velocity_places.empty()) {
    (*all)(active.velocity_places, Eigen::all) =
        AlongAxes(observation_.num_nodes(), active.velocity_axes).transpose() * gradient.initial_velocities;
  }
  if (!active.handle_places.empty()) {
    (*all)(active.handle_places, Eigen::all) =
        handle_correction_->Columns(values_.AlignmentAt(coordinates), active.handles).transpose() *
        gradient.handle_offsets;
  }
  if (!active.start_places.empty()) (*all)(active.start_places, Eigen::all) = start_->PullBack(gradient);
}

}  // namespace clothid
