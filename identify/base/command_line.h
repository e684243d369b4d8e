// What the command lines of our programs share: how flags are read, help, version, exceptions to exit codes. A library
// of its own, clothid::command_line, for programs alone: it takes gflags along.
#ifndef CLOTHID_IDENTIFY_BASE_COMMAND_LINE_H_
#define CLOTHID_IDENTIFY_BASE_COMMAND_LINE_H_

#include <functional>
#include <map>
#include <string>
#include <vector>

namespace clothid {

// The command itself; receives what is left of the command line once the flags are taken out.
using Command = std::function<int(const std::vector<std::string>& arguments)>;

// Flags that take lists, and what separates their items.
using ListFlags = std::map<std::string, char>;

// Sets the gflags that a command line gives, and returns its other words. A flag is --NAME VALUE or --NAME=VALUE, a
// switch --NAME, --NAME=false or --noNAME; one dash and dashes within the name do as well, -h is --help, and behind
// "--" there are no flags. Given several times, the last one counts, but of `lists` all, one after the other. Throws
// `Error` (kUsage), naming the flag, where there is none of that name, and where it has no value or one that it cannot
// have, a number that is not finite included.
std::vector<std::string> BindFlags(const std::string& program, const ListFlags& lists, int argc,
                                   const char* const* argv);

struct ProgramText {
  std::string name;     // leads every message
  std::string help;     // what --help prints
  std::string version;  // the line that --version prints
  ListFlags lists;
};

// Binds the flags, answers --help and --version, else runs `command` and returns its exit code. Whatever `command`
// throws ends as `ReportErrors` says (sim/base/program.h); so do flags that are wrong, and stdout that cannot be
// written.
int RunCommandLine(const ProgramText& program, int argc, char** argv, const Command& command);

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_BASE_COMMAND_LINE_H_
