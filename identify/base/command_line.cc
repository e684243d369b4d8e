#include "identify/base/command_line.h"

#include <gflags/gflags.h>
#include <signal.h>

#include <algorithm>
#include <initializer_list>
#include <iostream>
#include <optional>
#include <sstream>
#include <utility>

#include "identify/base/join_words.h"
#include "sim/base/error.h"
#include "sim/base/program.h"
#include "sim/base/text_file.h"

namespace clothid {
namespace {

using Words = std::vector<std::string>;

constexpr char kSwitch[] = "bool";  // the type of a flag that needs no value

[[noreturn]] void FailUsage(const std::string& message) { throw Error(ErrorKind::kUsage, message); }
[[noreturn]] void FailFlag(const std::string& flag, const std::string& problem) {
  FailUsage("--" + Printable(flag) + ": " + problem);
}

// Of the flags of gflags itself there are two.
std::optional<gflags::CommandLineFlagInfo> FindFlag(const std::string& name) {
  gflags::CommandLineFlagInfo info;
  if (!gflags::GetCommandLineFlagInfo(name.c_str(), &info)) return std::nullopt;
  const std::string file = info.filename.substr(info.filename.rfind('/') + 1);
  if (file.rfind("gflags", 0) == 0 && name != "help" && name != "version") return std::nullopt;
  return info;
}

bool IsSwitch(const std::string& name) {
  const auto flag = FindFlag(name);
  return flag && flag->type == kSwitch;
}

bool IsOn(const std::string& name) {
  const auto flag = gflags::GetCommandLineFlagInfoOrDie(name.c_str());
  return !flag.is_default && !(flag.type == kSwitch && flag.current_value == "false");
}

std::string Expected(const std::string& type) {
  if (type == kSwitch) return "true or false";
  if (type == "double") return "a finite number";
  return type.front() == 'u' ? "a whole number >= 0" : "a whole number";
}

struct GivenFlag {
  std::string name;
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
  if (FindFlag(flag.name)) {
    if (IsSwitch(flag.name) && !flag.value) flag.value = "true";
    return flag;
  }
  const bool is_negated = flag.name.compare(0, 2, "no") == 0 && !flag.value;
  if (is_negated && IsSwitch(flag.name.substr(2))) return {flag.name.substr(2), "false"};
  FailFlag(flag.name, "unknown flag; see " + program + " --help");
}

void SetFlag(const std::string& name, const std::string& value) {
  const std::string type = FindFlag(name)->type;
  const bool is_finite = type != "double" || ParseNumber(value);
  if (is_finite && !gflags::SetCommandLineOption(name.c_str(), value.c_str()).empty()) return;
  FailFlag(name, "expected " + Expected(type) + ", got '" + Printable(value) + "'");
}

// Sets the flags and returns the other words.
Words BindFlags(const Program& program, int argc, const char* const* argv) {
  Words words;
  std::map<std::string, std::string> given;  // lists so far
  for (int i = 1; i < argc; ++i) {
    const std::string word = argv[i];
    if (word == "--") {
      words.insert(words.end(), argv + i + 1, argv + argc);
      break;
    }
    if (word.size() < 2 || word.front() != '-') {
      words.push_back(word);
      continue;
    }
    GivenFlag flag = ParseFlag(program.name, word);
    if (!flag.value) {
      if (i + 1 == argc) FailFlag(flag.name, "expected a value behind it; see " + program.name + " --help");
      flag.value = argv[++i];
    }
    if (flag.name == "help" && flag.value == "all") words.push_back(std::exchange(*flag.value, "true"));
    const auto list = program.lists.find(flag.name);
    if (list != program.lists.end()) {
      const auto [items, is_first] = given.emplace(flag.name, *flag.value);
      if (!is_first) items->second += list->second + *flag.value;
      flag.value = items->second;
    }
    SetFlag(flag.name, *flag.value);
  }
  return words;
}

// Null where there is none of that name.
const Command* FindCommand(const Program& program, const std::string& name) {
  for (const Command& command : program.commands) {
    if (command.name == name) return &command;
  }
  return nullptr;
}

// The command that the first of `words` asks for, which is taken off them.
const Command& TakeCommand(const Program& program, Words* words) {
  if (program.commands.size() == 1) return program.commands.front();
  if (const Command* const command = FindCommand(program, words->empty() ? "" : words->front())) {
    if (!command->name.empty()) words->erase(words->begin());
    return *command;
  }
  std::string known;
  for (const Command& each : program.commands) {
    if (!each.name.empty()) known += (known.empty() ? "" : ", ") + each.name;
  }
  FailUsage((words->empty() ? "a command is missing" : "'" + Printable(words->front()) + "': unknown command") +
            "; there is: " + known + "; see " + program.name + " --help");
}

void CheckArguments(const Program& program, const Command& command, const Words& words) {
  Words expected = command.arguments;
  const bool takes_more = !expected.empty() && expected.back() == "...";
  if (takes_more) expected.pop_back();
  const bool has_empty = std::find(words.begin(), words.end(), "") != words.end();
  if (!has_empty && (words.size() == expected.size() || (takes_more && words.size() > expected.size()))) return;
  const std::string see = "; see " + program.name + (command.name.empty() ? "" : " " + command.name) + " --help";
  if (expected.empty()) FailUsage("'" + Printable(words.front()) + "': unexpected argument" + see);
  FailUsage(command.name + ": expected " + JoinWords(expected) + see);
}

// A flag of another command would be ignored.
void RejectOtherFlags(const Program& program, const Command& command) {
  std::map<std::string, Words> takers;  // by flag
  for (const Command& each : program.commands) {
    std::istringstream flags(each.flags);
    for (std::string flag; flags >> flag;) takers[flag].push_back(each.name.empty() ? program.name : each.name);
  }
  const std::string name = command.name.empty() ? program.name : command.name;
  for (const auto& [flag, names] : takers) {
    const bool is_given = !gflags::GetCommandLineFlagInfoOrDie(flag.c_str()).is_default;
    if (!is_given || std::count(names.begin(), names.end(), name) > 0) continue;
    FailFlag(flag, "is a flag of " + JoinWords(names) + ", not of " + name);
  }
}

void CheckRule(const FlagRule& rule) {
  std::string values;
  bool is_met = rule.values.empty() && IsOn(rule.other) == (rule.relation == FlagRule::kWith);
  for (const std::string& value : rule.values) {
    is_met |= gflags::GetCommandLineFlagInfoOrDie(rule.other.c_str()).current_value == value;
    values += (values.empty() ? " " : " or ") + value;
  }
  if (is_met) return;
  std::istringstream flags(rule.flags);
  for (std::string flag; flags >> flag;) {
    if (!IsOn(flag)) continue;
    FailFlag(flag,
             (rule.relation == FlagRule::kWith ? "expected with --" : "expected without --") + rule.other + values);
  }
}

int PrintHelp(const Program& program, const Words& topics) {
  const std::string topic = topics.empty() ? "" : topics.front();
  const Command* const command = FindCommand(program, topic);
  if (topic == "all") {
    std::cout << program.help;
    for (const Command& each : program.commands) std::cout << (each.help.empty() ? "" : "\n") << each.help;
    std::cout << program.more;
  } else if (topic.empty() || command != nullptr) {
    std::cout << (command == nullptr || command->help.empty() ? program.help : command->help);
  } else {
    FailUsage("--help: expected nothing, all or a command behind it, got '" + Printable(topic) + "'");
  }
  return kExitSuccess;
}

int Answer(const Program& program, int argc, const char* const* argv) {
  Words words = BindFlags(program, argc, argv);
  if (IsOn("help")) return PrintHelp(program, words);
  if (IsOn("version")) {
    std::cout << program.name << " (clothid) " << CLOTHID_VERSION << (program.git.empty() ? "" : " git ") << program.git
              << "\n";
    return kExitSuccess;
  }
  const Command& command = TakeCommand(program, &words);
  RejectOtherFlags(program, command);
  for (const FlagRule& rule : program.rules) CheckRule(rule);
  CheckArguments(program, command, words);
  return command.run(words);
}

// From before any library is set up until after all of them SIGINT, SIGTERM and SIGHUP are blocked: threads that
// libraries make meanwhile, OpenBLAS among them, block them for good. So they never run the handler that METIS has for
// a while, see `CatchInterrupts` in sim/base/program.h.
void ChangeSignals(int how) {
  sigset_t signals;
  sigemptyset(&signals);
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) sigaddset(&signals, signal);
  pthread_sigmask(how, &signals, nullptr);
}
// Functions of this section come first, in programs; libraries may have none.
[[maybe_unused]] void BlockSignals(int, char**, char**) { ChangeSignals(SIG_BLOCK); }
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)  // which are libraries themselves
[[gnu::section(".preinit_array"), gnu::used]] void (*const block_signals)(int, char**, char**) = BlockSignals;
#endif
[[gnu::constructor]] void UnblockSignals() { ChangeSignals(SIG_UNBLOCK); }

}  // namespace

std::string JoinArguments(int argc, char** argv) {
  std::string line;
  for (int i = 1; i < argc; ++i) line += (i > 1 ? " " : "") + std::string(argv[i]);
  return line;
}

void RunCommandLine(const Program& program, int argc, char** argv) {
  CatchFileSizeLimit();
  EndProcess(FinishOutput(program.name, ReportErrors(program.name, [&] { return Answer(program, argc, argv); })));
}

}  // namespace clothid
