// One recording with the simulator of its scene: from the coordinates of parameter blocks to rollouts.
#ifndef CLOTHID_COSTS_PREDICTION_RECORDING_MODEL_H_
#define CLOTHID_COSTS_PREDICTION_RECORDING_MODEL_H_

#include <Eigen/Core>
#include <atomic>
#include <cstddef>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "costs/prediction/alignment.h"
#include "costs/prediction/frame_interpolation.h"
#include "costs/prediction/parameter_block.h"
#include "costs/prediction/pass_step.h"
#include "costs/prediction/rollout_cost_options.h"
#include "datasets/motion/recorded_motion.h"
#include "datasets/observation/observation.h"
#include "sim/derivative/adjoint.h"
#include "sim/derivative/sensitivity.h"
#include "sim/rollout/rollout.h"
#include "sim/rollout/simulator.h"
#include "sim/scene/parameters.h"

namespace clothid {

class AlignedPrediction;

// How one sweep over the steps runs.
struct SweepOptions {
  Precision precision = Precision::kFull;
  const std::atomic<bool>* cancel = nullptr;  // ends the sweep as failed when it turns true; may be null
  int sweeps_left = 0;                        // that the evaluation needs after this one, for the observer
};

// What a rollout keeps for its `PullBack`.
struct RolloutStorage {
  std::size_t memory_limit = std::size_t{1} << 30;  // bytes of its steps; beyond it there are checkpoints
  bool keep_factors = false;                        // for a PullBack of few seeds, up to `memory_limit` bytes more
};

// Owns everything it needs; one per thread. The parameters that are not blocks stay at the scene's nominal values,
// those of the recording itself (costs/prediction/alignment.h) at zero: where none of them is a block, nothing is
// corrected.
class RecordingModel {
 public:
  // Every name of `blocks` must exist in the recording's scene or be one of its own parameters. The terms of the
  // simulation are those that the starting values of the blocks and the scene's nominal values ask for. Throws `Error`
  // for names and for what `Observation` and `Simulator` reject. `observer`: told of every step of all sweeps; may be
  // empty.
  RecordingModel(const RecordedMotion& motion, std::vector<ParameterBlock> blocks, PassObserver observer = {});

  const std::string& name() const { return name_; }
  const Observation& observation() const { return observation_; }
  const Scene& scene() const { return simulator_.scene(); }
  const std::vector<ParameterBlock>& blocks() const { return blocks_; }
  int num_blocks() const { return static_cast<int>(blocks_.size()); }

  // `coordinates` [p], in the order of the blocks.
  Parameters ParametersAt(const Eigen::VectorXd& coordinates) const;

  int num_steps() const { return interpolation_ ? interpolation_->num_steps() : observation_.num_steps(); }

  // The scene's solver options, with the tolerances of `precision`.
  SolverOptions SolverAt(Precision precision) const;

  // `predicted` (may be null): the points [R x T] of every frame, as of Observation::Predict, which needs every step;
  // valid where the rollout is ok(). `velocities` (may be null): the time derivatives of the prediction [R x T] m/s
  // where parameters of the recording itself are blocks, else empty.
  Rollout Simulate(const Eigen::VectorXd& coordinates, const SweepOptions& sweep, const RolloutStorage& storage,
                   Eigen::MatrixXd* predicted, Eigen::MatrixXd* velocities = nullptr);

  // (d prediction / d coordinates)^T, whitened, applied to `seeds` [m x s]: [q x s], for the blocks listed in `active`
  // [q]. `predicted` and `velocities`: of the rollout.
  Eigen::MatrixXd PullBack(const Rollout& rollout, const Eigen::MatrixXd& predicted, const Eigen::MatrixXd& velocities,
                           const Eigen::VectorXd& coordinates, const std::vector<int>& active,
                           const Eigen::MatrixXd& seeds, const AdjointOptions& options, Precision precision);

