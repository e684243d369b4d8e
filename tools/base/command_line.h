// What the command lines of the tools share beside identify/base/command_line.h: which command takes which flags.
#ifndef CLOTHID_TOOLS_BASE_COMMAND_LINE_H_
#define CLOTHID_TOOLS_BASE_COMMAND_LINE_H_

#include <string>
#include <vector>

#include "identify/base/command_line.h"
#include "sim/base/error.h"

namespace clothid {

// `RunCommandLine` of a tool, which answers --version with `name` and the version of clothid.
int RunCommand(const std::string& name, const std::string& help, int argc, char** argv, const Command& command,
               const ListFlags& lists = {});

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
