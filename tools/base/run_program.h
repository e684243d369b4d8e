// Runs another program, without a shell in between.
#ifndef CLOTHID_TOOLS_BASE_RUN_PROGRAM_H_
#define CLOTHID_TOOLS_BASE_RUN_PROGRAM_H_

#include <string>
#include <vector>

namespace clothid {

struct ProgramResult {
  int exit_code = 127;  // 127: it could not be started; 128 + number for a signal that ended it
  std::string err;      // what it wrote to stderr
};

// `arguments`: the program, on the path or with its folder, and what follows. It reads nothing from stdin, and what it
// writes to stdout is lost. Waits for its end.
ProgramResult RunProgram(const std::vector<std::string>& arguments);

}  // namespace clothid

#endif  // CLOTHID_TOOLS_BASE_RUN_PROGRAM_H_
