// `motion view` and `simulate --view` as programs: a page, or one line that says why not.
#include <gtest/gtest.h>

#include <string>

#include "tests/tools/tool_test.h"

namespace clothid::motion_view_test {
namespace {

class MotionViewTest : public ToolTest {
 protected:
  MotionViewTest() { ExpectSuccess("simulate --scene " + WriteScene(SphereJson()) + " --output good.bin"); }

  bool IsPage(const std::string& name) const {
    return std::filesystem::exists(folder() / name) && ReadBytes(folder() / name).rfind("<!DOCTYPE html>", 0) == 0;
  }
};

TEST_F(MotionViewTest, WritesAPage) {
  const ToolResult result = Run("motion view good.bin");
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(result.out, "view.html: 6 frames; open it in a browser\n");
  EXPECT_TRUE(IsPage("view.html"));
  ExpectSuccess("motion view good.bin --output page.html");
  EXPECT_EQ(ReadBytes(folder() / "page.html"), ReadBytes(folder() / "view.html"));
}

TEST_F(MotionViewTest, SimulatesAScene) {
  ExpectSuccess("motion view scene.json");
  EXPECT_TRUE(IsPage("view.html"));
  EXPECT_NE(ReadBytes(folder() / "view.html").find("\"forces\""), std::string::npos);
}

TEST_F(MotionViewTest, SimulateWritesItBeside) {
  ExpectSuccess("simulate --scene scene.json --output other.bin --noise 0.001 --view page.html");
  EXPECT_TRUE(IsPage("page.html"));
  // But for the digest of the file, the page of the recording.
  ExpectSuccess("motion view other.bin");
  std::string page = ReadBytes(folder() / "view.html");
  const std::size_t digest = page.find("\"sha256\":\"") + 10;
  EXPECT_EQ(page.erase(digest, page.find('"', digest) - digest), ReadBytes(folder() / "page.html"));
  ExpectRefused("simulate --scene scene.json --output a.bin --view a.bin", 1, "--view: a.bin: expected another file");
  ExpectRefused("simulate --scene scene.json --output a.bin --view scene.json", 1, "would replace an input");
  ExpectRefused("simulate --scene scene.json --output a.bin --view a.txt", 1, "--view: expected a name that ends in");
  ExpectRefused("simulate --scene scene.json --output a.csv --sensor scene.json --view a.html", 1, "without --sensor");
}

TEST_F(MotionViewTest, RefusesWhatItCannotShow) {
  WriteBytes(folder() / "points.csv", "1,2,3\n4,5,6\n7,8,9\n");
  WriteBytes(folder() / "bad.json", "{\"clothid_scene\": 1}");
  WriteBytes(folder() / "linked.html", ReadBytes(folder() / "good.bin"));
  ExpectRefused("motion view", 1, "view: expected one file");
  ExpectRefused("motion view missing.bin", 1, "missing.bin: cannot be read");
  ExpectRefused("motion view missing.json", 1, "missing.json: cannot be read");
  ExpectRefused("motion view points.csv", 2, "points.csv: is text");
  ExpectRefused("motion view bad.json", 2, "bad.json");
  ExpectRefused("motion view good.bin --output good.bin", 1, "would replace an input");
  ExpectRefused("motion view linked.html --output linked.html", 1, "would replace an input");
  ExpectRefused("motion view good.bin --output page.bin", 1, "--output: expected a name that ends in .html");
  ExpectRefused("motion view good.bin --output none/page.html", 1, "none/page.html");
  ExpectRefused("motion view good.bin --json", 1, "--json: is a flag of check");
  ExpectRefused("motion check good.bin --output page.html", 1, "--output: is a flag of view");
}

TEST_F(MotionViewTest, TellsWhereASceneDoesNotConverge) {
  nlohmann::ordered_json scene = SphereJson();
  scene["solver"] = {{"max_newton_iterations", 1}, {"max_substep_halvings", 0}, {"step_tolerance", 1e-14}};
  ExpectRefused("motion view " + WriteScene(scene, "stiff.json"), 3, "step ");
}

}  // namespace
}  // namespace clothid::motion_view_test
