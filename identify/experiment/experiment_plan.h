// Before the laboratory: how sure a fit would be of a cloth's parameters if candidate experiments were recorded.
//
//   PlanOptions options;
//   options.scene_paths = {"swing.json", "drape.json"};
//   options.fit.parameters = {"mu", "k_stretch", "k_bend"};
//   options.sigma = 0.002;
//   options.frame_rate = 30.0;
//   const Plan plan = PlanExperiment(options);
//   if (plan.candidates[0].parameters[2].is_told) Record();
//
// Every candidate is a scene. Its cloth is simulated, seen without noise, and the Jacobian J of the residuals over
// sigma is taken there, at the truth, by one forward sweep. What a fit of such a recording would estimate beside the
// parameters (its start, where its handles are) is eliminated as the fit does (identify/uncertainty/marginal.h), priors
// are added, and what is left is judged as after a fit (identify/uncertainty/uncertainty.h), with the error of the time
// step (identify/checks/step_error.h). Two recordings tell what both do: their rows add up, priors count once.
//
// What is known beforehand decides what a motion tells. So the cloth is the nominal one and `num_draws` others, the
// same draws for every candidate. Parameters of the cloth and of obstacles are drawn from their priors; without one,
// stiffness, density, drag, damping and friction are the nominal ones times 1.5^z with a standard normal z, within 1 %
// of the range off their bounds. All else stays nominal: wind, k_poisson and what belongs to a recording itself.
//
// Over the cloths that could be simulated,
//   std        = root mean square of the standard deviations of q (log of a scale; costs/prediction/parameter_block.h),
//                over those in which the parameter is told
//   told_share = the share of cloths in which a fit would call the parameter identifiable
//   interval   = nominal value(q -+ 1.96 sqrt(std^2 + step_error^2)), cut at the bounds; step_error is that of the
//                nominal cloth
//
// What would help most is told by the same sweep with other rows or other weights:
//   kTwiceFrames   twice the frame rate
//   kHalfNoise     half the standard deviation of the points, forces as they are
//   kGauge         the forces on all handles together at every frame, with `force_sigma`
//   kMoreMarkers   twice the markers; of a recording that sees every node, points between them that tell as much
//   kLonger        half as long again, handles as they move by then
//   kKnownStart    the start is stated: where the cloth and its handles are, and how fast, is known exactly
//   kHalfStep      half the time step, whose error is half as large
//   kBothScenes    another candidate as well
// each with the factor by which the width of every interval changes: of its part from noise, but with kHalfStep of all
// of it. There an interval counts with what was believed before: its prior, or the range between bounds (`BelievedStd`)
// as one more measurement. So it is finite, and what nothing tells has the factor 1. The worst told parameter is the
// one whose interval from noise is the widest beside that belief. kLonger is told of the nominal cloth alone.
#ifndef CLOTHID_IDENTIFY_EXPERIMENT_EXPERIMENT_PLAN_H_
#define CLOTHID_IDENTIFY_EXPERIMENT_EXPERIMENT_PLAN_H_

#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <limits>
#include <string>
#include <vector>

#include "costs/prediction/parameter_block.h"
#include "datasets/motion/recorded_motion.h"
#include "identify/base/options.h"
#include "sim/scene/scene.h"

namespace clothid {

struct PlanOptions {
  std::vector<std::string> scene_paths;  // scene.json of every candidate
  // What would be fitted: `parameters`, `each`, `overrides`; and `num_threads`, `cancel`. Starting values are the
  // nominal cloth. Nothing else of it counts. A candidate takes those parameters that its scene has.
  FitOptions fit;
  // What would be recorded of each.
  double sigma = 0.0;         // m, > 0: standard deviation of a coordinate
  double frame_rate = 0.0;    // Hz; 0: a frame per step
  int num_markers = 0;        // free nodes, those of `simulate` with this seed; 0: every node
  bool has_forces = false;    // on all handles together, at every frame
  double force_sigma = 0.01;  // N, > 0: of a component, with `has_forces` or of the gauge that might help
  double handle_sigma = 0.0;  // m: of the measured path of handles that move; 0: it is exact
  StartSource start =
      StartSource::kEstimated;  // or kRest, kMoving: a fit estimates it; kScene: it is that of the scene
  int num_draws = 8;            // beside the nominal cloth
  std::uint64_t seed = 1;       // of draws and markers
  std::string output;           // the folder of plan.json and plan.html; empty: nothing is written
  std::string command_line;     // "flags" of plan.json
  std::function<void(int num_done, int num_cloths)> on_progress;  // may be empty; never two at a time

