#include "costs/prediction/block_values.h"

#include <string>
#include <utility>

namespace clothid {

BlockValues::BlockValues(std::vector<ParameterBlock> blocks, const Scene& scene)
    : blocks_(std::move(blocks)), start_(scene.nominal_parameters()) {
  for (const ParameterBlock& block : blocks_) {
    const std::string name = BaseName(block.name);
    alignment_ids_.push_back(ParseAlignmentId(name));
    ids_.push_back(alignment_ids_.back() ? ParameterId() : ParseParameter(name, scene));
    if (!alignment_ids_.back()) SetParameter(ids_.back(), block.start, &start_);
  }
}

const ParameterBlock* BlockValues::Find(AlignmentKind kind) const {
  for (std::size_t i = 0; i < blocks_.size(); ++i) {
    if (alignment_ids_[i] && alignment_ids_[i]->kind == kind) return &blocks_[i];
  }
  return nullptr;
}

const ParameterBlock* BlockValues::FindSize() const {
  for (std::size_t i = 0; i < blocks_.size(); ++i) {
    if (!alignment_ids_[i] && IsSize(ids_[i].kind)) return &blocks_[i];
  }
  return nullptr;
}

std::vector<ParameterId> BlockValues::SizeIds() const {
  std::vector<ParameterId> ids;
  for (std::size_t i = 0; i < blocks_.size(); ++i) {
    if (!alignment_ids_[i] && IsSize(ids_[i].kind)) ids.push_back(ids_[i]);
  }
  return ids;
}

Parameters BlockValues::ParametersAt(const Eigen::VectorXd& coordinates) const {
  Parameters parameters = start_;
  for (std::size_t i = 0; i < blocks_.size(); ++i) {
    const double coordinate = coordinates[static_cast<Eigen::Index>(i)];
    if (!alignment_ids_[i]) SetParameter(ids_[i], blocks_[i].ToValue(coordinate), &parameters);
  }
  return parameters;
}

Alignment BlockValues::AlignmentAt(const Eigen::VectorXd& coordinates) const {
  Alignment alignment;
  for (std::size_t i = 0; i < blocks_.size(); ++i) {
    const double coordinate = coordinates[static_cast<Eigen::Index>(i)];
    if (alignment_ids_[i]) alignment.Set(*alignment_ids_[i], blocks_[i].ToValue(coordinate));
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
    const std::optional<AlignmentId>& id = alignment_ids_[active[place]];
    if (!id) {
      sorted.parameters.push_back(ids_[active[place]]);
      sorted.parameter_places.push_back(place);
    } else if (id->kind == AlignmentKind::kStartVelocity) {
      sorted.velocity_axes.push_back(id->axis);
      sorted.velocity_places.push_back(place);
    } else if (id->kind == AlignmentKind::kHandleShift || id->kind == AlignmentKind::kHandleTurn) {
      sorted.handles.push_back(*id);
      sorted.handle_places.push_back(place);
    } else {
      sorted.corrections.push_back(*id);
      sorted.correction_places.push_back(place);
    }
  }
  return sorted;
}

}  // namespace clothid
