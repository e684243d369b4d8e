// The flags of `identify` as texts and numbers, and the run that they ask for: for the program, and for other front
// ends that take the same words.
#ifndef CLOTHID_IDENTIFY_RUN_FLAGS_H_
#define CLOTHID_IDENTIFY_RUN_FLAGS_H_

#include <cstdint>
#include <string>

#include "identify/run_options.h"

namespace clothid {

// As `identify --help all` explains them, with the values that they have where nobody gives them.
struct RunFlags {
  std::string target, scene, fabric;
  bool repeat = false, transfer = false;
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
  int holdout_draws = 20;
  bool calibrate_bands = false;
  std::string horizon = "growing", assimilate = "auto";
  std::string exports;  // --export
  bool resume = false, report = true;
  double step_tolerance = 0.0;
};

// Calls visit(name, field) for every one of `flags`, of the types above.
template <typename Visit>
void VisitRunFlags(RunFlags* flags, const Visit& visit) {
  visit("target", &flags->target);
  visit("repeat", &flags->repeat);
  visit("transfer", &flags->transfer);
  visit("scene", &flags->scene);
  visit("fabric", &flags->fabric);
  visit("fit", &flags->fit);
  visit("each", &flags->each);
  visit("field", &flags->field);
  visit("field_weight", &flags->field_weight);
  visit("wind_profile", &flags->wind_profile);
  visit("wind_smoothness", &flags->wind_smoothness);
  visit("start", &flags->start);
  visit("lower", &flags->lower);
  visit("upper", &flags->upper);
  visit("prior", &flags->prior);
  visit("jacobian", &flags->jacobian);
  visit("adjoint", &flags->adjoint);
  visit("precision", &flags->precision);
  visit("loss", &flags->loss);
  visit("sigma", &flags->sigma);
  visit("initial", &flags->initial);
  visit("check", &flags->check);
  visit("check_gradients", &flags->check_gradients);
  visit("max_iterations", &flags->max_iterations);
  visit("threads", &flags->threads);
  visit("output", &flags->output);
  visit("starts", &flags->starts);
  visit("seed", &flags->seed);
  visit("profile", &flags->profile);
  visit("landscape", &flags->landscape);
  visit("discretization", &flags->discretization);
  visit("time_step", &flags->time_step);
  visit("holdout", &flags->holdout);
  visit("holdout_frames", &flags->holdout_frames);
  visit("holdout_draws", &flags->holdout_draws);
  visit("calibrate_bands", &flags->calibrate_bands);
  visit("horizon", &flags->horizon);
  visit("assimilate", &flags->assimilate);
  visit("export", &flags->exports);
  visit("resume", &flags->resume);
  visit("report", &flags->report);
  visit("step_tolerance", &flags->step_tolerance);
}

// Without `RunOptions::command_line` and callbacks. A card of --fabric is read. Throws `Error` (kUsage), naming the
// flag, for a text that it does not take, and as `ReadToldCard` does; what goes with what is left to
// `RunOptions::Validate`.
RunOptions ParseRunFlags(const RunFlags& flags);

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_RUN_FLAGS_H_
