// What the command lines of all programs have in common: help, version, flags, commands.
#include <algorithm>
#include <regex>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "tests/tools/tool_test.h"

namespace clothid::command_line_test {
namespace {

const std::vector<std::string> kPrograms = {"identify", "simulate", "motion", "landscape", "plan", "benchmark"};

class CommandLineTest : public ToolTest {
 protected:
  std::string Help(const std::string& command) const {
    const ToolResult help = Run(command);
    EXPECT_EQ(help.exit_code, 0) << command;
    EXPECT_EQ(help.err, "") << command;
    return help.out;
  }
};

// The second groups of all matches.
std::set<std::string> Find(const std::string& pattern, const std::string& text) {
  std::set<std::string> found;
  const std::regex regex(pattern);
  for (std::sregex_iterator match(text.begin(), text.end(), regex), end; match != end; ++match)
    found.insert((*match)[2]);
  return found;
}

// The flags that the sources of a program define.
std::set<std::string> DefinedFlags(const std::string& program) {
  const std::filesystem::path root = CLOTHID_SOURCE_DIR;
  std::set<std::string> flags;
  if (program == "identify") {
    flags = Find("(visit\\(\")(\\w+)", ReadBytes(root / "identify/run_flags.h"));
    flags.insert("result");
    return flags;
  }
  if (program == "plan") return Find("(visit\\(\")(\\w+)", ReadBytes(root / "identify/experiment/plan_flags.h"));
  for (const auto& entry : std::filesystem::directory_iterator(root / "tools" / program)) {
    if (entry.path().extension() == ".cc") flags.merge(Find("(DEFINE_\\w+\\()(\\w+)", ReadBytes(entry.path())));
  }
  return flags;
}

TEST_F(CommandLineTest, HelpFitsOnAScreen) {
  for (const std::string& program : kPrograms) {
    const std::string help = Help(program + " --help");
    EXPECT_EQ(help.rfind(program + ": ", 0), 0u) << help;
    EXPECT_EQ(Help(program + " -h"), help);
    EXPECT_EQ(Run(program + " --version").out.rfind(program + " (clothid) ", 0), 0u);
    EXPECT_NE(help.find("\nExample"), std::string::npos) << help;
    EXPECT_LE(std::count(help.begin(), help.end(), '\n'), 40) << help;
    std::istringstream lines(help);
    for (std::string line; std::getline(lines, line);) EXPECT_LE(line.size(), 80u) << line;
  }
}

TEST_F(CommandLineTest, HelpAllNamesEveryFlag) {
  for (const std::string& program : kPrograms) {
    const std::string all = Help(program + " --help all");
    EXPECT_EQ(Help(program + " --help=all"), all);
    EXPECT_EQ(all.rfind(Help(program + " --help"), 0), 0u) << "the flags of everyday use come first";
    const std::set<std::string> defined = DefinedFlags(program);
    EXPECT_GE(defined.size(), 13u) << program;
    const std::set<std::string> told = Find("(--)(\\w+)", all);
    for (const std::string& flag : defined) {
      EXPECT_TRUE(told.count(flag) > 0 || told.count("no" + flag) > 0) << program << " --" << flag;
    }
    // Those that lines begin with are its own.
    for (const std::string& flag : Find("(\n  --)(\\w+)", all)) {
      const bool is_negated = flag.rfind("no", 0) == 0 && defined.count(flag.substr(2)) > 0;
      EXPECT_TRUE(defined.count(flag) > 0 || is_negated || flag == "help" || flag == "version")
          << program << " --" << flag;
    }
  }
}

TEST_F(CommandLineTest, CommandsHaveAHelpOfTheirOwn) {
  const std::string all = Help("motion --help all");
  for (const std::string command : {"check", "convert", "convert_clouds", "convert_curve", "convert_cantilever", "friction"}) {
    const std::string help = Help("motion " + command + " --help");
    EXPECT_EQ(help.rfind("motion " + command + " ", 0), 0u) << help;
    EXPECT_EQ(Help("motion --help " + command), help);
    EXPECT_NE(all.find(help), std::string::npos) << help;
  }
  EXPECT_EQ(Help("motion info --help"), Help("motion --help"));
  ExpectRefused("motion --help paint", 1, "--help: expected nothing, all or a command behind it, got 'paint'");
}

TEST_F(CommandLineTest, RefusesFlagsOfTheLibrary) {
  WriteBytes(folder() / "flags", "--help\n");
  for (const std::string& program : kPrograms) {
    for (const std::string flag : {"--flagfile=flags", "--fromenv=x", "--undefok=bogus", "--helpxml", "--nobogus"}) {
      ExpectRefused(program + " " + flag, 1, program + ": " + flag.substr(0, flag.find('=')) + ": unknown flag");
    }
  }
}

TEST_F(CommandLineTest, RefusesWrongCommandsAndArguments) {
  ExpectRefused("identify extra", 1, "'extra': unexpected argument; see identify --help");
  ExpectRefused("identify ''", 1, "'': unexpected argument");
  ExpectRefused("landscape ''", 1, "'': unexpected argument");
  ExpectRefused("motion", 1,
                "a command is missing; there is: info, check, view, convert, convert_clouds, convert_curve");
  ExpectRefused("motion paint", 1, "'paint': unknown command; there is: info, check");
  ExpectRefused("motion info", 1, "info: expected one file; see motion info --help");
  ExpectRefused("motion convert a.bin ''", 1, "convert: expected a file to read and one to write");
  ExpectRefused("benchmark", 1, "a command is missing; there is: forward");
  ExpectRefused("benchmark forward backprop", 1, "'backprop': unexpected argument");
}

}  // namespace
}  // namespace clothid::command_line_test
