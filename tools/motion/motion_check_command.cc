#include <gflags/gflags.h>

#include <iostream>
#include <string>
#include <vector>

#include "datasets/checking/motion_check.h"
#include "datasets/motion/motion_file.h"
#include "sim/base/error.h"
#include "sim/base/text_file.h"
#include "tools/motion/motion_commands.h"

DEFINE_bool(json, false, "check, friction: as JSON");

namespace clothid {

int MotionCheck(const std::vector<std::string>& arguments) {
  const std::string& path = arguments.front();
  ReadMotionOptions options;
  options.smooth_handles = false;
  const RecordedMotion motion = ReadMotion(path, options);
  const std::vector<Finding> findings = CheckMotion(motion);
  if (FLAGS_json) {
    std::cout << FindingsJson(findings, path);
  } else {
    std::cout << Escaped(path) << ": valid\n";
    PrintCoverage(motion);
    std::cout << "\n" << FindingsTable(findings);
  }
  std::string problems;
  for (const Finding& finding : findings) {
    if (finding.severity == Severity::kProblem) problems += (problems.empty() ? "" : ", ") + finding.what;
  }
  if (!problems.empty()) throw Error(ErrorKind::kBadData, path + ": cannot be fitted as it is: " + problems);
  return kExitSuccess;
}

}  // namespace clothid
