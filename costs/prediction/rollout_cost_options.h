// How a recording is turned into rows for Ceres, and what that took.
#ifndef CLOTHID_COSTS_PREDICTION_ROLLOUT_COST_OPTIONS_H_
#define CLOTHID_COSTS_PREDICTION_ROLLOUT_COST_OPTIONS_H_

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "costs/assimilation/assimilation.h"
#include "costs/field/field_request.h"
#include "costs/prediction/pass_step.h"
#include "costs/prediction/robust_loss.h"
#include "sim/derivative/adjoint.h"
#include "sim/rollout/rollout.h"
#include "sim/scene/scene.h"

namespace clothid {

class EvaluationJournal;

enum class JacobianMethod {
  kAdjoint,      // one block reverse sweep: dL/dq exact, Gauss-Newton matrix of a subspace
  kSensitivity,  // forward sweep alongside every rollout: the full Jacobian, compressed by QR
  kNumeric,      // forward differences, one more rollout per parameter: the baseline
};

// How closely the equations of a rollout and of its derivatives are solved.
enum class Precision {
  kFull,   // to the tolerances of the scene
  kLoose,  // to those below, where the scene's are tighter: for points from which a fit only wants to get away
};

// On `datasets/drape.motion.bin` a rollout takes half of the iterations of 1e-8 then, and is within 3e-3 of its
// residual, which is as near as a Gauss-Newton step from some way off leads anyway.
inline constexpr double kLooseStepTolerance = 1e-3;
inline constexpr double kLooseAdjointTolerance = 1e-6;
// Of forward sweeps with the hundreds of columns of an unknown start, in either precision: they are for a Gauss-Newton
// matrix alone, the gradient comes from the adjoint.
inline constexpr double kStartAdjointTolerance = 1e-3;

// The room that predictions and first Jacobians have in a journal, bytes: those of a recording of some megabytes, all
// of them.
inline constexpr std::uint64_t kJournalRoom = std::uint64_t{512} << 20;

struct RolloutCostOptions {
  JacobianMethod jacobian = JacobianMethod::kAdjoint;
  AdjointOptions adjoint;  // of the reverse sweeps
  RobustLoss loss;
  Assimilation assimilation;  // of all rollouts: the recording corrects them
  int num_differences = 4;    // adjoint: the most recent rollouts whose differences enter the subspace
  // adjoint: the first rows are those of a forward sweep, whose Jacobian starts the subspace (see
  // costs/rows/residual_basis.h). Not with `fields`.
  bool starts_with_sensitivities = false;
  std::size_t memory_limit = std::size_t{1} << 30;  // bytes of a rollout's steps; beyond it they are made twice
  std::vector<FieldRequest> fields;  // constants whose variation over the cloth is unknown; fields of the scene
  int num_threads = 1;               // that share the work of a rollout or a sweep; results do not depend on them
  const std::atomic<bool>* cancel = nullptr;   // ends the rollout under way as failed; must outlive the cost
  std::shared_ptr<EvaluationJournal> journal;  // of this cost alone; null: nothing is replayed or kept
  PassObserver on_step;                        // what is replayed has none but of predictions made again; may be empty

  bool is_cancelled() const { return cancel != nullptr && cancel->load(); }
};

// What the evaluations took. Counts depend on the sequence of evaluations alone; seconds do not belong to a result.
struct CostStatistics {
  int rollouts = 0;                 // simulated sequences, with or without derivatives
  int sweeps = 0;                   // reverse or forward derivative sweeps
  RolloutCounts counts;             // summed over the rollouts
  double rollout_seconds = 0.0;     // rollouts without derivatives
  double derivative_seconds = 0.0;  // reverse sweeps; forward sweeps with their rollout

  CostStatistics& operator+=(const CostStatistics& other);
  CostStatistics& operator-=(const CostStatistics& other);
};

// The step of forward differences in an internal coordinate, where predictions are known to the step tolerance:
// rounding error tolerance/step and truncation error step balance at the square root; not below 1e-6.
double ForwardDifferenceStep(const SolverOptions& solver);

}  // namespace clothid

#endif  // CLOTHID_COSTS_PREDICTION_ROLLOUT_COST_OPTIONS_H_
