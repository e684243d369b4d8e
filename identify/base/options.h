// What a fit is asked to do.
#ifndef CLOTHID_IDENTIFY_BASE_OPTIONS_H_
#define CLOTHID_IDENTIFY_BASE_OPTIONS_H_

#include <Eigen/Core>
#include <atomic>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "costs/assimilation/assimilation.h"
#include "costs/field/field_request.h"
#include "costs/prediction/parameter_block.h"
#include "costs/prediction/robust_loss.h"
#include "costs/rollout_cost.h"
#include "datasets/motion/motion_file.h"
#include "datasets/observation/model_error.h"
#include "identify/base/evaluation_progress.h"
#include "identify/base/fit_stage.h"

namespace clothid {

// How precisely points are evaluated. What comes out of a fit is of full precision, but with kLoose.
enum class FitPrecision {
  kAdaptive,  // loosely until the next step is short, then fully; by numeric differences as kFull
  kFull,
  kLoose,  // the loose part alone: for the start of another fit (FitSummary::next); by numeric differences as kFull
};

// What of the discretisation an answer is to count with (identify/checks/discretization_check.h).
struct DiscretizationParts {
  bool step = false;  // the time step
  bool mesh = false;

  bool any() const { return step || mesh; }
};

// Of the simulation, in every recording.
struct TimeStepOption {
  double seconds = 0.0;       // 0: that of each scene
  bool is_automatic = false;  // the coarsest whose error hides in the noise (identify/checks/step_choice.h)
};

// Whether the recordings correct the rollouts of a fit (costs/assimilation/assimilation.h).
struct AssimilationOption {
  enum class Kind {
    kOff,
    kAuto,    // from a short memory to the longest that serves; the exact fit where nothing but noise is left
    kMemory,  // with the one that is given
  };
  Kind kind = Kind::kOff;
  Assimilation given;  // kMemory

