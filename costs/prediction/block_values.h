// What parameter blocks are: parameters of the simulation, or of a recording itself; and their values at coordinates.
#ifndef CLOTHID_COSTS_PREDICTION_BLOCK_VALUES_H_
#define CLOTHID_COSTS_PREDICTION_BLOCK_VALUES_H_

#include <Eigen/Core>
#include <vector>

#include "costs/prediction/alignment.h"
#include "costs/prediction/parameter_block.h"
#include "sim/scene/parameters.h"
#include "sim/scene/scene.h"

namespace clothid {

// Some coordinates by what they are; each with its place in the list that they come from.
struct SortedBlocks {
  std::vector<ParameterId> parameters;  // of the simulation
  std::vector<int> parameter_places;
  std::vector<int> velocity_axes;  // of the start velocity
  std::vector<int> velocity_places;
  std::vector<ParameterId> handles;  // shifts and turns of the handles
  std::vector<int> handle_places;
  std::vector<ParameterId> corrections;  // all other parameters of the recording
  std::vector<int> correction_places;
  std::vector<int> start_places, field_places;  // of the unknowns that follow the blocks, in their order

  bool has_only_parameters() const {
    return velocity_places.empty() && handle_places.empty() && correction_places.empty();
  }
};

class BlockValues {
 public:
  // Every one must exist in the scene or be of a recording. Throws `Error` for others.
  BlockValues(std::vector<ParameterBlock> blocks, const Scene& scene);

  const std::vector<ParameterBlock>& blocks() const { return blocks_; }
  // The scene's nominal parameters with the starting values of the blocks.
  const Parameters& start() const { return start_; }
  int num_blocks() const { return static_cast<int>(blocks_.size()); }
  // The first block of a term, or of a kind; null where there is none.
  const ParameterBlock* Find(ParameterTerm term) const;
  const ParameterBlock* Find(ParameterKind kind) const;
  std::vector<ParameterId> IdsOf(ParameterTerm term) const;  // of all its blocks

  // `coordinates` [p], in the order of the blocks; what follows does not matter. What is no block is as at the start,
  // or zero.
  Parameters ParametersAt(const Eigen::VectorXd& coordinates) const;
  Alignment AlignmentAt(const Eigen::VectorXd& coordinates) const;
  // d value/d coordinate [q] of the blocks `active`; 1 for what follows the blocks.
  Eigen::VectorXd DerivativesAt(const Eigen::VectorXd& coordinates, const std::vector<int>& active) const;
  // `num_start_unknowns`: how many of those that follow the blocks are of the start.
  SortedBlocks Sort(const std::vector<int>& active, int num_start_unknowns = 0) const;

 private:
  std::vector<ParameterBlock> blocks_;
  std::vector<ParameterId> ids_;  // of the blocks, in the scene
  Parameters start_;
};

}  // namespace clothid

#endif  // CLOTHID_COSTS_PREDICTION_BLOCK_VALUES_H_
