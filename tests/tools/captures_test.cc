// A real capture, where it is there: it runs to an end and says something about the repetition that was not fitted.
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

#include "tests/tools/tool_test.h"

namespace clothid {
namespace {

class CapturesTest : public ToolTest {};

TEST_F(CapturesTest, AFitLowersTheErrorOnTheOtherRepetition) {
  const char* variable = std::getenv("CLOTHID_RECORDINGS");
  const std::string captures = variable != nullptr ? variable : CLOTHID_SOURCE_DIR "/../shared/recordings";
  if (!std::filesystem::exists(captures + "/hung_a.motion.bin")) {
    GTEST_SKIP() << captures << "/hung_a.motion.bin is not there; set CLOTHID_RECORDINGS to its folder";
  }
  const ToolResult fit = Run("identify --target '" + captures + "/hung_a.motion.bin' --holdout '" + captures +
                             "/hung_b.motion.bin' --fit k_stretch,k_bend,drag --jacobian sensitivity --output result");
  EXPECT_TRUE(fit.exit_code == 0 || fit.exit_code == 4) << fit.exit_code << "\n" << fit.err;  // 4: at a bound
  EXPECT_NE(fit.out.find("rmse"), std::string::npos) << fit.out;
  const nlohmann::json result = nlohmann::json::parse(ReadBytes(folder() / "result" / "result.json"));
  EXPECT_LT(result["rmse_m"].get<double>(), 0.06);
  EXPECT_LT(result["holdout"]["rmse_m"].get<double>(), result["holdout"]["nominal_rmse_m"].get<double>());
}

}  // namespace
}  // namespace clothid
