// What the command-line tools share: help, version, exceptions to exit codes, and which command takes which flags.
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
// code. Whatever `command` throws ends as `ReportErrors` says (sim/base/program.h); so does stdout that cannot be
// written. An unknown flag ends the process with exit code 1 and one line from gflags.
int RunCommand(const std::string& name, const std::string& help, int argc, char** argv, const Command& command);

// A command of a program that has several.
struct CommandFlags {
  std::string command;
  std::string flags;  // the names of those that it takes, separated by blanks
};

// Throws `Error` (kUsage), naming the flag and the commands that take it, where a flag of another of `commands` was
// given that `command`, which is one of them, does not take: it would be ignored.
void RejectOtherFlags(const std::string& command, const std::vector<CommandFlags>& commands);

}  // namespace clothid

#endif  // CLOTHID_TOOLS_BASE_COMMAND_LINE_H_
