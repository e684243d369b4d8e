// Recordings and everything that a fit estimates, as one least-squares problem.
#ifndef CLOTHID_IDENTIFY_PROBLEM_PROBLEM_H_
#define CLOTHID_IDENTIFY_PROBLEM_PROBLEM_H_

#include <Eigen/Core>
#include <Eigen/SparseCore>
#include <memory>
#include <string>
#include <vector>

#include "costs/field/field_request.h"
#include "costs/prediction/parameter_block.h"
#include "costs/rollout_cost.h"
#include "datasets/motion/recorded_motion.h"
#include "identify/base/evaluation_progress.h"
#include "identify/base/options.h"

namespace clothid {

// What is believed to be smooth:  weight/2 |R z|^2.
struct SmoothnessPrior {
  std::string name;                  // kWindPrior or kFieldPrior
  int first = 0;                     // coordinate that the first column of R belongs to
  Eigen::SparseMatrix<double> root;  // R [r x k] of the k coordinates from there on
  double weight = 0.0;               // 0: not chosen yet, and nothing is believed
  bool is_chosen = false;            // by the fit (identify/uncertainty/smoothness.h)
  bool is_held = false;              // it was, and is not again
};

// All unknowns are one vector z [p + n + f], in groups:
//   p parameters   a block each, shared by every recording whose scene has it (`mu.NAME` may be in some scenes
//                  only), or, of `FitOptions::each`, one block per recording that has it. With bounds, priors, and,
//                  of the knots of a wind, links to the knots before them.
//   n of starts    one recording after the other, of those whose start is unknown (costs/start/unknown_start.h). Their
//                  prior is part of the recording's cost.
//   f of fields    one field after the other (costs/field/field_unknowns.h), shared by all recordings, believed to be
//                  smooth. Their levels are parameters.
// Where a point has the p parameters alone, the starts are their bases and the fields are those of the scene.
//
// The cost is the sum of those of the recordings, one `RolloutCost` each, and of half the squares of
// `PriorResiduals`.
class FitProblem {
 public:
  // Throws `Error` for what `MakeBlocks`, `RecordingModel` and `EvaluationJournal` reject.
  //
  // `whole`: a problem of the same recordings of which this one is a part, as a fit of their first frames is. Its
  // journals go on with what this one evaluates, in place of journals of its own. Null: none.
  FitProblem(const std::vector<RecordedMotion>& motions, const FitOptions& options, const FitProblem* whole = nullptr);

  const std::vector<ParameterBlock>& blocks() const { return blocks_; }
  // What was measured of any cloth of a block, in the first recording that it concerns.
  MeasuredConstant MeasuredOf(int block) const;
  int num_blocks() const { return static_cast<int>(blocks_.size()); }  // p
  int num_recordings() const { return static_cast<int>(costs_.size()); }
  const RolloutCost& cost(int recording, Precision precision = Precision::kFull) const {
    return *(precision == Precision::kFull ? costs_ : loose_costs_)[recording];
  }
  // The blocks that the cost of a recording takes, in its order; and with its unknown start and the fields, all its
  // coordinates.
  const std::vector<int>& block_indices(int recording) const { return block_indices_[recording]; }
  const std::vector<int>& coordinate_indices(int recording) const { return coordinate_indices_[recording]; }
  int num_start_unknowns() const { return num_start_unknowns_; }  // n
  int num_field_unknowns() const { return num_field_unknowns_; }  // f
  int num_unknowns() const { return num_start_unknowns_ + num_field_unknowns_; }
  int num_coordinates() const { return num_blocks() + num_unknowns(); }
  const std::vector<FieldRequest>& fields() const { return fields_; }
  std::vector<int> free_blocks() const;  // not frozen
  bool is_all_frozen() const { return free_blocks().empty(); }
  // Whether no recording has so many blocks that a forward sweep takes much longer than a reverse one.
  bool has_few_blocks() const;

  // Where the next fit starts, and what it holds there. The coordinates [p] or [p + n + f] must lie within the bounds.
  void SetStart(const Eigen::VectorXd& coordinates);
  void SetFrozen(int block, bool frozen) { blocks_[block].frozen = frozen; }

  // Coordinates [p + n + f], and those of the blocks back to values [p] in the parameters' own units.
  Eigen::VectorXd StartCoordinates() const;
  Eigen::VectorXd Values(const Eigen::VectorXd& coordinates) const;
  // Those of one recording.
  Eigen::VectorXd CoordinatesOf(int recording, const Eigen::VectorXd& coordinates) const;