  // Called per frame with the prediction [R], whitened residuals [r] of the frame and their derivatives with
  // respect to the coordinates of the blocks `active`, [r x q].
  using FrameVisitor = std::function<void(int frame, const Eigen::VectorXd& points, const Eigen::VectorXd& residuals,
                                          const Eigen::MatrixXd& jacobian)>;
  SensitivityResult PushForward(const Eigen::VectorXd& coordinates, const std::vector<int>& active,
                                const FrameVisitor& visitor, const SweepOptions& sweep);

 private:
  // Some blocks by what they are; each with its place in the list that they come from.
  struct SortedBlocks {
    std::vector<ParameterId> parameters;  // of the simulation
    std::vector<int> parameter_places;
    std::vector<int> velocity_axes;  // of the start velocity
    std::vector<int> velocity_places;
    std::vector<AlignmentId> corrections;  // all other parameters of the recording
    std::vector<int> correction_places;
  };
  SortedBlocks Sort(const std::vector<int>& active) const;
  bool is_aligned() const { return interpolation_.has_value(); }

  void Observe(RolloutPass pass, int num_done, int sweeps_left) const {
    if (observer_ && num_done > 0) observer_({pass, num_done, num_steps(), sweeps_left});
  }
  // Lets all that is simulated from now on be solved with `precision`.
  void UsePrecision(Precision precision);
  // As the functions of sim/, observed.
  Rollout RunRollout(const Eigen::VectorXd& coordinates, const SweepOptions& sweep, RolloutOptions options);
  RolloutGradient RunReverseSweep(const Rollout& rollout, const std::vector<ParameterId>& parameters,
                                  Eigen::Index num_columns, const AddPositionGradient& add_seeds,
                                  const AdjointOptions& options, Precision precision);
  SensitivityResult RunForwardSweep(const Eigen::VectorXd& coordinates, const SensitivityDirections& directions,
                                    const SensitivityVisitor& visitor, const SweepOptions& sweep);

  Alignment AlignmentAt(const Eigen::VectorXd& coordinates) const;
  AlignedPrediction PredictionAt(const Eigen::VectorXd& coordinates) const;
  // Lets the rollouts start with the velocity that the coordinates ask for.
  void SetStartVelocity(const Eigen::VectorXd& coordinates);
  Eigen::VectorXd ValueDerivatives(const Eigen::VectorXd& coordinates, const std::vector<int>& active) const;

  // As the functions of their names, where `is_aligned`.
  Rollout SimulateAligned(const Eigen::VectorXd& coordinates, const SweepOptions& sweep, RolloutOptions options,
                          Eigen::MatrixXd* predicted, Eigen::MatrixXd* velocities = nullptr);
  Eigen::MatrixXd PullBackAligned(const Rollout& rollout, const Eigen::MatrixXd& predicted,
                                  const Eigen::MatrixXd& velocities, const Eigen::VectorXd& coordinates,
                                  const std::vector<int>& active, const Eigen::MatrixXd& seeds,
                                  const AdjointOptions& options, Precision precision);
  SensitivityResult PushForwardAligned(const Eigen::VectorXd& coordinates, const std::vector<int>& active,
                                       const FrameVisitor& visitor, const SweepOptions& sweep);

  std::string name_;
  std::vector<ParameterBlock> blocks_;
  std::vector<ParameterId> ids_;                           // of the simulation's blocks; of others meaningless
  std::vector<std::optional<AlignmentId>> alignment_ids_;  // of the recording's own blocks
  Parameters start_;
  Observation observation_;
  std::optional<FrameInterpolation> interpolation_;  // where a block is the recording's own
  Eigen::Vector3d turn_center_;                      // m
  Eigen::VectorXd initial_velocities_;               // [3N] m/s, the scene's
  SolverOptions full_precision_;
  Simulator simulator_;
  PassObserver observer_;
};

}  // namespace clothid

#endif  // CLOTHID_COSTS_PREDICTION_RECORDING_MODEL_H_
