// `tools/benchmark/measure_large_fit` on a recording of no size.
#include <gtest/gtest.h>

#include <sstream>
#include <string>

#include "tests/tools/tool_test.h"

namespace clothid::measure_large_fit_test {
namespace {

constexpr char kScript[] =
    CLOTHID_SOURCE_DIR "/tools/benchmark/measure_large_fit --build '" CLOTHID_BINARY_DIR "' --folder files";

class MeasureLargeFitTest : public ToolTest {};

TEST_F(MeasureLargeFitTest, FitsWhatItHasMade) {
  const ToolResult result = Run(std::string(kScript) + " --nodes 10 --frames 40 --threads 1");
  ASSERT_EQ(result.exit_code, 0) << result.err;
  for (const char* expected : {"simulate", "identify", " GiB", "k_stretch", "converged"}) {
    EXPECT_NE(result.out.find(expected), std::string::npos) << expected << "\n" << result.out;
  }
  EXPECT_TRUE(std::filesystem::exists(folder() / "files/fit/report.html"));
}

TEST_F(MeasureLargeFitTest, AFitThatIsKilledAndResumedEndsInTheSameBytes) {
  const ToolResult result = Run(std::string(kScript) + " --nodes 16 --frames 40 --threads 1 --kill_after 0.05");
  EXPECT_EQ(result.exit_code, 0) << result.out << result.err;
  EXPECT_NE(result.out.find("the same table and predictions"), std::string::npos) << result.out;
}

TEST_F(MeasureLargeFitTest, EveryProgramHasARowOfMemory) {
  const ToolResult result = Run(std::string(kScript) + " --memory --nodes 6 --frames 5");
  ASSERT_EQ(result.exit_code, 0) << result.err;
  std::istringstream table(result.out);
  for (const char* expected : {"simulate", "adjoint", "sensitivity"}) {
    std::string name, gib, s, rest;
    double memory = 0.0, seconds = 0.0, size = 0.0;
    table >> name >> memory >> gib >> seconds >> s >> size;
    EXPECT_EQ(name, expected);
    EXPECT_EQ(gib, "GiB");
    EXPECT_GT(memory, 0.0);
    std::getline(table, rest);
    EXPECT_TRUE(table) << result.out;
  }
  EXPECT_TRUE(std::filesystem::exists(folder() / "files/adjoint/report.html"));
}

TEST_F(MeasureLargeFitTest, WrongArgumentsAreNamed) {
  const ToolResult result = Run(std::string(kScript) + " --nodes 1");
  EXPECT_NE(result.exit_code, 0);
  EXPECT_NE(result.err.find("at least 2 nodes"), std::string::npos) << result.err;
  EXPECT_TRUE(Files().empty());
}

}  // namespace
}  // namespace clothid::measure_large_fit_test
