// The program `plan`: its table and file, and what it refuses.
#include <filesystem>
#include <string>

#include "tests/tools/small_drape.h"
#include "tests/tools/tool_test.h"

namespace clothid::plan_test {
namespace {

class PlanTest : public ToolTest {
 protected:
  PlanTest() { WriteBytes(folder() / "drape.scene.json", SmallDrape(5)); }

  const std::string kPlan = "plan --scenes drape.scene.json --sigma 0.002 --frame_rate 50 --fit mu,k_bend ";
};

TEST_F(PlanTest, PrintsATableAndWritesPlanJson) {
  const ToolResult plan = Run(kPlan + "--draws 1 --output out");
  ASSERT_EQ(plan.exit_code, 0) << plan.err;
  EXPECT_EQ(plan.out.rfind("drape: 0.4 s, 21 frames of 25 points, start estimated, ", 0), 0u) << plan.out;
  EXPECT_NE(plan.out.find("a gauge at the gripper"), std::string::npos) << plan.out;
  EXPECT_TRUE(std::filesystem::exists(folder() / "out" / "plan.html"));
  const nlohmann::json json = nlohmann::json::parse(ReadBytes(folder() / "out" / "plan.json"));
  EXPECT_EQ(json["schema"], "clothid.plan/1");
  EXPECT_EQ(json["candidates"][0]["cloths"], 2);
  EXPECT_EQ(json["candidates"][0]["information"]["parameters"]["mu"]["nodes"].size(), 25u);
  EXPECT_EQ(json["candidates"][0]["information"]["parameters"]["mu"]["frames"].size(), 21u);
}

TEST_F(PlanTest, GoesOnWhereACandidateFails) {
  nlohmann::json scene = nlohmann::json::parse(SmallDrape(5));
  scene["solver"]["max_newton_iterations"] = 1;
  scene["solver"]["max_substep_halvings"] = 0;
  WriteBytes(folder() / "torn.json", scene.dump());
  const ToolResult plan = Run(kPlan + "--scenes torn.json --initial scene --draws 0");
  EXPECT_EQ(plan.exit_code, 0) << plan.err;
  EXPECT_NE(plan.out.find("\ntorn: failed: step "), std::string::npos) << plan.out;
  const ToolResult none = Run("plan --scenes torn.json --sigma 0.002 --fit mu --draws 0 --output out");
  EXPECT_EQ(none.exit_code, 3) << none.err;
  EXPECT_FALSE(std::filesystem::exists(folder() / "out"));
}

TEST_F(PlanTest, RefusesInOneLine) {
  ExpectRefused("plan", 1, "--scenes is missing; see plan --help");
  ExpectRefused(kPlan + "--fit stiffness", 1, "stiffness");
  ExpectRefused(kPlan + "--scenes missing.json", 1, "missing.json");
  ExpectRefused(kPlan + "--sigma -0.002", 1, "--sigma: expected a standard deviation > 0 in m");
  ExpectRefused(kPlan + "--initial first", 1, "--initial: expected scene, estimated, rest or moving");
  ExpectRefused(kPlan + "--prior mu=0.3", 1, "--prior");
  WriteBytes(folder() / "broken.json", "{");
  ExpectRefused(kPlan + "--scenes broken.json", 2, "broken.json");
}

}  // namespace
}  // namespace clothid::plan_test
