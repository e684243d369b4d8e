#include "tools/base/command_line.h"

#include <gflags/gflags.h>

#include <exception>
#include <iostream>

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
  try {
    return command(arguments);
  } catch (const Error& error) {
    std::cerr << name << ": " << error.what() << "\n";
    return ExitCodeOf(error.kind());
  } catch (const std::exception& error) {
    std::cerr << name << ": internal error: " << error.what() << "\n";
    return kExitUsageOrIo;
  }
}

}  // namespace

int RunCommand(const std::string& name, const std::string& help, int argc, char** argv, const Command& command) {
  CatchFileSizeLimit();
  gflags::ParseCommandLineNonHelpFlags(&argc, &argv, /*remove_flags=*/true);
  return FinishOutput(name, Answer(name, help, std::vector<std::string>(argv + 1, argv + argc), command));
}

}  // namespace clothid
