#include "tools/command_line.h"

#include <gflags/gflags.h>

#include <exception>
#include <iostream>

namespace clothid {
namespace {

// gflags' own switches for help; each of them gets the tool's short help.
bool IsSet(const char* flag) {
  std::string value;
  return gflags::GetCommandLineOption(flag, &value) && value == "true";
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

}  // namespace clothid