  bool is_on() const { return kind != Kind::kOff; }
};

// One accepted point of the optimiser.
struct FitIteration {
  int iteration = 0;
  double seconds = 0.0;  // since the start of the fit
  Precision precision = Precision::kFull;
  double cost = 0.0;           // the lowest so far at this precision
  Eigen::VectorXd values;      // [p] the parameters at that cost, in their own units
  double gradient_norm = 0.0;  // |dL/dq| in the internal coordinates; NaN where it was not needed
  int rollouts = 0;            // so far
};

// How the names of journals start: hidden files.
inline constexpr char kJournalPrefix[] = ".journal_";

struct FitOptions {
  // Names to fit; empty: mu, where there are obstacles, and k_stretch, or k_warp and k_weft of an orthotropic membrane.
  // Here and in `each` shift, turn, v0 and align stand for several (costs/prediction/alignment.h).
  std::vector<std::string> parameters;
  // Names that are fitted, too, and that every recording has for itself: "drag" becomes "drag@1", "drag@2", .. in the
  // order of the recordings; with one recording it stays "drag".
  std::vector<std::string> each;
  ParameterOverrides overrides;
  // How far the wind may wander, m/s in a second: between neighbouring knots of a fitted profile that are h apart its
  // difference is believed to be normal with the standard deviation wind_smoothness sqrt(h), where residuals are as
  // large as their sigma, and in proportion to them elsewhere (identify/uncertainty/priors.h). 0: nothing is believed.
  double wind_smoothness = 0.0;
  bool chooses_wind_smoothness = false;  // it is but the first one; the fit goes on to the likeliest
  // Constants to fit as fields, whose levels become parameters: the scenes must have fields of them (`SetFlatFields`).
  // `field_weight`: of what is believed of them, 1/2 weight times the integral of the squared Laplacian; 0: it is
  // chosen.
  std::vector<FieldRequest> fields;
  double field_weight = 0.0;
  JacobianMethod jacobian = JacobianMethod::kAdjoint;
  AssimilationOption assimilate;
  bool growing_horizon = true;  // a fit that knows its recordings is led by their first frames (fit/first_frames.h)
  AdjointOptions adjoint;       // how reverse sweeps solve their linear systems
  FitPrecision precision = FitPrecision::kAdaptive;
  RobustLoss loss;
  int max_iterations = 50;
  int num_starts = 1;      // of `FitFromStarts`
  std::uint64_t seed = 0;  // of its starting points
  // For recordings, or fits of several starts, side by side; where there are more threads than recordings, they share
  // the work of a rollout. Results do not depend on it.
  int num_threads = 1;
  // Relative changes at which the fit has converged. A step that satisfies them has been evaluated and is taken where
  // it is better, so the estimate is one (superlinear) step closer than the tolerance says.
  double function_tolerance = 1e-9;
  double parameter_tolerance = 1e-5;
  // Whether frames in which the model errs beyond the noise count for less
  // (identify/uncertainty/model_error_estimate.h). `model_errors`: of the recordings, known beforehand; empty: it does
  // not err, or the fit finds out.
  bool weighs_model_error = true;
  std::vector<ModelError> model_errors;
  bool estimate_uncertainty = true;  // one forward sweep at the estimate
  bool check_interval = true;        // of that uncertainty: two rollouts, where there is noise
  int max_continuations = 3;         // fits from lower points that this check meets
  // Where evaluations are kept and, when the same fit is run again, replayed, counts and seconds included
  // (total_seconds are those of the last run alone). One file per recording, .journal_1.bin or .journal_TAG_1.bin and
  // so on, see costs/rows/evaluation_journal.h; whoever runs the fit removes it. Fits in one folder need different
  // tags. Empty: nowhere.
  std::string journal_folder;
  std::string journal_tag;
  // Bytes of every journal for predictions, less than 1 GiB; those that find no room there are simulated again when the
  // fit is.
  std::uint64_t journal_room = kJournalRoom;
  const std::atomic<bool>* cancel = nullptr;  // may be null; true ends the fit with what it has
  bool is_cancelled() const { return cancel != nullptr && cancel->load(); }
  std::function<void(const FitIteration&)> on_iteration;  // may be empty
  std::function<void(int start)> on_start;                // before each fit of `FitFromStarts`; may be empty
  // When a stage of the plan begins, is skipped or has ended: `stage` is its number in `plan`. May be empty.
  std::function<void(const FitPlan& plan, int stage)> on_stage;
  // Of every evaluation of a problem made with these options; must outlive it. No result depends on it. May be empty.
  ProgressObserver on_progress;

  // Throws `Error` (kUsage) naming the first value out of range.
  void Validate() const;
};

// "a,b,c", with or without blanks around the items. Throws `Error` (kUsage), naming `flag`, for an empty item or one
// given twice.
std::vector<std::string> ParseNames(const std::string& text, const std::string& flag);
// "adjoint", "sensitivity" or "numeric"; "adaptive" or "full". Throw `Error` (kUsage).
JacobianMethod ParseJacobianMethod(const std::string& text);
FitPrecision ParseFitPrecision(const std::string& text);
std::string JacobianMethodName(JacobianMethod method);
// "recorded", "auto" or a number > 0 in m: what `ReadMotionOptions` is to do about sigma; "estimated", "rest",
// "moving", "smoothed" or "first": about the start. Throw `Error` (kUsage).
void ParseSigma(const std::string& text, ReadMotionOptions* options);
StartSource ParseStartSource(const std::string& text);
// "step", "mesh" or "all"; empty: none. Throws `Error` (kUsage).
DiscretizationParts ParseDiscretization(const std::string& text);
// "auto" or a number > 0 in s; empty: that of the scene. Throws `Error` (kUsage).
TimeStepOption ParseTimeStep(const std::string& text);
// Whether "growing", of "growing" and "full". Throws `Error` (kUsage).
bool ParseHorizon(const std::string& text);
// "off", "auto" or a memory > 0 in s. Throws `Error` (kUsage).
AssimilationOption ParseAssimilation(const std::string& text);
// METHOD[:THRESHOLD] of reduced, lu, fixed_point, gmres and a number in (0, 1). Throws `Error` (kUsage).
AdjointOptions ParseAdjointOptions(const std::string& text);

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_BASE_OPTIONS_H_
