#include "tools/base/command_line.h"

#include <gflags/gflags.h>

#include <algorithm>
#include <iostream>
#include <map>
#include <sstream>
#include <stdexcept>

#include "identify/base/join_words.h"
#include "sim/base/program.h"

namespace clothid {
namespace {

// gflags' own switches for help; each of them gets the tool's short help.
bool IsSet(const char* flag) {
  std::string value;
  return gflags::GetCommandLineOption(flag, &value) && value == "true";
}

int Answer(const std::string& name, const std::string& help, const std::vector<std::string>& arguments,
           const Command& command) {
  if (IsSet("help") || IsSet("helpfull") || IsSet("helpshort")) {
    std::cout << help;
    return kExitSuccess;
  }
  if (IsSet("version")) {
    std::cout << name << " (clothid) " << CLOTHID_VERSION << "\n";
    return kExitSuccess;
  }
  return command(arguments);
}

bool IsGiven(const std::string& flag) {
  gflags::CommandLineFlagInfo info;
  if (!gflags::GetCommandLineFlagInfo(flag.c_str(), &info)) throw std::logic_error("no flag is named " + flag);
  return !info.is_default;
}

}  // namespace

int RunCommand(const std::string& name, const std::string& help, int argc, char** argv, const Command& command) {
  CatchFileSizeLimit();
  gflags::ParseCommandLineNonHelpFlags(&argc, &argv, /*remove_flags=*/true);
  const std::vector<std::string> arguments(argv + 1, argv + argc);
  return FinishOutput(name, ReportErrors(name, [&] { return Answer(name, help, arguments, command); }));
}

void RejectOtherFlags(const std::string& command, const std::vector<CommandFlags>& commands) {
  std::map<std::string, std::vector<std::string>> takers;  // by flag
  for (const CommandFlags& each : commands) {
    std::istringstream flags(each.flags);
    for (std::string flag; flags >> flag;) takers[flag].push_back(each.command);
  }
  for (const auto& [flag, names] : takers) {
    if (!IsGiven(flag) || std::count(names.begin(), names.end(), command) > 0) continue;
    throw Error(ErrorKind::kUsage, "--" + flag + ": is a flag of " + JoinWords(names) + ", not of " + command);
  }
}

}  // namespace clothid
