// The flags of `identify` as texts and numbers, and the run that they ask for: for the program, and for other front
// ends that take the same words.
#ifndef CLOTHID_IDENTIFY_RUN_FLAGS_H_
#define CLOTHID_IDENTIFY_RUN_FLAGS_H_

#include <cstdint>
#include <string>

#include "identify/run.h"

namespace clothid {

// As `identify --help` explains them, with the values that they have where nobody gives them.
struct RunFlags {
  std::string target, scene, fabric;
  std::string fit, each, field;
  double field_weight = 0.0;
  std::string wind_profile;
  double wind_smoothness = 0.0;
  std::string start, lower, upper, prior;
  std::string jacobian = "adjoint", adjoint = "reduced", precision = "adaptive", loss = "none";
  std::string sigma = "recorded", initial = "estimated";
  bool check = true, check_gradients = false;
  int max_iterations = 50, threads = 1;
  std::string output;  // empty: nothing is written
  int starts = 1;
  std::uint64_t seed = 0;
  std::string profile, landscape, discretization, time_step;
  std::string holdout, holdout_frames;
  std::string horizon = "growing";
  std::string exports;  // --export
  bool resume = false, report = true;
  double step_tolerance = 0.0;
};

// Without `RunOptions::command_line` and callbacks. Throws `Error` (kUsage), naming the flag, for a text that it does
// not take; what goes with what is left to `RunOptions::Validate`.
RunOptions ParseRunFlags(const RunFlags& flags);

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_RUN_FLAGS_H_
