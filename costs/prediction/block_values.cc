#include "costs/prediction/block_values.h"

#include <utility>

namespace clothid {

BlockValues::BlockValues(std::vector<ParameterBlock> blocks, const Scene& scene)
    : blocks_(std::move(blocks)), start_(scene.nominal_parameters()) {
  for (const ParameterBlock& block : blocks_) {
    ids_.push_back(block.IdIn(scene));
    if (!IsOfRecording(ids_.back().kind)) SetParameter(ids_.back(), block.start, &start_);
  }
}

const ParameterBlock* BlockValues::Find(ParameterTerm term) const {
  for (std::size_t i = 0; i < blocks_.size(); ++i) {
    if (RowOf(ids_[i].kind).term == term) return &blocks_[i];
  }
  return nullptr;
}

const ParameterBlock* BlockValues::Find(ParameterKind kind) const {
  for (std::size_t i = 0; i < blocks_.size(); ++i) {
    if (ids_[i].kind == kind) return &blocks_[i];
  }
  return nullptr;
}

std::vector<ParameterId> BlockValues::IdsOf(ParameterTerm term) const {
  std::vector<ParameterId> ids;
  for (const ParameterId id : ids_) {
    if (RowOf(id.kind).term == term) ids.push_back(id);
  }
  return ids;
}

Parameters BlockValues::ParametersAt(const Eigen::VectorXd& coordinates) const {
  Parameters parameters = start_;
  for (std::size_t i = 0; i < blocks_.size(); ++i) {
    const double coordinate = coordinates[static_cast<Eigen::Index>(i)];
    if (!IsOfRecording(ids_[i].kind)) SetParameter(ids_[i], blocks_[i].ToValue(coordinate), &parameters);
  }
  return parameters;
}

Alignment BlockValues::AlignmentAt(const Eigen::VectorXd& coordinates) const {
  Alignment alignment;
  for (std::size_t i = 0; i < blocks_.size(); ++i) {
    const double coordinate = coordinates[static_cast<Eigen::Index>(i)];
    if (IsOfRecording(ids_[i].kind)) alignment.Set(ids_[i], blocks_[i].ToValue(coordinate));
  }
  return alignment;
}

Eigen::VectorXd BlockValues::DerivativesAt(const Eigen::VectorXd& coordinates, const std::vector<int>& active) const {
  Eigen::VectorXd derivatives = Eigen::VectorXd::Ones(static_cast<Eigen::Index>(active.size()));
  for (Eigen::Index i = 0; i < derivatives.size(); ++i) {
    if (active[i] < num_blocks()) derivatives[i] = blocks_[active[i]].ValueDerivative(coordinates[active[i]]);
  }
  return derivatives;
}

SortedBlocks BlockValues::Sort(const std::vector<int>& active, int num_start_unknowns) const {
  SortedBlocks sorted;
  for (int place = 0; place < static_cast<int>(active.size()); ++place) {
    if (active[place] >= num_blocks()) {
      const bool is_start = active[place] < num_blocks() + num_start_unknowns;
      (is_start ? sorted.start_places : sorted.field_places).push_back(place);
      continue;
    }
    const ParameterId id = ids_[active[place]];
    switch (RowOf(id.kind).term) {
      case ParameterTerm::kStart:
        sorted.velocity_axes.push_back(id.axis);
        sorted.velocity_places.push_back(place);
        break;
      case ParameterTerm::kHandles:
        sorted.handles.push_back(id);
        sorted.handle_places.push_back(place);
        break;
      default:
        (IsOfRecording(id.kind) ? sorted.corrections : sorted.parameters).push_back(id);
        (IsOfRecording(id.kind) ? sorted.correction_places : sorted.parameter_places).push_back(place);
    }
  }
  return sorted;
}

}  // namespace clothid
