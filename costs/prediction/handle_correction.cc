#include "costs/prediction/handle_correction.h"

#include <algorithm>
#include <utility>

#include "costs/prediction/rigid_correction.h"

namespace clothid {
namespace {

RigidCorrection TurnOf(const Alignment& alignment) {
  return RigidCorrection(alignment.handle_turn, Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero());
}

Eigen::VectorXd KnotsOf(const Scene& scene, const Eigen::VectorXd& own_knots, bool turns) {
  if (own_knots.size() > 0) return own_knots;
  return turns ? scene.handles.path.times() : Eigen::VectorXd::Constant(1, scene.start_time);
}

}  // namespace

HandleCorrection::HandleCorrection(const Scene& scene, std::vector<std::vector<int>> groups,
                                   const Eigen::VectorXd& own_knots, bool turns)
    : nodes_(scene.handles.nodes), groups_(std::move(groups)), knots_(KnotsOf(scene, own_knots, turns)) {
  const auto num_handles = static_cast<Eigen::Index>(nodes_.size());
  arms_.resize(3 * num_handles, knots_.size());
  for (Eigen::Index k = 0; k < knots_.size(); ++k) {
    const Eigen::VectorXd places = scene.handles.path.At(knots_[k]);
    const Eigen::Vector3d middle = places.reshaped(3, num_handles).rowwise().mean();
    arms_.col(k) = places - middle.replicate(num_handles, 1);
  }
}

bool HandleCorrection::IsIn(int group, int handle) const {
  if (group == kWhole) return true;
  if (group >= static_cast<int>(groups_.size())) return false;
  const std::vector<int>& nodes = groups_[static_cast<std::size_t>(group)];
  return std::find(nodes.begin(), nodes.end(), nodes_[static_cast<std::size_t>(handle)]) != nodes.end();
}

HandlePath HandleCorrection::OffsetsAt(const Alignment& alignment, const HandlePath* own) const {
  Eigen::MatrixXd offsets = Eigen::MatrixXd::Zero(arms_.rows(), arms_.cols());
  if (own != nullptr) offsets = own->positions();
  const RigidCorrection turn = TurnOf(alignment);
  if (!turn.is_identity()) offsets += turn.Rotate(arms_) - arms_;
  for (std::size_t i = 0; i < alignment.handle_shifts.size(); ++i) {
    for (int handle = 0; handle < static_cast<int>(nodes_.size()); ++handle) {
      if (!IsIn(static_cast<int>(i) - 1, handle)) continue;
      offsets.middleRows<3>(3 * static_cast<Eigen::Index>(handle)).colwise() += alignment.handle_shifts[i];
    }
  }
  return HandlePath(knots_, offsets);
}

Eigen::MatrixXd HandleCorrection::Columns(const Alignment& alignment, const std::vector<ParameterId>& ids) const {
  const RigidCorrection turn = TurnOf(alignment);
  const Eigen::VectorXd turned = turn.Rotate(arms_).reshaped();
  Eigen::MatrixXd columns = Eigen::MatrixXd::Zero(arms_.size(), static_cast<Eigen::Index>(ids.size()));
  for (std::size_t i = 0; i < ids.size(); ++i) {
    auto column = columns.col(static_cast<Eigen::Index>(i));
    if (ids[i].kind == ParameterKind::kHandleTurn) {
      column = turn.TurnDerivative(ids[i].axis, turned);
      continue;
    }
    for (Eigen::Index row = ids[i].axis; row < column.size(); row += 3) {
      const auto handle = static_cast<int>(row / 3 % static_cast<Eigen::Index>(nodes_.size()));
      if (IsIn(ids[i].part, handle)) column[row] = 1.0;
    }
  }
  return columns;
}

Scene WithHandlePath(Scene scene) {
  Handles& handles = scene.handles;
  if (handles.nodes.empty() || handles.path.num_handles() > 0) return scene;
  Eigen::VectorXd places(3 * static_cast<Eigen::Index>(handles.nodes.size()));
  for (std::size_t i = 0; i < handles.nodes.size(); ++i) {
    places.segment<3>(3 * static_cast<Eigen::Index>(i)) = scene.initial_positions.segment<3>(3 * handles.nodes[i]);
  }
  handles.path = HandlePath(Eigen::VectorXd::Constant(1, scene.start_time), places);
  return scene;
}

}  // namespace clothid
