// `benchmark`: which flags its commands take, and what they refuse.
#include <gtest/gtest.h>

#include <regex>
#include <string>

#include "tests/tools/tool_test.h"

namespace clothid::benchmark_test {
namespace {

class BenchmarkTest : public ToolTest {};

// What a command does not take would be ignored, and whoever gave it would not know.
TEST_F(BenchmarkTest, RefusesFlagsOfOtherCommands) {
  ExpectRefused("benchmark forward --mu 1", 1, "--mu: is a flag of stability, not of forward");
  ExpectRefused("benchmark forward --threads 1", 1, "--threads: is a flag of stability");  // also its default
  ExpectRefused("benchmark accuracy --methods kept --steps 2", 1, "--methods: is a flag of backprop, not of accuracy");
  for (const char* command : {"forward", "backprop", "stability"}) {
    ExpectRefused(std::string("benchmark ") + command + " --quantities forward", 1,
                  std::string("--quantities: is a flag of accuracy, not of ") + command);
  }
}

// Nothing runs, because results cannot be written there.
TEST_F(BenchmarkTest, TakesTheFlagsOfItsHelp) {
  int num_flags = 0;
  for (const std::string command : {"forward", "backprop", "accuracy", "stability"}) {
    const std::string help = Run("benchmark " + command + " --help").out;
    const std::size_t begin = help.find("benchmark " + command + ": ");
    ASSERT_NE(begin, std::string::npos) << command;
    const std::string own = help.substr(begin, help.find("\nbenchmark ", begin) - begin);
    const std::regex flag(R"((?:\n  |; |, )--(\w+) )");
    for (std::sregex_iterator it(own.begin(), own.end(), flag), end; it != end; ++it) {
      const std::string name = (*it)[1];
      if (name == "output") continue;
      const ToolResult result = Run("benchmark " + command + " --" + name + " 1 --output /proc/absent");
      EXPECT_EQ(result.exit_code, 1);
      EXPECT_EQ(result.err.find("is a flag of"), std::string::npos) << command << " --" << name << "\n" << result.err;
      ++num_flags;
    }
  }
  EXPECT_GE(num_flags, 22);
}

TEST_F(BenchmarkTest, RefusesWhatItCannotRun) {
  ExpectRefused("benchmark", 1, "there is: forward");
  ExpectRefused("benchmark juggle", 1, "'juggle': unknown command; there is: forward");
  ExpectRefused("benchmark forward backprop", 1, "'backprop'");
  ExpectRefused("benchmark forward --scene moon", 1, "'moon'");
  ExpectRefused("benchmark forward --nodes 1", 1, "--nodes");
  ExpectRefused("benchmark backprop --methods guess", 1, "'guess'");
  ExpectRefused("benchmark stability --threads 0", 1, "--threads");
  WriteBytes(folder() / "file", "");
  ExpectRefused("benchmark forward --output file", 1, "file");
}

}  // namespace
}  // namespace clothid::benchmark_test
