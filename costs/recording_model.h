// One recording with the simulator of its scene: from the coordinates of parameter blocks to rollouts.
#ifndef CLOTHID_COSTS_RECORDING_MODEL_H_
#define CLOTHID_COSTS_RECORDING_MODEL_H_

#include <Eigen/Core>
#include <atomic>
#include <cstddef>
#include <functional>
#include <string>
#include <vector>

#include "costs/parameter_block.h"
#include "costs/rollout_cost_options.h"
#include "datasets/observation.h"
#include "datasets/recorded_motion.h"
#include "sim/adjoint.h"
#include "sim/parameters.h"
#include "sim/rollout.h"
#include "sim/sensitivity.h"
#include "sim/simulator.h"

namespace clothid {

// Owns everything it needs; one per thread. The parameters that are not blocks stay at the scene's nominal values.
class RecordingModel {
 public:
  // Every name of `blocks` must exist in the recording's scene. The terms of the simulation are those that the starting
  // values of the blocks and the scene's nominal values ask for. Throws `Error` for names and for what `Observation`
  // and `Simulator` reject.
  RecordingModel(const RecordedMotion& motion, std::vector<ParameterBlock> blocks);

  const std::string& name() const { return name_; }
  const Observation& observation() const { return observation_; }
  const Scene& scene() const { return simulator_.scene(); }
  const std::vector<ParameterBlock>& blocks() const { return blocks_; }
  int num_blocks() const { return static_cast<int>(blocks_.size()); }

  // `coordinates` [p], in the order of the blocks.
  Parameters ParametersAt(const Eigen::VectorXd& coordinates) const;

  // Of all that follows; `kFull` until then.
  void SetPrecision(Precision precision);

  // With checkpoints where the steps would take more than `memory_limit` bytes. `predicted` (may be null): the points
  // [R x T] of every frame, as of Observation::Predict, which needs every step; valid where the rollout is ok().
  // `keep_factors`: for a PullBack of few seeds, up to `memory_limit` bytes more.
  Rollout Simulate(const Eigen::VectorXd& coordinates, const std::atomic<bool>* cancel, std::size_t memory_limit,
                   bool keep_factors, Eigen::MatrixXd* predicted);

  // (d prediction / d coordinates)^T, whitened, applied to `seeds` [m x s]: [q x s], for the blocks listed in `active`
  // [q]. `predicted`: of the rollout, where clouds take their derivatives.
  Eigen::MatrixXd PullBack(const Rollout& rollout, const Eigen::MatrixXd& predicted, const Eigen::VectorXd& coordinates,
                           const std::vector<int>& active, const Eigen::MatrixXd& seeds, const AdjointOptions& options);

  // Called per frame with the prediction [R], whitened residuals [r] of the frame and their derivatives with
  // respect to the coordinates of the blocks `active`, [r x q].
  using FrameVisitor = std::function<void(int frame, const Eigen::VectorXd& points, const Eigen::VectorXd& residuals,
                                          const Eigen::MatrixXd& jacobian)>;
  SensitivityResult PushForward(const Eigen::VectorXd& coordinates, const std::vector<int>& active,
                                const FrameVisitor& visitor, const std::atomic<bool>* cancel);

 private:
  std::vector<ParameterId> Ids(const std::vector<int>& active) const;
  Eigen::VectorXd ValueDerivatives(const Eigen::VectorXd& coordinates, const std::vector<int>& active) const;

  std::string name_;
  std::vector<ParameterBlock> blocks_;
  std::vector<ParameterId> ids_;
  Parameters start_;
  Observation observation_;
  SolverOptions full_precision_;
  Simulator simulator_;
};

}  // namespace clothid

#endif  // CLOTHID_COSTS_RECORDING_MODEL_H_
