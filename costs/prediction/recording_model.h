// One recording with the simulator of its scene: from the coordinates of parameter blocks to rollouts.
#ifndef CLOTHID_COSTS_PREDICTION_RECORDING_MODEL_H_
#define CLOTHID_COSTS_PREDICTION_RECORDING_MODEL_H_

#include <Eigen/Core>
#include <atomic>
#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "costs/prediction/block_values.h"
#include "costs/prediction/frame_interpolation.h"
#include "costs/prediction/handle_correction.h"
#include "costs/prediction/parameter_block.h"
#include "costs/prediction/pass_step.h"
#include "costs/prediction/rollout_cost_options.h"
#include "costs/start/unknown_start.h"
#include "datasets/motion/recorded_motion.h"
#include "datasets/observation/observation.h"
#include "sim/derivative/adjoint.h"
#include "sim/derivative/sensitivity.h"
#include "sim/rollout/energy_loss.h"
#include "sim/rollout/rollout.h"
#include "sim/rollout/simulator.h"
#include "sim/scene/parameters.h"

namespace clothid {

class ForcePrediction;
class FramePrediction;
class ResidualDerivative;

// How one pass over the steps runs (costs/prediction/pass_step.h).
struct PassOptions {
  Precision precision = Precision::kFull;
  const std::atomic<bool>* cancel = nullptr;  // ends the pass as failed when it turns true; may be null
  int passes_left = 0;                        // that the evaluation needs after this one, for the observer
};

// What a rollout keeps for its `PullBack`.
struct RolloutStorage {
  std::size_t memory_limit = std::size_t{1} << 30;  // bytes of its steps; beyond it there are checkpoints
  bool keep_factors = false;                        // for a PullBack of few seeds, up to `memory_limit` bytes more
};

// What a rollout leaves behind for forces at handles and their adjoint. Empty without forces.
struct ForceTrack {
  Eigen::MatrixXd predicted;  // [3G x F] N
  Eigen::MatrixXd states;     // [3n x (steps + 1)] m: positions of the nodes near handles after every step
};

// Owns everything it needs; one per thread. The parameters that are not blocks stay at the scene's nominal values,
// those of the recording itself (costs/prediction/alignment.h) at zero: where none of them is a block, nothing is
// corrected. Where the start of the recording is unknown, its unknowns (costs/start/unknown_start.h) are coordinates,
// too, after those of the blocks: the list `active` has all of them or none.
class RecordingModel {
 public:
  // Every name of `blocks` must exist in the recording's scene or be one of its own parameters. The terms of the
  // simulation are those that the starting values of the blocks and the scene's nominal values ask for. Throws `Error`
  // for names, for a size of the cloth beside forces at its handles, and for what `Observation` and `Simulator` reject.
  // `observer`: told of every step of all passes; may be empty. `start`: that of the same cloth in another view of this
  // recording; null: what the recording says.
  RecordingModel(const RecordedMotion& motion, std::vector<ParameterBlock> blocks, PassObserver observer = {},
                 std::shared_ptr<const UnknownStart> start = nullptr);

  const std::string& name() const { return name_; }
  const Observation& observation() const { return observation_; }
  const Scene& scene() const { return simulator_.scene(); }
  const std::vector<ParameterBlock>& blocks() const { return values_.blocks(); }
  int num_blocks() const { return static_cast<int>(blocks().size()); }               // p
  int num_start_unknowns() const { return start_ == nullptr ? 0 : start_->size(); }  // n
  int num_coordinates() const { return num_blocks() + num_start_unknowns(); }        // p + n
  const std::shared_ptr<const UnknownStart>& shared_start() const { return start_; }
  const UnknownStart* unknown_start() const { return start_.get(); }  // null: it is known
  // The last n of `coordinates` [p + n]; of those of the blocks alone [p] zero, the base of the start.
  Eigen::VectorXd StartUnknowns(const Eigen::VectorXd& coordinates) const {
    if (coordinates.size() == num_blocks()) return Eigen::VectorXd::Zero(num_start_unknowns());
    return coordinates.tail(num_start_unknowns());
  }

