// The command line of a program: flags, commands, help, version, exit codes. A main() names them and binds the flags,
// which are gflags, to what its commands take. A library of its own, clothid::command_line, for programs alone: it
// takes gflags along.
//
// A flag is --NAME VALUE or --NAME=VALUE, a switch --NAME, --NAME=false or --noNAME; one dash and dashes within the
// name do as well, -h is --help, and behind "--" there are no flags. Given several times, the last one counts, but of
// lists all, one after the other. Other words are a command and its arguments.
#ifndef CLOTHID_IDENTIFY_BASE_COMMAND_LINE_H_
#define CLOTHID_IDENTIFY_BASE_COMMAND_LINE_H_

#include <functional>
#include <map>
#include <string>
#include <vector>

namespace clothid {

// One of several things that a program does, or all that it does.
struct Command {
  std::string name;                    // the word that asks for it; empty: it is done where there is none
  std::vector<std::string> arguments;  // what its words are, for messages; "..." at the end: and any number of words
  std::string flags;                   // those that it takes, separated by blanks; of the only command not needed
  std::function<int(const std::vector<std::string>& arguments)> run;  // returns an exit code
  std::string help = {};                                              // `PROGRAM NAME --help`; empty: the program's
};

// A flag that would do nothing where another one is not given, or is.
struct FlagRule {
  enum Relation { kWith, kWithout };

  std::string flags;  // of each of these, separated by blanks
  Relation relation;
  std::string other;                     // the flag; of a switch that is off it counts as not given
  std::vector<std::string> values = {};  // one of which `other` must have, given or not; empty: any
};

struct Program {
  std::string name;  // leads every message
  std::string help;  // --help: how to call it, the flags of everyday use, an example
  std::string more;  // `--help all` is `help`, that of every command, and this: the other flags in groups, exit codes
  std::vector<Command> commands = {};
  std::vector<FlagRule> rules = {};
  std::map<std::string, char> lists = {};  // flags that take lists, and what separates their items
  std::string git = {};                    // hash of the sources, for --version
};

// Binds the flags, answers --help and --version, else runs the command, and ends the process with its exit code. What
// the command throws ends as `ReportErrors` says (sim/base/program.h). So do a flag that there is not, that has no
// value or one that it cannot have, a number that is not finite included, that the command does not take or that breaks
// a rule; a command that there is not; arguments that are too few, too many or empty; and stdout that cannot be
// written.
[[noreturn]] void RunCommandLine(const Program& program, int argc, char** argv);

// The arguments of a program, as one line for its results.
std::string JoinArguments(int argc, char** argv);

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_BASE_COMMAND_LINE_H_
