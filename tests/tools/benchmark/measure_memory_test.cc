// `tools/benchmark/measure_memory` on a recording of no size: it runs to its end and says what was asked for.
#include <gtest/gtest.h>

#include <sstream>
#include <string>

#include "tests/tools/tool_test.h"

namespace clothid {
namespace {

constexpr char kScript[] =
    CLOTHID_SOURCE_DIR "/tools/benchmark/measure_memory --build '" CLOTHID_BINARY_DIR "' --folder files";

class MeasureMemoryTest : public ToolTest {};

TEST_F(MeasureMemoryTest, EveryProgramHasARow) {
  const ToolResult result = Run(std::string(kScript) + " --nodes 6 --frames 5 --methods sensitivity,adjoint");
  ASSERT_EQ(result.exit_code, 0) << result.err;
  std::istringstream table(result.out);
  for (const char* expected : {"simulate", "sensitivity", "adjoint"}) {
    std::string name, gib, s;
    double memory = 0.0, seconds = 0.0, size = 0.0;
    table >> name >> memory >> gib >> seconds >> s >> size;
    EXPECT_EQ(name, expected);
    EXPECT_EQ(gib, "GiB");
    EXPECT_GT(memory, 0.0);
    std::string rest;
    std::getline(table, rest);
    EXPECT_TRUE(table) << result.out;
  }
  EXPECT_TRUE(std::filesystem::exists(folder() / "files/adjoint/report.html"));
}

TEST_F(MeasureMemoryTest, WrongArgumentsAreNamed) {
  const ToolResult result = Run(std::string(kScript) + " --methods numeric,adjoint");
  EXPECT_NE(result.exit_code, 0);
  EXPECT_NE(result.err.find("--methods of adjoint, sensitivity"), std::string::npos) << result.err;
  EXPECT_TRUE(Files().empty());
}

}  // namespace
}  // namespace clothid
