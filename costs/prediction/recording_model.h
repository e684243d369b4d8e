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

#include "costs/assimilation/assimilation.h"
#include "costs/field/field_request.h"
#include "costs/field/field_unknowns.h"
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
#include "sim/rollout/energy_gain.h"
#include "sim/rollout/rollout.h"
#include "sim/rollout/self_contact_audit.h"
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
  // [3H x (steps + 1)] N: of pairs upon handles (sim/rollout/pair_forces.h); empty where the cloth does not touch
  // itself.
  Eigen::MatrixXd pair_forces = {};
};

// What a forward sweep runs along: the coordinates of blocks, then combinations of the unknowns of start and fields.
struct SweepColumns {
  std::vector<int> blocks;       // [q]
  Eigen::MatrixXd combinations;  // [(n + f) x c], or empty
};

// What a rollout gains of energy, and whether its cloth stays out of itself.
struct RolloutCheck {
  EnergyGain energy;
  SelfContactAudit self_contact;
};

// Owns everything it needs; one per thread. The parameters that are not blocks stay at the scene's nominal values,
// those of the recording itself (costs/prediction/alignment.h) at zero: where none of them is a block, nothing is
// corrected. Coordinates [p + n + f] are those of the blocks, then the unknowns of the start where it is unknown
// (costs/start/unknown_start.h), then those of fields (costs/field/field_unknowns.h). Those of the blocks alone, or of
// blocks and start, mean zero for the rest.
class RecordingModel {
 public:
  // Every one of `blocks` must exist in the recording's scene or be one of its own parameters. The terms of the
  // simulation are those that the starting values of the blocks and the scene's nominal values ask for. Throws `Error`
  // for names, and for what `Observation` and `Simulator` reject.
  // `observer`: told of every step of all passes; may be empty. `start`: that of the same cloth in another view of this
  // recording; null: what the recording says. `fields`: those whose unknowns are coordinates; the scene has them.
  RecordingModel(const RecordedMotion& motion, std::vector<ParameterBlock> blocks, PassObserver observer = {},
                 std::shared_ptr<const UnknownStart> start = nullptr, const std::vector<FieldRequest>& fields = {});

  const std::string& name() const { return name_; }
  const Observation& observation() const { return observation_; }
  const Scene& scene() const { return simulator_.scene(); }
  const ClothModel& cloth() const { return simulator_.model(); }
  const Eigen::VectorXd& times() const { return times_; }  // of the frames [T] s
  const std::vector<ParameterBlock>& blocks() const { return values_.blocks(); }
  int num_blocks() const { return static_cast<int>(blocks().size()); }               // p
  int num_start_unknowns() const { return start_ == nullptr ? 0 : start_->size(); }  // n
  int num_field_unknowns() const { return fields_ ? fields_->size() : 0; }           // f
  int num_unknowns() const { return num_start_unknowns() + num_field_unknowns(); }   // n + f
  int num_coordinates() const { return num_blocks() + num_unknowns(); }              // p + n + f
  const std::shared_ptr<const UnknownStart>& shared_start() const { return start_; }
  const UnknownStart* unknown_start() const { return start_.get(); }                     // null: it is known
  const FieldUnknowns* field_unknowns() const { return fields_ ? &*fields_ : nullptr; }  // null: none are fitted
  // The n and the f of `coordinates`.
  Eigen::VectorXd StartUnknowns(const Eigen::VectorXd& coordinates) const;
  Eigen::VectorXd FieldUnknownsOf(const Eigen::VectorXd& coordinates) const;

  // `coordinates`: the blocks in their order. With the fields that they ask for.
  Parameters ParametersAt(const Eigen::VectorXd& coordinates) const;

  // What costs are to count with; predictions do not depend on it.
  void SetModelError(const ModelError& error) { observation_.SetModelError(error); }

  // From now on the recording corrects all rollouts but those of `CheckAt`, as `assimilation` and what `loss` lets a
  // point count say: predictions are those between corrections. Throws `std::logic_error` for a recording that cannot
  // (`WhyNotAssimilated`).
  void Assimilate(const Assimilation& assimilation, const RobustLoss& loss);
  // From now on `correction` does in their place; null: nothing does. It counts its steps from the scene's start.
  void Correct(std::shared_ptr<const Correction> correction) { correction_ = std::move(correction); }
  // Why the recording cannot correct its rollouts, in words that go on after its name; empty where it can.
  std::string WhyNotAssimilated() const;

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

  // Looks at the rollout at `coordinates`; nothing where it failed, or there is nothing to find (`MayGainEnergy`): that
  // is not simulated.
  RolloutCheck CheckAt(const Eigen::VectorXd& coordinates, const std::atomic<bool>* cancel);

