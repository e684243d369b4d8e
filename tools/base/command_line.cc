#include "tools/base/command_line.h"

#include <gflags/gflags.h>

#include <algorithm>
#include <map>
#include <sstream>
#include <stdexcept>

#include "identify/base/join_words.h"

namespace clothid {
namespace {

bool IsGiven(const std::string& flag) {
  gflags::CommandLineFlagInfo info;
  if (!gflags::GetCommandLineFlagInfo(flag.c_str(), &info)) throw std::logic_error("no flag is named " + flag);
  return !info.is_default;
}

}  // namespace

int RunCommand(const std::string& name, const std::string& help, int argc, char** argv, const Command& command,
               const ListFlags& lists) {
  return RunCommandLine({name, help, name + " (clothid) " + CLOTHID_VERSION, lists}, argc, argv, command);
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