  // `coordinates` [p + n], the blocks in their order.
  Parameters ParametersAt(const Eigen::VectorXd& coordinates) const {
    Parameters parameters = values_.ParametersAt(coordinates);
    if (fields_ != nullptr) parameters.fields = fields_;
    return parameters;
  }

  // How constants vary over the cloth in all rollouts from now on: the fields of the scene, with other factors.
  void SetFields(std::shared_ptr<const std::vector<FieldFactors>> fields) { fields_ = std::move(fields); }

  // Of its simulator.
  void SetNumThreads(int num_threads) { simulator_.SetNumThreads(num_threads); }

  int num_steps() const;

  // The scene's solver options, with the tolerances of `precision`.
  SolverOptions SolverAt(Precision precision) const;

  // `predicted`: the prediction [R x T] m (see Observation) corrected as the coordinates ask, which needs every step;
  // valid where the rollout is ok(). `velocities` (may be null): its time derivatives [R x T] m/s where the time offset
  // is a block, else empty. `forces` (may be null): those that the recording has measured, likewise.
  Rollout Simulate(const Eigen::VectorXd& coordinates, const PassOptions& pass, const RolloutStorage& storage,
                   Eigen::MatrixXd* predicted, Eigen::MatrixXd* velocities = nullptr, ForceTrack* forces = nullptr);

  // What the rollout at `coordinates` gains by its integrator; nothing where it failed, or cannot gain any
  // (`MayGainEnergy`): that is not simulated.
  EnergyGain EnergyGainAt(const Eigen::VectorXd& coordinates, const std::atomic<bool>* cancel);

  // (d prediction / d coordinates)^T, whitened, applied to `seeds` [m x s]: [q x s], for the coordinates listed in
  // `active` [q]. `predicted` and `velocities`: of the rollout. `fields` (may be null): the same [K F x s] for the
  // logarithms of the values that the rollout's fields have per triangle (sim/derivative/field_derivative.h). `forces`
  // (may be null where the recording has none): of the rollout. Throws `std::logic_error` where
  // they are missing, or the velocities of an active time offset.
  Eigen::MatrixXd PullBack(const Rollout& rollout, const Eigen::MatrixXd& predicted, const Eigen::MatrixXd& velocities,
                           const Eigen::VectorXd& coordinates, const std::vector<int>& active,
                           const Eigen::MatrixXd& seeds, const AdjointOptions& options, Precision precision,
                           Eigen::MatrixXd* fields = nullptr, const ForceTrack* forces = nullptr);

  // Called per frame with the prediction [R], whitened residuals [r] of the frame and their derivatives with
  // respect to the coordinates of the blocks `active`, [r x q]. Reading i of the forces counts as frame T + i, with the
  // predicted forces [3G]; they are visited between the frames, each kind in its order.
  using FrameVisitor = std::function<void(int frame, const Eigen::VectorXd& points, const Eigen::VectorXd& residuals,
                                          const Eigen::MatrixXd& jacobian)>;
  // `follow` (may be null) [n x q]: `active` are blocks alone, and the derivative along each of them moves the unknown
  // start with it, by that column.
  SensitivityResult PushForward(const Eigen::VectorXd& coordinates, const std::vector<int>& active,
                                const FrameVisitor& visitor, const PassOptions& pass,
                                const Eigen::MatrixXd* follow = nullptr);

  // The same along a rollout of `Simulate` that is at hand, at its coordinates: nothing is simulated.
  void PushForward(const Rollout& rollout, const Eigen::VectorXd& coordinates, const std::vector<int>& active,
                   const FrameVisitor& visitor, Precision precision);
  // And along changes [K F x q] of what PullBack calls `fields`.
  void PushForwardFields(const Rollout& rollout, const Eigen::VectorXd& coordinates, const Eigen::MatrixXd& changes,
                         const FrameVisitor& visitor, Precision precision);

