// What comes out of a fit.
#ifndef CLOTHID_IDENTIFY_ESTIMATE_FIT_SUMMARY_H_
#define CLOTHID_IDENTIFY_ESTIMATE_FIT_SUMMARY_H_

#include <Eigen/Core>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "costs/rollout_cost.h"
#include "datasets/observation/observation.h"
#include "identify/base/options.h"
#include "identify/estimate/fitted_field.h"
#include "identify/estimate/interval_check.h"
#include "identify/problem/memory_trial.h"
#include "identify/problem/unknown_basis.h"
#include "identify/uncertainty/uncertainty.h"

namespace clothid {

enum class FitStatus {
  kConverged,
  kNotConverged,  // stopped at max_iterations, or where the points ahead fail
  kFailed,        // a rollout or derivative failed where the fit could not go on
  kInterrupted,   // FitOptions::cancel
};
std::string FitStatusName(FitStatus status);

// What a fit found out about the start of a recording. Lengths and speeds are root mean squares over the free nodes, or
// over the handles, of one coordinate; standard deviations are those of the unknowns, s and all.
struct StartEstimate {
  int recording = 0;
  double moved = 0.0, position_std = 0.0;        // m: from the base (datasets/motion/start_state.h), and how sure
  double handles_moved = 0.0, handle_std = 0.0;  // m, at the start; 0 where their path was exact
  double handle_interval = 0.0;                  // s, between knots of what they are off by; 0: that does not change
  // m: how far its first frame is from where it was seen, of a coordinate, beside the noise; and what handles are off,
  // in standard deviations of what was measured of them.
  double first_frame_error = 0.0, handle_error = 0.0;
  double speed_change = 0.0, velocity_std = 0.0;  // m/s; 0 where the cloth was released at rest
};

// The cost near the estimate as a function of the parameters alone, all other unknowns following them.
struct MarginalModel {
  Eigen::MatrixXd follow;   // F [(n + f) x p]: the others move by F d where the parameters move by d
  Eigen::MatrixXd hessian;  // [p x p] J^T J along with them, and the priors; rows of what nothing depends on are zero
};

// `FitSummary::message` of a fit that was interrupted.
inline constexpr char kInterruptedMessage[] = "stopped on request, at the best point so far";

struct FittedParameter {
  std::string name;
  ParameterId id;  // of its block
  double value = 0.0;
  double start = 0.0;
  double lower_bound = -std::numeric_limits<double>::infinity(), upper_bound = std::numeric_limits<double>::infinity();
  bool frozen = false;
  bool at_bound = false;
  ParameterPrior prior;  // as in its block
  bool is_knot = false;  // of a profile that is believed to be smooth
  ParameterScale scale = ParameterScale::kLinear;
  MeasuredConstant measured;  // of any cloth
};

// Valid where has_estimate(), whatever the status: the best point that was evaluated, with full precision unless the
// fit was interrupted before it came to that.
struct FitSummary {
  FitStatus status = FitStatus::kFailed;
  std::string message = "the fit was not run";  // one line: why it ended
  std::vector<FittedParameter> parameters;
  Eigen::VectorXd coordinates;  // [p + n + f] of the estimate, see FitProblem
  Eigen::VectorXd next;         // of FitPrecision::kLoose, where it worked: where another fit may start, likewise
  std::optional<Uncertainty> uncertainty;  // at the estimate; absent: not asked for, or the derivative failed there
  std::optional<MarginalModel> marginal;   // that it is made of
  std::optional<IntervalCheck> interval_check;  // of that uncertainty
  std::vector<BoundCheck> bound_checks;         // of what is not visible
  std::vector<DentCheck> dents;                 // of it, too, where noise does not explain the residuals
  std::vector<StartEstimate> starts;     // of the recordings whose start was unknown, where there is an uncertainty
  std::vector<ModelError> model_errors;  // per recording, that frames were weighed by
  // [p] of the parameters, where the fit was before frames were weighed so; empty: they all count alike.
  Eigen::VectorXd unweighed_values;
  // The fits with corrected rollouts that found the memory, in their order, and whether the last of them is the answer:
  // then all that is said of predictions and errors is of rollouts that the recordings correct with that memory.
  std::vector<MemoryTrial> memory_trials;
  Assimilation assimilation;
  std::string why_not_assimilated;    // one line: why recordings that were asked to did not; else empty
  FitPlan plan;                       // the stages, and what became of each
  std::optional<FieldResult> fields;  // of the fields, where some were fitted
  // Near the estimate, where the fit ended with one; `AddUncertainty` takes it.
  std::optional<BasisLinearization> linearization;
  double cost = 0.0;
  PredictionError start_error;  // over all recordings, at the starting values, of the precision of the end
  PredictionError error;        // the same at the estimate
  std::vector<Eigen::MatrixXd> start_predicted;  // per recording, at the start, likewise [R x T] m, see Observation
  std::vector<Eigen::MatrixXd> predicted;        // the same at the estimate
  std::vector<Eigen::MatrixXd> forces;           // and those at handles [3G x F] N, empty where none were measured
  RolloutCounts counts;                          // of the rollouts at the estimate, summed over the recordings
  std::vector<FitIteration> iterations;          // of increasing number; the first is the start, the last the estimate
  int num_continuations = 0;                     // how often the fit went on from a lower point (continued_fit.h)
  CostStatistics statistics;
  CostStatistics lead;  // that part of them that first frames took (first_frames.h)
  // Wall time of this run, what was examined beside the fit included. `statistics` sums rollouts and derivatives over
  // recordings, which may be simulated side by side, and counts those that a journal gave with the seconds they once
  // took: then they exceed it.
  double total_seconds = 0.0;
  double solver_seconds = 0.0;  // of the fit, outside of rollouts and derivatives

  bool has_estimate() const { return !parameters.empty(); }
  // [p + n + f] that these checks have met, of lower cost than the estimate; empty: none.
  Eigen::VectorXd lower_point() const;
  int num_iterations() const { return iterations.empty() ? 0 : iterations.back().iteration; }
  Eigen::VectorXd values() const;  // [p] of the parameters
};

// Makes `summary`, of a fit that went on from the end of `first`, one of both: its starts and its work are added.
void AddEarlierFit(const FitSummary& first, FitSummary* summary);

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_ESTIMATE_FIT_SUMMARY_H_
