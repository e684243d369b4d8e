// Recordings and fitted parameters as one least-squares problem.
#ifndef CLOTHID_IDENTIFY_FIT_PROBLEM_H_
#define CLOTHID_IDENTIFY_FIT_PROBLEM_H_

#include <ceres/cost_function.h>
#include <ceres/problem.h>

#include <Eigen/Core>
#include <memory>
#include <string>
#include <vector>

#include "costs/prediction/parameter_block.h"
#include "costs/rollout_cost.h"
#include "datasets/motion/recorded_motion.h"
#include "identify/base/options.h"

namespace clothid {

// One `RolloutCost` per recording; a parameter is one block, shared by every recording whose scene has it (`mu.NAME`
// may be in some scenes only), or, of `FitOptions::each`, one block per recording that has it.
//
// The prior of a block is one more residual, once for all recordings, and so is the link of a knot of the wind's
// profile to the knot before it (`FitOptions::wind_smoothness`).
//
// A point has the coordinates of the p blocks, and behind them, one recording after the other, the unknowns of those
// starts that are unknown (costs/start/unknown_start.h): [p + n]. Where a point has the blocks' coordinates alone [p],
// its starts are their bases.
class FitProblem {
 public:
  // Starting values and bounds of a shared parameter come from the first recording that has it. Throws `Error` for what
  // `MakeParameterBlock`, `RecordingModel` and `EvaluationJournal` reject, for overrides of parameters that are not
  // fitted, priors among them, and where every parameter is frozen.
  //
  // `whole`: a problem of the same recordings of which this one is a part, as a fit of their first frames is. Its
  // journals go on with what this one evaluates, in place of journals of its own. Null: none.
  FitProblem(const std::vector<RecordedMotion>& motions, const FitOptions& options, const FitProblem* whole = nullptr);

  const std::vector<ParameterBlock>& blocks() const { return blocks_; }
  // What was measured of any cloth of a block, in the first recording that it concerns.
  MeasuredConstant MeasuredOf(int block) const;
  int num_blocks() const { return static_cast<int>(blocks_.size()); }
  int num_recordings() const { return static_cast<int>(costs_.size()); }
  const RolloutCost& cost(int recording, Precision precision = Precision::kFull) const {
    return *(precision == Precision::kFull ? costs_ : loose_costs_)[recording];
  }
  // The blocks that the cost of a recording takes, in its order; and with its unknown start, all its coordinates.
  const std::vector<int>& block_indices(int recording) const { return block_indices_[recording]; }
  const std::vector<int>& coordinate_indices(int recording) const { return coordinate_indices_[recording]; }
  int num_coordinates() const { return num_blocks() + num_start_unknowns_; }
  int num_start_unknowns() const { return num_start_unknowns_; }
  // Whether no recording has so many blocks that a forward sweep takes much longer than a reverse one.
  bool has_few_blocks() const;

  // Where the next fit starts, and what it holds there. The coordinates, [p] or [p + n], must lie within the bounds.
  void SetStart(const Eigen::VectorXd& coordinates);
  void SetFrozen(int block, bool frozen) { blocks_[block].frozen = frozen; }

  // Internal coordinates [p + n], and those of the blocks back to values [p] in the parameters' own units.
  Eigen::VectorXd StartCoordinates() const;
  Eigen::VectorXd Values(const Eigen::VectorXd& coordinates) const;
  // Those of one recording.
  Eigen::VectorXd CoordinatesOf(int recording, const Eigen::VectorXd& coordinates) const;

  // What every cost does of that name.
  void Restart();
  void Forget();

  // Follows the evaluations; null where nobody asked for that.
  EvaluationTracker* tracker() const { return tracker_.get(); }

  // Throws the `Error` of the first journal that could not be used: evaluations have failed for that reason alone.
  void CheckJournals() const;

  // The Ceres problem on `coordinates` [p + n], whose memory it keeps and changes: costs of a precision, priors,
  // bounds, constant blocks, among them every unknown start. It does not own the costs and calls `callback` before each
  // evaluation.
  std::unique_ptr<ceres::Problem> MakeCeresProblem(ceres::EvaluationCallback* callback, Eigen::VectorXd* coordinates,
                                                   Precision precision = Precision::kFull);

 private:
  // Of the next recording, with the blocks that concern it.
  void AddCost(const RecordedMotion& motion, RolloutCostOptions cost_options);
  void OpenJournals(const std::vector<RecordedMotion>& motions, const FitOptions& options, const FitProblem* whole);

  std::vector<ParameterBlock> blocks_;
  std::shared_ptr<EvaluationTracker> tracker_;                // told by the costs, too
  std::vector<std::shared_ptr<EvaluationJournal>> journals_;  // per recording; empty: nothing is kept
  std::vector<std::unique_ptr<RolloutCost>> costs_;
  std::vector<std::unique_ptr<RolloutCost>> loose_costs_;  // the same with Precision::kLoose
  std::vector<std::vector<int>> block_indices_, coordinate_indices_;
  std::vector<std::unique_ptr<ceres::CostFunction>> priors_, links_;  // per block; null: none
  int num_start_unknowns_ = 0;
  Eigen::VectorXd start_unknowns_;  // where the next fit starts; empty: zero
};

// Whether parameter `name`, with or without the suffix of a recording, exists in `scene`: all but `mu.NAME` always do.
bool HasParameter(const Scene& scene, const std::string& name);

// Whether `block` is a parameter of `motion`, which is recording number `recording`, counted from 0.
bool Concerns(const ParameterBlock& block, const RecordedMotion& motion, int recording);

// The index of the block `name`. Throws `Error` (kUsage), naming `flag`, where it is not fitted or frozen.
int FindFreeBlock(const FitProblem& problem, const std::string& name, const std::string& flag);

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_FIT_PROBLEM_H_