  // Throws `Error` (kUsage) naming the first value that is out of range.
  void Validate() const;
};

struct ExpectedParameter {
  std::string name;
  ParameterScale scale = ParameterScale::kLinear;
  bool is_in_scene = false;
  double value = std::numeric_limits<double>::quiet_NaN();  // of the nominal cloth
  // Of q; NaN where no cloth tells the parameter.
  double std = std::numeric_limits<double>::quiet_NaN();
  double known_start_std = std::numeric_limits<double>::quiet_NaN();  // if the start were known; NaN where it is
  double step_error = std::numeric_limits<double>::quiet_NaN();       // NaN: not known either
  double lower95 = std::numeric_limits<double>::quiet_NaN();          // of the value
  double upper95 = std::numeric_limits<double>::quiet_NaN();
  // Half the width of its interval over that of what was believed before, with that belief: at most 1.
  double share_of_belief = 1.0;
  double told_share = 0.0;  // of the cloths
  bool is_told = false;     // in more than half of them
  std::string not_told;     // why not, in words; empty where it is told
  std::string made_up_by;   // "k_stretch and density multiplied by one factor": what can move unseen; may be empty
};

enum class ImprovementKind {
  kTwiceFrames,
  kHalfNoise,
  kGauge,
  kMoreMarkers,
  kLonger,
  kKnownStart,
  kHalfStep,
  kBothScenes,
};
std::string ImprovementName(ImprovementKind kind);  // "twice the frame rate"

struct Improvement {
  ImprovementKind kind = ImprovementKind::kTwiceFrames;
  int partner = -1;                // of kBothScenes: the other candidate
  Eigen::VectorXd factors;         // [p] of all parameters of the plan: the width over what it was
  double worst = 1.0;              // that of the worst told parameter
  std::vector<std::string> tells;  // parameters that would be told, and are not
};

// Where on the nominal cloth and when the information sits. With every other unknown following a parameter so as to
// undo the most, [J d]^2 summed over the coordinates of a node and over those of a frame: all of it and what is
// believed add up to the precision 1/std^2 of q. A column for every parameter of the candidate's scene.
struct InformationMap {
  Eigen::VectorXd times;      // [T] s
  std::vector<int> columns;   // [c] which of the plan's parameters they are
  Eigen::MatrixXd per_node;   // [N x c]
  Eigen::MatrixXd per_frame;  // [T x c]
  Eigen::VectorXd of_forces;  // [c]
};

// The nominal cloth as it moves, for a replay.
struct NominalMotion {
  Scene scene;
  Eigen::VectorXd times;      // [T] s
  Eigen::MatrixXf positions;  // [3N x T] m of all nodes
  std::vector<int> seen;      // nodes that are recorded
};

struct CandidatePlan {
  std::string name;     // of the file, without .scene.json; the whole path where two have the same
  std::string failure;  // one line: why the nominal cloth could not be simulated; then there is nothing else
  double duration = 0.0, time_step = 0.0;  // s
  int num_frames = 0, num_points = 0, num_nodes = 0;
  StartSource start = StartSource::kScene;
  std::vector<std::string> failed_cloths;     // why, in the order of the draws; they do not count
  int num_cloths = 0;                         // that do
  std::vector<ExpectedParameter> parameters;  // [p] all of the plan
  int worst_told = 0;                         // of `parameters`
  std::vector<Improvement> improvements;      // what helps the worst told parameter the most comes first
  InformationMap map;
  NominalMotion motion;
};

struct PairPlan {
  int first = 0, second = 0;                  // candidates
  int num_cloths = 0;                         // that both could simulate
  std::vector<ExpectedParameter> parameters;  // of the joint fit; of FitOptions::each one of each recording
};

struct Plan {
  std::vector<std::string> parameters;    // names [p]
  std::vector<CandidatePlan> candidates;  // in the order of the options
  std::vector<PairPlan> pairs;            // of those that did not fail, in that order

  bool has_any() const;  // some candidate could be simulated
};

// Throws `Error`: kUsage for what `Validate` rejects, for parameters that no scene has and for what is said of those
// that are not fitted; kIo and kBadData for scenes; kIo for the output. A cloth that cannot be simulated never throws.
// The same bytes on any number of threads. Where `FitOptions::cancel` turned true, cloths fail, and nothing is written.
Plan PlanExperiment(const PlanOptions& options);

// What tells parameter i of the plan with the narrowest interval beside what was believed: a candidate, a pair; -1:
// none tells it.
int BestCandidate(const Plan& plan, std::size_t parameter);
int BestPair(const Plan& plan, std::size_t parameter);

// Two tables and what would help, for people; and plan.json (identify/experiment/README.md).
std::string PlanTable(const Plan& plan);
std::string PlanJson(const PlanOptions& options, const Plan& plan);
// plan.html: what plan.json says, as pictures: the motion that tells each parameter best, expected intervals as bars on
// a common axis, and every motion as a replay in the colours of the information per node, with that per frame below it.
// The page is like that of a fit (identify/report/report_page.h): one file below kMaxReportBytes, for which frames are
// left out, that asks no server for anything, in which names are shown and never run. The same bytes for the same plan.
std::string PlanHtml(const PlanOptions& options, const Plan& plan);

inline constexpr char kPlanFile[] = "plan.json", kPlanPageFile[] = "plan.html";

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_EXPERIMENT_EXPERIMENT_PLAN_H_
