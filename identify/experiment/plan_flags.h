// The flags of `plan` as texts and numbers, and the plan that they ask for: for the program, and for other front ends
// that take the same words.
#ifndef CLOTHID_IDENTIFY_EXPERIMENT_PLAN_FLAGS_H_
#define CLOTHID_IDENTIFY_EXPERIMENT_PLAN_FLAGS_H_

#include <cstdint>
#include <string>

#include "identify/experiment/plan_options.h"

namespace clothid {

// As `plan --help all` explains them, with the values that they have where nobody gives them.
struct PlanFlags {
  std::string scenes, predict, fit, each;
  std::string start, lower, upper, prior;
  double sigma = 0.0, frame_rate = 0.0;
  int markers = 0;
  bool forces = false;
  double force_sigma = 0.01, handle_sigma = 0.0;
  std::string initial = "estimated";
  int draws = 8;
  std::uint64_t seed = 1;
  int threads = 1;
  std::string output;  // empty: nothing is written
};

// Calls visit(name, field) for every one of `flags`, of the types above.
template <typename Visit>
void VisitPlanFlags(PlanFlags* flags, const Visit& visit) {
  visit("scenes", &flags->scenes);
  visit("predict", &flags->predict);
  visit("fit", &flags->fit);
  visit("each", &flags->each);
  visit("start", &flags->start);
  visit("lower", &flags->lower);
  visit("upper", &flags->upper);
  visit("prior", &flags->prior);
  visit("sigma", &flags->sigma);
  visit("frame_rate", &flags->frame_rate);
  visit("markers", &flags->markers);
  visit("forces", &flags->forces);
  visit("force_sigma", &flags->force_sigma);
  visit("handle_sigma", &flags->handle_sigma);
  visit("initial", &flags->initial);
  visit("draws", &flags->draws);
  visit("seed", &flags->seed);
  visit("threads", &flags->threads);
  visit("output", &flags->output);
}

// Without `PlanOptions::command_line` and callbacks. Throws `Error` (kUsage), naming the flag, for a text that it does
// not take; what goes with what is left to `PlanOptions::Validate`.
PlanOptions ParsePlanFlags(const PlanFlags& flags);

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_EXPERIMENT_PLAN_FLAGS_H_