  // What is believed to be smooth, and its weight. That of a wind stands in the links of its knots, too.
  const std::vector<SmoothnessPrior>& smoothness() const { return smoothness_; }
  void SetWeight(int prior, double weight);
  // Of `smoothness`; 0 where there is none of that name.
  double WeightOf(const std::string& name) const;
  // Whether the fit is to choose a weight. Those of a problem whose weights are held it keeps: its costs compare.
  bool chooses_weights() const;
  void HoldWeights(bool hold);
  // Those of another problem with the same unknowns, to start with.
  void TakeWeights(const FitProblem& other);
  // `options` with the weights and the corrections of this problem, given: for a fit whose cost is to be compared with
  // one of this.
  FitOptions WithWeights(FitOptions options) const;

  // How far the model errs in every recording; they are weights, too: where these are held, so are they.
  void SetModelErrors(const std::vector<ModelError>& errors);
  std::vector<ModelError> model_errors() const;
  bool has_model_error() const;
  // What the model errs by leaves corrected rollouts again.
  bool finds_model_error() const { return finds_model_error_ && !holds_model_error_ && !assimilation_.is_on(); }

  // How the recordings correct the rollouts from now on; costs of before and of after do not compare. Starts that are
  // unknown then stay at their base, as the first frames correct them.
  void Assimilate(const Assimilation& assimilation);
  const Assimilation& assimilation() const { return assimilation_; }
  // What asks for the same of another fit.
  AssimilationOption assimilation_option() const;

  // Everything that is believed but of starts, a row each: the residuals at a point; their derivative with respect to
  // the blocks and combinations [(n + f) x c] of the other unknowns [rows x (p + c)]; half the sum of their squares;
  // its gradient [p + n + f].
  Eigen::VectorXd PriorResiduals(const Eigen::VectorXd& coordinates) const;
  Eigen::MatrixXd PriorRows(const Eigen::MatrixXd& combinations) const;
  double PriorCost(const Eigen::VectorXd& coordinates) const;
  Eigen::VectorXd PriorGradient(const Eigen::VectorXd& coordinates) const;
  // Of fields alone: the rows sqrt(weight) R `combinations` [rows x c], none without fields.
  Eigen::MatrixXd FieldRows(const Eigen::MatrixXd& combinations) const;
  // weight R^T R [f x f].
  Eigen::SparseMatrix<double> FieldPrecision() const;

  // What every cost does of that name.
  void Restart();
  void Forget();
  void KeepOnly(const Eigen::VectorXd& coordinates) const;  // [p + n + f]

  // Follows the evaluations; null where nobody asked for that.
  EvaluationTracker* tracker() const { return tracker_.get(); }

  // Throws the `Error` of the first journal that could not be used: evaluations have failed for that reason alone.
  void CheckJournals() const;

 private:
  // Of the next recording, with the blocks that concern it.
  void AddCost(const RecordedMotion& motion, RolloutCostOptions cost_options);
  void AddFieldIndices();
  void AddSmoothness(const FitOptions& options);
  void OpenJournals(const std::vector<RecordedMotion>& motions, const FitOptions& options, const FitProblem* whole);

  std::vector<ParameterBlock> blocks_;
  std::vector<FieldRequest> fields_;
  std::vector<SmoothnessPrior> smoothness_;
  std::shared_ptr<EvaluationTracker> tracker_;                // told by the costs, too
  std::vector<std::shared_ptr<EvaluationJournal>> journals_;  // per recording; empty: nothing is kept
  std::vector<std::unique_ptr<RolloutCost>> costs_;
  std::vector<std::unique_ptr<RolloutCost>> loose_costs_;  // the same with Precision::kLoose
  std::vector<std::vector<int>> block_indices_, coordinate_indices_;
  int num_start_unknowns_ = 0, num_field_unknowns_ = 0;
  Assimilation assimilation_;
  bool finds_model_error_ = false, holds_model_error_ = false;
  Eigen::VectorXd start_unknowns_;  // where the next fit starts; empty: zero
};

// The index of the block `name`. Throws `Error` (kUsage), naming `flag`, where it is not fitted or frozen.
int FindFreeBlock(const FitProblem& problem, const std::string& name, const std::string& flag);

// Whether a parameter at `coordinate` is pushed against one of its bounds by the gradient of the cost.
bool IsHeld(const ParameterBlock& block, double coordinate, double gradient);

// The names of `SmoothnessPrior`.
inline constexpr char kWindPrior[] = "wind";
inline constexpr char kFieldPrior[] = "fields";

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_PROBLEM_PROBLEM_H_
