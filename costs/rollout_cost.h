// A simulated rollout against its recording, as a Ceres cost function.
//
// The cost is L = 1/2 sum_p rho(|e_p|^2) with the whitened residual e = (predicted - measured)/sigma of m seen
// coordinates (datasets/observation/observation.h) and rho of costs/prediction/robust_loss.h. Ceres does not get the m
// rows of e but a few rows, with Jacobians asked for or without,
//   r = (0, .., 0, sqrt(2 L)),   so that 1/2 |r|^2 = L,
// and in place of their Jacobian a matrix J with
//   J^T r = dL/dq (exactly),
//   J^T J = the Gauss-Newton matrix of e, weighted by the loss (sensitivity, numeric), or its restriction to a subspace
//           (adjoint, costs/rows/residual_basis.h).
// J is what a Gauss-Newton method needs, and not the derivative of r: that is its last row alone, dsqrt(2 L)/dq. It is
// the Jacobian of e, or what the subspace holds of it, in a basis whose last direction is that of e
// (costs/rows/reflected_rows.h). r depends on the parameters alone; the subspace, and with it J of the adjoint, also on
// the points that were evaluated before. For `ceres::GradientChecker` there is costs/full_residual_cost.h.
//
// Prediction, residuals and derivatives of the last few points are kept by parameter values, and the rollout of the
// last one, so asking twice costs nothing; what was cancelled is not kept. Functions that are const fill this cache: a
// cost belongs to one thread at a time, together with those that it shares the cache with (`AtPrecision`).
//
// Parameter blocks: one per `ParameterBlock`, size 1, the block's internal coordinate; one more where the start of the
// recording is unknown, its n unknowns (costs/start/unknown_start.h), whose prior is part of L then; and one more where
// fields are asked for, their f unknowns (costs/field/field_unknowns.h). The prior of fields is no part of L:
// recordings have it in common. Below, q is all of them, [p + n + f].
#ifndef CLOTHID_COSTS_ROLLOUT_COST_H_
#define CLOTHID_COSTS_ROLLOUT_COST_H_

#include <ceres/cost_function.h>

#include <Eigen/Core>
#include <memory>
#include <string>
#include <vector>

#include "costs/prediction/parameter_block.h"
#include "costs/prediction/recording_model.h"
#include "costs/prediction/rollout_cost_options.h"
#include "datasets/motion/recorded_motion.h"

namespace clothid {

class RolloutEvaluator;
struct RolloutEvaluation;

class RolloutCost : public ceres::CostFunction {
 public:
  // Throws `Error` where `RecordingModel` does.
  RolloutCost(const RecordedMotion& motion, std::vector<ParameterBlock> blocks, const RolloutCostOptions& options);
  ~RolloutCost() override;

  // The same cost with rollouts and derivatives of another precision. Both share evaluations, subspace, statistics and
  // journal: points of different precision are never mistaken for each other, but differences between them serve as
  // directions of the subspace. Either may outlive the other.
  std::unique_ptr<RolloutCost> AtPrecision(Precision precision) const;

  // False where the rollout or its derivative failed; see last_failure(). `jacobians` and each jacobians[i] may be
  // null; what is null is not differentiated.
  bool Evaluate(double const* const* parameters, double* residuals, double** jacobians) const override;

  // L and dL/dq [p + n + f] for first-order methods, by one adjoint column (from the rows of `Evaluate` with the other
  // Jacobians). `gradient` may be null; entries of frozen blocks are zero. Returns as `Evaluate` does.
  bool EvaluateGradient(const Eigen::VectorXd& coordinates, double* cost, Eigen::VectorXd* gradient) const;
  // L at a point whose derivatives nobody will ask for: nothing is kept of its rollout but the prediction.
  bool EvaluateCost(const Eigen::VectorXd& coordinates, double* cost) const;

