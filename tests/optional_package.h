// What a test says when it is skipped because an optional package of Debian is absent or damaged.
#ifndef CLOTHID_TESTS_OPTIONAL_PACKAGE_H_
#define CLOTHID_TESTS_OPTIONAL_PACKAGE_H_

#include <string>

#include "tests/last_line.h"
#include "tools/base/run_program.h"

namespace clothid {

// Why python3 cannot import `module` of `package`: one line that names the package, or an empty text where it can.
inline std::string WhyNoPythonModule(const std::string& package, const std::string& module) {
  std::string error;
  // As programs of clothid look for it: another python3 on the path may lack what Debian's has.
  for (const char* python : {"python3", "/usr/bin/python3"}) {
    const ProgramResult result = RunProgram({python, "-c", "import " + module});
    if (result.exit_code == 0) return "";
    if (result.exit_code != 127 && error.empty()) error = LastLine(result.err);
  }
  if (error.empty()) return "the package python3 is absent";
  const bool is_absent =
      error.find("No module named '" + module.substr(0, module.find('.')) + "'") != std::string::npos;
  return "the package " + package + (is_absent ? " is absent" : " is damaged: " + error);
}

}  // namespace clothid

#endif  // CLOTHID_TESTS_OPTIONAL_PACKAGE_H_
