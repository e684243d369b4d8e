// What the command-line tools share: help, version, and exceptions to exit codes.
#ifndef CLOTHID_TOOLS_BASE_COMMAND_LINE_H_
#define CLOTHID_TOOLS_BASE_COMMAND_LINE_H_

#include <functional>
#include <string>
#include <vector>

#include "sim/base/error.h"

namespace clothid {

// The command itself; receives what is left of the command line once the flags are taken out.
using Command = std::function<int(const std::vector<std::string>& arguments)>;

// Binds gflags to the command line, answers --help with `help` and --version, else runs `command` and returns its exit
// code. Whatever `command` throws ends as one line on stderr, led by `name`, and as an exit code; so does stdout that
// cannot be written (sim/base/program.h). An unknown flag ends the process with exit code 1 and one line from gflags.
int RunCommand(const std::string& name, const std::string& help, int argc, char** argv, const Command& command);

}  // namespace clothid

#endif  // CLOTHID_TOOLS_BASE_COMMAND_LINE_H_
