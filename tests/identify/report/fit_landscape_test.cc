// `identify --landscape`: what `landscape` wrote of the same recording goes into report.html, all else is refused.
#include <gtest/gtest.h>

#include <string>
#include <utility>

#include "tests/tools/tool_test.h"

namespace clothid::fit_landscape_test {
namespace {

class FitLandscapeTest : public ToolTest {
 protected:
  FitLandscapeTest() {
    const std::string scene = WriteScene(SphereJson());
    for (const auto& [name, mu] : {std::pair("a.bin", "0.2"), std::pair("b.bin", "0.25")}) {
      const ToolResult result =
          Run("simulate --scene " + scene + " --set k_stretch=120,mu=" + mu + " --output " + name);
      EXPECT_EQ(result.exit_code, 0) << result.err;
    }
    Scan("cost", "");
  }

  void Scan(const std::string& output, const std::string& flags) const {
    const ToolResult result =
        Run("landscape --target a.bin --x mu=0:0.6:3 --y k_stretch=30:400:3:log --output " + output + " " + flags);
    EXPECT_EQ(result.exit_code, 0) << result.err;
  }
};

TEST_F(FitLandscapeTest, IsInTheReport) {
  const ToolResult fit = Run("identify --target a.bin --fit mu,k_stretch --output out --landscape cost");
  ASSERT_TRUE(fit.exit_code == 0 || fit.exit_code == 4) << fit.err;
  const std::string page = ReadBytes(folder() / "out" / "report.html");
  EXPECT_NE(page.find("\"landscapes\":["), std::string::npos);
  EXPECT_NE(page.find("showLandscape"), std::string::npos);

  // The fit does not know of it.
  const auto result = [&](const std::string& flags) {
    Run("identify --target a.bin --fit mu,k_stretch --output out " + flags);
    nlohmann::json json = nlohmann::json::parse(ReadBytes(folder() / "out" / "result.json"));
    json.erase("seconds");
    json["provenance"].erase("flags");
    return json;
  };
  const nlohmann::json with = result("--landscape cost"), without = result("");
  EXPECT_EQ(with, without);
  EXPECT_EQ(ReadBytes(folder() / "out" / "report.html").find("showLandscape"), std::string::npos);
}

// Several, of one of several recordings.
TEST_F(FitLandscapeTest, TakesSeveral) {
  Scan("both", "--contact both --gradients");
  const ToolResult fit =
      Run("identify --target b.bin,a.bin --fit mu --each k_stretch --output out --landscape cost,both");
  ASSERT_TRUE(fit.exit_code == 0 || fit.exit_code == 4) << fit.err;
  const std::string page = ReadBytes(folder() / "out" / "report.html");
  const std::size_t start = page.find("id=\"data\">") + 10;
  const nlohmann::json data = nlohmann::json::parse(page.substr(start, page.find("</script>", start) - start));
  ASSERT_EQ(data["landscapes"].size(), 2u);
  for (const nlohmann::json& landscape : data["landscapes"]) {
    EXPECT_EQ(landscape["recording"], 1);
    EXPECT_EQ(landscape["y"]["parameter"], "k_stretch@2");
    EXPECT_EQ(landscape["windows"], data["landscapes"][0]["windows"]) << "the contact mode of the fit";
  }
  EXPECT_NE(data["landscapes"][1]["notes"].dump().find("are left out"), std::string::npos);
}

TEST_F(FitLandscapeTest, RefusesWhatDoesNotBelongToTheFit) {
  const std::string fit = "identify --target a.bin --fit mu,k_stretch --landscape ";
  ExpectRefused(fit + "nowhere", 1, "--landscape: nowhere: holds no landscape");
  ExpectRefused(fit + ".", 1, "--landscape: .: holds no landscape");
  ExpectRefused(fit + "a.bin", 1, "--landscape: a.bin: holds no landscape");
  ExpectRefused(fit + "cost,cost", 1, "--landscape");
  ExpectRefused(fit + "cost --report=false", 1, "--landscape: is shown in report.html");
  ExpectRefused("identify --target b.bin --fit mu,k_stretch --landscape cost", 1, "another recording");
  ExpectRefused("identify --target a.bin --fit k_stretch --landscape cost", 1, "axis 'mu' is no parameter of this fit");
  Scan("truth", "--set mu=0.2,k_stretch=120");
  ExpectRefused(fit + "truth", 1, "--set");
  Scan("sweep", "--sweep ball.center.x=0.1,0.15");
  ExpectRefused(fit + "sweep", 1, "scene as it is and contact mode gap");
  Scan("shard", "--shard 0/2");
  ExpectRefused(fit + "shard", 2, "shard: is shard 0 of 2");
  WriteBytes(folder() / "cost" / ".landscape_cells", "");
  ExpectRefused(fit + "cost", 2, "cost: the scan was stopped");
  std::filesystem::remove(folder() / "cost" / ".landscape_cells");
  WriteBytes(folder() / "cost" / "plan.json", "{}");
  ExpectRefused(fit + "cost", 2, "plan.json");
}

}  // namespace
}  // namespace clothid::fit_landscape_test