  // (d prediction / d coordinates)^T, whitened, applied to `seeds` [m x s]: [q x s], for the coordinates listed in
  // `active` [q], increasing: any blocks, all unknowns of the start or none, all of the fields or none. `predicted` and
  // `velocities`: of the rollout. `forces` (may be null where the recording has none): of the rollout. Throws
  // `std::logic_error` where they are missing, or the velocities of an active time offset.
  Eigen::MatrixXd PullBack(const Rollout& rollout, const Eigen::MatrixXd& predicted, const Eigen::MatrixXd& velocities,
                           const Eigen::VectorXd& coordinates, const std::vector<int>& active,
                           const Eigen::MatrixXd& seeds, const AdjointOptions& options, Precision precision,
                           const ForceTrack* forces = nullptr);

  // Called per frame with the prediction [R], whitened residuals [r] of the frame and their derivatives along the
  // columns of the sweep, [r x (q + c)]. Reading i of the forces counts as frame T + i, with the predicted forces [3G];
  // they are visited between the frames, each kind in its order.
  using FrameVisitor = std::function<void(int frame, const Eigen::VectorXd& points, const Eigen::VectorXd& residuals,
                                          const Eigen::MatrixXd& jacobian)>;
  SensitivityResult PushForward(const Eigen::VectorXd& coordinates, const SweepColumns& columns,
                                const FrameVisitor& visitor, const PassOptions& pass);

  // The same along a rollout of `Simulate` that is at hand, at its coordinates: nothing is simulated. `passes_left`: as
  // of PassOptions.
  void PushForward(const Rollout& rollout, const Eigen::VectorXd& coordinates, const SweepColumns& columns,
                   const FrameVisitor& visitor, Precision precision, int passes_left = 0);

 private:
  using Sweep =
      std::function<void(const SensitivityDirections& directions, const SensitivityVisitor& visitor,
                         const PairForceVisitor& pair_force_visitor, const SensitivityVisitor& corrected_visitor)>;
  // What the forward sweeps have in common, and how closely their systems are solved.
  void SweepFrames(const Eigen::VectorXd& coordinates, const SweepColumns& columns, const FrameVisitor& visitor,
                   int passes_left, const Sweep& sweep);
  double ForwardTolerance(const SweepColumns& columns, Precision precision) const;
  void Observe(RolloutPass pass, int num_done, int passes_left) const {
    if (observer_ && num_done > 0) observer_({pass, num_done, num_steps(), passes_left});
  }
  // As the functions of sim/, observed.
  Rollout RunRollout(const Eigen::VectorXd& coordinates, const PassOptions& pass, RolloutOptions options);
  RolloutGradient RunReverseSweep(const Rollout& rollout, const std::vector<ParameterId>& parameters,
                                  Eigen::Index num_columns, const AddPositionGradient& add_seeds,
                                  const AdjointOptions& options, Precision precision,
                                  const AddPositionGradient& add_pair_force_seeds,
                                  const AddPositionGradient& add_corrected_seeds);

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
  // of `combinations`.
  SensitivityDirections DirectionsOf(const Eigen::VectorXd& coordinates, const SortedBlocks& blocks,
                                     const Eigen::MatrixXd& combinations) const;
  // The rows [.. x s] of a reverse sweep that belong to these columns.
  void SetStartRows(const RolloutGradient& gradient, const Eigen::VectorXd& coordinates, const SortedBlocks& active,
                    Eigen::MatrixXd* all) const;
  // The prediction at a frame, from states whose further columns are derivatives along `DirectionsOf`, and its own
  // derivatives in the order of SweepColumns: [R x (1 + q + c)].
  Eigen::MatrixXd WithDerivatives(const FramePrediction& prediction, const SortedBlocks& blocks, int frame,
                                  const FrameStates& states) const;
  // The swept columns of a prediction, or of forces, in that order [.. x (1 + q + c)]; zero in those of corrections.
  static Eigen::MatrixXd Arranged(const Eigen::MatrixXd& swept, const SortedBlocks& blocks);
  // Forces [3G x (1 + q + c)] likewise, with the derivatives of their bias.
  static Eigen::MatrixXd ForcesWithDerivatives(const Eigen::MatrixXd& swept, const SortedBlocks& blocks);
  // Of all residuals [m] by a force bias, 1/N.
  Eigen::VectorXd ForceBiasDerivative(ParameterId id) const;
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
  std::shared_ptr<const UnknownStart> start_;          // null: the start is known
  std::optional<HandleCorrection> handle_correction_;  // absent where no block moves handles
  std::optional<FieldUnknowns> fields_;                // absent: those of the scene
  Eigen::VectorXd times_;                              // of the frames [T] s
  std::shared_ptr<const Correction> correction_;       // null: nothing is corrected
  PassObserver observer_;
};

}  // namespace clothid

#endif  // CLOTHID_COSTS_PREDICTION_RECORDING_MODEL_H_
