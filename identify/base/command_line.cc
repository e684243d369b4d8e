#include "identify/base/command_line.h"

#include <gflags/gflags.h>

#include <algorithm>
#include <cstdlib>
#include <iostream>
#include <map>
#include <optional>

#include "identify/base/program_start.h"
#include "sim/base/error.h"
#include "sim/base/program.h"
#include "sim/base/text_file.h"

namespace clothid {
namespace {

constexpr char kSwitch[] = "bool";  // the type of a flag that needs no value

[[noreturn]] void Fail(const std::string& flag, const std::string& problem) {
  throw Error(ErrorKind::kUsage, "--" + Printable(flag) + ": " + problem);
}

std::optional<std::string> TypeOf(const std::string& flag) {
  gflags::CommandLineFlagInfo info;
  if (!gflags::GetCommandLineFlagInfo(flag.c_str(), &info)) return std::nullopt;
  return info.type;
}

std::string Expected(const std::string& type) {
  if (type == kSwitch) return "true or false";
  if (type == "double") return "a finite number";
  return type.front() == 'u' ? "a whole number >= 0" : "a whole number";
}

struct GivenFlag {
  std::string name, type;
  std::optional<std::string> value;  // absent: the next word
};

// Of a word that starts with a dash.
GivenFlag ParseFlag(const std::string& program, const std::string& word) {
  const std::size_t begin = word.compare(0, 2, "--") == 0 ? 2 : 1;
  const std::size_t equals = std::min(word.find('=', begin), word.size());
  GivenFlag flag;
  flag.name = word.substr(begin, equals - begin);
  std::replace(flag.name.begin(), flag.name.end(), '-', '_');
  if (flag.name == "h") flag.name = "help";
  if (equals < word.size()) flag.value = word.substr(equals + 1);
  if (const auto type = TypeOf(flag.name)) {
    flag.type = *type;
    if (flag.type == kSwitch && !flag.value) flag.value = "true";
    return flag;
  }
  const bool is_negated = flag.name.compare(0, 2, "no") == 0 && !flag.value;
  if (is_negated && TypeOf(flag.name.substr(2)) == std::optional<std::string>(kSwitch)) {
    return {flag.name.substr(2), kSwitch, "false"};
  }
  Fail(flag.name, "unknown flag; see " + program + " --help");
}

void Set(const GivenFlag& flag) {
  const bool is_finite = flag.type != "double" || ParseNumber(*flag.value);
  if (is_finite && !gflags::SetCommandLineOption(flag.name.c_str(), flag.value->c_str()).empty()) return;
  Fail(flag.name, "expected " + Expected(flag.type) + ", got '" + Printable(*flag.value) + "'");
}

// gflags' own switches for help; each of them gets the program's short help.
bool IsSet(const char* flag) {
  std::string value;
  return gflags::GetCommandLineOption(flag, &value) && value == "true";
}

int Answer(const ProgramText& program, const std::vector<std::string>& arguments, const Command& command) {
  if (IsSet("help") || IsSet("helpfull") || IsSet("helpshort")) {
    std::cout << program.help;
    return kExitSuccess;
  }
  if (IsSet("version")) {
    std::cout << program.version << "\n";
    return kExitSuccess;
  }
  return command(arguments);
}

}  // namespace

std::vector<std::string> BindFlags(const std::string& program, const ListFlags& lists, int argc,
                                   const char* const* argv) {
  std::vector<std::string> arguments;
  std::map<std::string, std::string> given;  // lists so far
  for (int i = 1; i < argc; ++i) {
    const std::string word = argv[i];
    if (word == "--") {
      arguments.insert(arguments.end(), argv + i + 1, argv + argc);
      break;
    }
    if (word.size() < 2 || word.front() != '-') {
      arguments.push_back(word);
      continue;
    }
    GivenFlag flag = ParseFlag(program, word);
    if (!flag.value) {
      if (i + 1 == argc) Fail(flag.name, "expected a value behind it; see " + program + " --help");
      flag.value = argv[++i];
    }
    const auto list = lists.find(flag.name);
    if (list != lists.end()) {
      const auto [items, is_first] = given.emplace(flag.name, *flag.value);
      if (!is_first) items->second += list->second + *flag.value;
      flag.value = items->second;
    }
    Set(flag);
  }
  return arguments;
}

int RunCommandLine(const ProgramText& program, int argc, char** argv, const Command& command) {
  KeepSignalsFromLibraries();
  CatchFileSizeLimit();
  const int exit_code =
      FinishOutput(program.name, ReportErrors(program.name, [&] {
                     return Answer(program, BindFlags(program.name, program.lists, argc, argv), command);
                   }));
  // Without the ends of libraries: that of OpenBLAS waits for a thread that may wait for memory, for ever.
  if (exit_code == kExitInternal) std::_Exit(exit_code);
  return exit_code;
}

}  // namespace clothid
