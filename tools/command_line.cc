#include "tools/command_line.h"

#include <gflags/gflags.h>

#include <exception>
#include <iostream>
#include <optional>
#include <sstream>
#include <utility>

#include "sim/text_file.h"

namespace clothid {
namespace {

// gflags' own switches for help; each of them gets the tool's short help.
bool IsSet(const char* flag) {
  std::string value;
  return gflags::GetCommandLineOption(flag, &value) && value == "true";
}

std::pair<std::string, double> ParseAssignment(const std::string& entry, const std::string& flag) {
  const size_t equals = entry.find('=');
  if (equals != std::string::npos && equals > 0) {
    if (const std::optional<double> value = ParseNumber(std::string_view(entry).substr(equals + 1))) {
      return {entry.substr(0, equals), *value};
    }
  }
  throw Error(ErrorKind::kUsage, flag + ": '" + Printable(entry) + "': expected NAME=VALUE with a finite number");
}

}  // namespace

int RunCommand(const std::string& name, const std::string& help, int argc, char** argv, const Command& command) {
  gflags::ParseCommandLineNonHelpFlags(&argc, &argv, /*remove_flags=*/true);
  if (IsSet("help") || IsSet("helpfull") || IsSet("helpshort")) {
    std::cout << help;
    return kExitSuccess;
  }
  if (IsSet("version")) {
    std::cout << name << " (clothid) " << CLOTHID_VERSION << "\n";
    return kExitSuccess;
  }
  try {
    return command(std::vector<std::string>(argv + 1, argv + argc));
  } catch (const Error& error) {
    std::cerr << name << ": " << error.what() << "\n";
    return ExitCodeOf(error.kind());
  } catch (const std::exception& error) {
    std::cerr << name << ": internal error: " << error.what() << "\n";
    return kExitUsageOrIo;
  }
}

std::map<std::string, double> ParseAssignments(const std::string& text, const std::string& flag) {
  std::map<std::string, double> assignments;
  std::istringstream entries(text);
  for (std::string entry; std::getline(entries, entry, ',');) {
    const auto [name, value] = ParseAssignment(entry, flag);
    if (!assignments.emplace(name, value).second)
      throw Error(ErrorKind::kUsage, flag + ": '" + name + "' is given twice");
  }
  return assignments;
}

}  // namespace clothid