 private:
  using Sweep = std::function<void(const SensitivityDirections& directions, const SensitivityVisitor& visitor)>;
  // What the sweeps of all these functions have in common.
  void SweepFrames(const Eigen::VectorXd& coordinates, const std::vector<int>& active, const Eigen::MatrixXd* follow,
                   const FrameVisitor& visitor, const Sweep& sweep);
  void Observe(RolloutPass pass, int num_done, int passes_left) const {
    if (observer_ && num_done > 0) observer_({pass, num_done, num_steps(), passes_left});
  }
  // As the functions of sim/, observed.
  Rollout RunRollout(const Eigen::VectorXd& coordinates, const PassOptions& pass, RolloutOptions options);
  RolloutGradient RunReverseSweep(const Rollout& rollout, const std::vector<ParameterId>& parameters,
                                  Eigen::Index num_columns, const AddPositionGradient& add_seeds,
                                  const AdjointOptions& options, Precision precision);
  SensitivityResult RunForwardSweep(const Eigen::VectorXd& coordinates, const SensitivityDirections& directions,
                                    const SensitivityVisitor& visitor, const PassOptions& pass);

  FramePrediction PredictionAt(const Eigen::VectorXd& coordinates) const;
  // Absent where the recording has no forces. The parameters' fields are in the simulator afterwards.
  std::optional<ForcePrediction> ForcesAt(const Eigen::VectorXd& coordinates);
  // What a rollout has in place of the scene's start.
  struct RolloutStart {
    std::optional<Eigen::VectorXd> positions, velocities;  // [3N]
    std::optional<HandlePath> handle_offsets;

    // Into `RolloutOptions` or `SensitivityOptions`, which keep references.
    template <typename Options>
    void SetOn(Options* options) const {
      options->initial_positions = positions ? &*positions : nullptr;
      options->initial_velocities = velocities ? &*velocities : nullptr;
      options->handle_offsets = handle_offsets ? &*handle_offsets : nullptr;
    }
  };
  RolloutStart StartAt(const Eigen::VectorXd& coordinates) const;
  // Puts the shifts and the turn of `alignment` into the start, which may have offsets of its own.
  void MoveHandles(const Alignment& alignment, RolloutStart* start) const;
  // The columns of a forward sweep: of the parameters, then of the start velocity and of what moves the handles, then
  // of the unknown start: those of all its unknowns where they are active, or `along` [n x q], if any, of them.
  SensitivityDirections DirectionsOf(const Eigen::VectorXd& coordinates, const SortedBlocks& active,
                                     const Eigen::MatrixXd& along) const;
  // The rows [.. x s] of a reverse sweep that belong to these columns.
  void SetStartRows(const RolloutGradient& gradient, const Eigen::VectorXd& coordinates, const SortedBlocks& active,
                    Eigen::MatrixXd* all) const;
  // The prediction at a frame, from states whose further columns are derivatives along the directions of `active`, and
  // its derivatives in the order of `active`: [R x (1 + q)].
  Eigen::MatrixXd WithDerivatives(const FramePrediction& prediction, const SortedBlocks& active, int frame,
                                  const FrameStates& states) const;
  // The swept columns of a prediction, or of forces, [.. x (1 + c)] in the order of `active` [.. x (1 + q)]; zero in
  // those of corrections.
  static Eigen::MatrixXd Arranged(const Eigen::MatrixXd& swept, const SortedBlocks& active);
  // Forces [3G x (1 + c)] likewise, with the derivatives of their bias.
  static Eigen::MatrixXd ForcesWithDerivatives(const Eigen::MatrixXd& swept, const SortedBlocks& active);
  // Of all residuals [m] by a force bias, 1/N.
  Eigen::VectorXd ForceBiasDerivative(AlignmentId id) const;
  // The rows of `gradient` that belong to corrections.
  void SetCorrectionRows(const FramePrediction& prediction, const SortedBlocks& active,
                         const Eigen::MatrixXd& predicted, const Eigen::MatrixXd& velocities,
                         const ResidualDerivative& derivative, const Eigen::MatrixXd& seeds,
                         Eigen::MatrixXd* gradient) const;

  std::string name_;
  BlockValues values_;
  Observation observation_;
  FrameInterpolation interpolation_;
  Eigen::Vector3d turn_center_;  // m
  Simulator simulator_;
  std::shared_ptr<const UnknownStart> start_;                // null: the start is known
  std::optional<HandleCorrection> handle_correction_;        // absent where no block moves handles
  std::shared_ptr<const std::vector<FieldFactors>> fields_;  // null: those of the scene
  PassObserver observer_;
};

}  // namespace clothid

#endif  // CLOTHID_COSTS_PREDICTION_RECORDING_MODEL_H_
