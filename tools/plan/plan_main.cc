// plan: tells before the laboratory which motion would tell which parameter.
#include <malloc.h>
#include <unistd.h>

#include <iostream>
#include <string>
#include <vector>

#include "identify/base/command_line.h"
#include "identify/base/register_flag.h"
#include "identify/base/version.h"
#include "identify/experiment/experiment_plan.h"
#include "identify/experiment/plan_flags.h"
#include "sim/base/error.h"
#include "sim/base/program.h"
#include "tools/base/count_progress.h"
#include "tools/plan/plan_help.h"

namespace clothid {
namespace {

// A sweep makes and drops matrices of some megabytes in every step. Given back to the system each time, and asked for
// again, they take a quarter of the time of a plan.
void KeepFreedMemory() {
#ifdef __GLIBC__
  constexpr int kMegabyte = 1 << 20;
  mallopt(M_MMAP_THRESHOLD, 32 * kMegabyte);  // the largest that it takes
  mallopt(M_TRIM_THRESHOLD, 1024 * kMegabyte);
#endif
}

int Run(const PlanFlags& flags, const std::string& command_line) {
  if (flags.scenes.empty()) throw Error(ErrorKind::kUsage, "--scenes is missing; see plan --help");
  PlanOptions options = ParsePlanFlags(flags);
  options.command_line = command_line;
  options.fit.cancel = &CatchInterrupts();
  KeepFreedMemory();
  Plan plan;
  {
    CountProgress progress(&std::cerr, isatty(STDERR_FILENO) != 0, "cloths", CountProgress::End::kQuiet);
    options.on_progress = [&](int num_done, int num_cloths) { progress.Print(num_done, num_cloths); };
    plan = PlanExperiment(options);
  }
  if (options.fit.is_cancelled()) {
    std::cerr << "plan: interrupted, nothing is written\n";
    return kExitInterrupted;
  }
  std::cout << PlanTable(plan);
  return plan.has_any() ? kExitSuccess : kExitNotConverged;
}

}  // namespace
}  // namespace clothid

int main(int argc, char** argv) {
  static clothid::PlanFlags flags;
  clothid::VisitPlanFlags(&flags, [](const char* name, auto* field) { clothid::RegisterFlag(name, __FILE__, field); });
  const std::string command_line = clothid::JoinArguments(argc, argv);
  const auto run = [&](const std::vector<std::string>&) { return clothid::Run(flags, command_line); };
  clothid::Program program = {"plan", clothid::kHelp, clothid::kMoreHelp, {{"", {}, "", run}}};
  for (const char* list : {"scenes", "fit", "each", "start", "lower", "upper", "prior"}) program.lists[list] = ',';
  clothid::RunCommandLine(program, argc, argv);
}