  // e [m], and the residuals of the prior, with their Jacobian along the p blocks and along `combinations`
  // [(n + f) x c] of the unknowns (may be empty), weighted by the loss and compressed to r rows: |residuals| = |e|, and
  // `jacobian` [r x (p + c)] has the same products with itself and with `residuals` as those columns of de/dq; columns
  // of frozen blocks are zero. `frame_scores` (may be null) [(p + c) x T]: the parts of the gradient of L that the
  // frames have, J_i^T e_i. For the covariance at a solution. Returns as `Evaluate` does.
  bool Linearize(const Eigen::VectorXd& coordinates, const Eigen::MatrixXd& combinations, Eigen::MatrixXd* jacobian,
                 Eigen::VectorXd* residuals, Eigen::MatrixXd* frame_scores = nullptr) const;

  // J^T J `direction` [p + n + f] of e, weighted by the loss, without priors, to about `kLooseAdjointTolerance`;
  // entries of frozen blocks count as zero, here and there. By a forward sweep of one column and a reverse sweep along
  // the kept rollout, and at a new point one forward sweep of the blocks. Returns as `Evaluate` does.
  bool TimesCurvature(const Eigen::VectorXd& coordinates, const Eigen::VectorXd& direction,
                      Eigen::VectorXd* product) const;

  // J^T D [p + n + f] of the change D of e from the prediction here to another one, `predicted` [R x T] m and `forces`
  // [3G x F] N, weighted by the loss as here: how much dL/dq would change to first order. Without priors; entries of
  // frozen blocks are zero. Where blocks are the only unknowns, nothing is swept after `Linearize` of that point; else
  // it takes one reverse sweep. Returns as `Evaluate` does.
  bool PullBackChange(const Eigen::VectorXd& coordinates, const Eigen::MatrixXd& predicted,
                      const Eigen::MatrixXd& forces, Eigen::VectorXd* product) const;

  // The prediction [R x T] m (see Observation), the counts of their rollout (may be null) and the forces [3G x F] N
  // (may be null). False where the rollout failed.
  bool Predict(const Eigen::VectorXd& coordinates, Eigen::MatrixXd* predicted, RolloutCounts* counts = nullptr,
               Eigen::MatrixXd* forces = nullptr) const;

  // How far the model errs: from now on residuals over sigma are weighed by it (datasets/observation/model_error.h), in
  // all costs that share the cache. Costs of before and of after do not compare.
  void SetModelError(const ModelError& error);

  // How the recording corrects the rollouts from now on (costs/assimilation/assimilation.h), in all costs that share
  // the cache, which is empty then: the predictions of before were others. Throws as `RecordingModel::Assimilate` does.
  void Assimilate(const Assimilation& assimilation);

  // A new fit starts: the adjoint's subspace starts afresh.
  void Restart();
  // Everything starts afresh but `statistics`: which evaluations are cached does not depend on those before.
  void Forget();
  // Gives back the memory of the latest rollout, and of what is known of all other points [p + n + f]: where that is
  // asked for, it is made again.
  void KeepOnly(const Eigen::VectorXd& coordinates) const;

  // Why the last evaluation returned false, in one line that names the recording; empty where it did not.
  const std::string& last_failure() const;
  // Throws the `Error` of the journal (costs/rows/evaluation_journal.h) where there was one; all evaluations since
  // failed.
  void CheckJournal() const;
  const CostStatistics& statistics() const;
  const RecordingModel& model() const;

 private:
  RolloutCost(std::shared_ptr<RolloutEvaluator> evaluator, Precision precision);

  // J of an evaluation [num_residuals() x q].
  Eigen::MatrixXd RowsOf(const RolloutEvaluation& evaluation) const;
  // Of the unknown start: its share of L, and the rows of its prior below those of the recording. Nothing without one.
  double PriorAt(const Eigen::VectorXd& coordinates) const;
  int num_prior_rows() const;

  std::shared_ptr<RolloutEvaluator> evaluator_;  // the cache
  Precision precision_ = Precision::kFull;
};

}  // namespace clothid

#endif  // CLOTHID_COSTS_ROLLOUT_COST_H_
