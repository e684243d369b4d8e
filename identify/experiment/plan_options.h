// What a plan of experiments is asked for.
#ifndef CLOTHID_IDENTIFY_EXPERIMENT_PLAN_OPTIONS_H_
#define CLOTHID_IDENTIFY_EXPERIMENT_PLAN_OPTIONS_H_

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "datasets/motion/recorded_motion.h"
#include "identify/base/options.h"

namespace clothid {

struct PlanOptions {
  std::vector<std::string> scene_paths;  // scene.json of every candidate
  // A scene.json whose motion is to be predicted (identify/experiment/prediction_width.h); empty: none is.
  std::string predicted_path;
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

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_EXPERIMENT_PLAN_OPTIONS_H_
