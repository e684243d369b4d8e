// An error of a program itself, here a lack of memory, is neither wrong usage nor a fit that did not converge.
#include <gtest/gtest.h>

#include <new>
#include <stdexcept>
#include <string>

#include "sim/base/error.h"
#include "sim/base/program.h"
#include "tests/tools/tool_test.h"

namespace clothid::internal_error_test {
namespace {

class InternalErrorTest : public ToolTest {
 protected:
  void SetUp() override {
#ifdef __SANITIZE_ADDRESS__
    GTEST_SKIP() << "the sanitizer takes more memory than any limit for a program leaves";
#endif
  }
};

TEST(ReportErrorsTest, TellsInternalErrorsFromOthers) {
  EXPECT_EQ(ReportErrors("tool", [] { return 4; }), 4);
  testing::internal::CaptureStderr();
  EXPECT_EQ(ReportErrors("tool", []() -> int { throw Error(ErrorKind::kBadData, "a.bin: expected b"); }), kExitBadData);
  EXPECT_EQ(ReportErrors("tool", []() -> int { throw Error(ErrorKind::kUsage, "--c: expected d"); }), kExitUsageOrIo);
  EXPECT_EQ(ReportErrors("tool", []() -> int { throw std::logic_error("e"); }), kExitInternal);
  EXPECT_EQ(ReportErrors("tool", []() -> int { throw std::bad_alloc(); }), kExitInternal);
  EXPECT_EQ(testing::internal::GetCapturedStderr(),
            "tool: a.bin: expected b\ntool: --c: expected d\ntool: internal error: e\ntool: memory ran out\n");
}

// OpenBLAS makes a thread as the program starts, which then waits for memory, and waits for that thread at the end.
TEST_F(InternalErrorTest, NoMemoryLeftForAThreadOfALibrary) {
  const auto limited = [](const std::string& command) {
    return "env OPENBLAS_NUM_THREADS=2 timeout --signal=KILL 60 bash -c 'ulimit -v 120000; exec " + command + "'";
  };
  for (const std::string program : {"simulate", "identify"}) {
    const ToolResult help = Run(limited(program + " --help"));
    EXPECT_EQ(help.exit_code, 0) << program << help.err;
    EXPECT_EQ(help.out, Run(program + " --help").out);
    ExpectRefused(limited(program + " extra"), kExitUsageOrIo, "unexpected argument");
  }
  const ToolResult made = Run(limited("simulate --scene " + WriteScene(BareScene()) + " --output good.bin"));
  EXPECT_EQ(made.exit_code, 0) << made.err;
  EXPECT_NE(made.out.find("good.bin: 6 frames"), std::string::npos) << made.out;
}

TEST_F(InternalErrorTest, NoMemoryLeftForAFit) {
  ExpectSuccess("simulate --scene " + WriteScene(BareScene()) + " --output good.bin");
  ExpectRefused("bash -c 'ulimit -v 2000000; exec identify --target good.bin --starts 1000000000 --output result'",
                kExitInternal, "identify: memory ran out");
}

TEST_F(InternalErrorTest, NoMemoryLeftForASimulation) {
  nlohmann::ordered_json scene = BareScene();
  scene["mesh"]["grid"]["nodes"] = {1000, 1000};
  ExpectRefused("bash -c 'ulimit -v 200000; exec simulate --scene " + WriteScene(scene) + " --output large.bin'",
                kExitInternal, "simulate: memory ran out");
}

}  // namespace
}  // namespace clothid::internal_error_test
