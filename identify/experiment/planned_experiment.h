// What a plan says of its candidates; identify/experiment/experiment_plan.h has the formulas.
#ifndef CLOTHID_IDENTIFY_EXPERIMENT_PLANNED_EXPERIMENT_H_
#define CLOTHID_IDENTIFY_EXPERIMENT_PLANNED_EXPERIMENT_H_

#include <Eigen/Core>
#include <limits>
#include <string>
#include <vector>

#include "costs/prediction/parameter_block.h"
#include "datasets/motion/recorded_motion.h"
#include "sim/scene/scene.h"

namespace clothid {

struct ExpectedParameter {
  std::string name;
  ParameterScale scale = ParameterScale::kLinear;
  bool is_in_scene = false;
  double value = std::numeric_limits<double>::quiet_NaN();  // of the nominal cloth
  // Of the logarithm or of the value, as `scale` says; NaN where no cloth tells the parameter.
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
// believed add up to the precision 1/std^2. A column for every parameter of the candidate's scene.
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
  double prediction_width = std::numeric_limits<double>::quiet_NaN();  // m; NaN: nothing is predicted
  std::vector<Improvement> improvements;  // what helps the worst told parameter the most comes first
  InformationMap map;
  NominalMotion motion;
};

struct PairPlan {
  int first = 0, second = 0;                  // candidates
  int num_cloths = 0;                         // that both could simulate
  std::vector<ExpectedParameter> parameters;  // of the joint fit; of FitOptions::each one of each recording
  double prediction_width = std::numeric_limits<double>::quiet_NaN();  // as of CandidatePlan
};

struct Plan {
  std::vector<std::string> parameters;    // names [p]
  std::vector<CandidatePlan> candidates;  // in the order of the options
  std::vector<PairPlan> pairs;            // of those that did not fail, in that order
  // What is to be predicted; empty: nothing. And how wide it is by what is believed alone, m.
  std::string predicted;
  double believed_width = std::numeric_limits<double>::quiet_NaN();

  bool has_any() const;  // some candidate could be simulated
};

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_EXPERIMENT_PLANNED_EXPERIMENT_H_
