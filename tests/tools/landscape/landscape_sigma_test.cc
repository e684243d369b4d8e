// `landscape --sigma` and `--initial`: the costs of a scan are those of `identify` with the same.
#include <gtest/gtest.h>

#include <cmath>
#include <sstream>
#include <string>

#include "tests/tools/tool_test.h"

namespace clothid::landscape_sigma_test {
namespace {

class LandscapeSigmaTest : public ToolTest {
 protected:
  LandscapeSigmaTest() {
    nlohmann::ordered_json scene = SphereJson();
    scene["duration"] = 0.1;
    const std::string simulate = "simulate --set mu=0.2,k_stretch=120 --noise 0.002 --scene " + WriteScene(scene);
    EXPECT_EQ(Run(simulate + " --output known.bin").exit_code, 0);
    // The same points without their sigma.
    EXPECT_EQ(Run("motion convert known.bin points.csv").exit_code, 0);
    EXPECT_EQ(Run("motion convert points.csv unknown.bin --scene scene.json").exit_code, 0);
  }

  nlohmann::json Plan(const std::string& folder) const {
    return nlohmann::json::parse(ReadBytes(this->folder() / folder / "plan.json"));
  }

  // The cost of the first cell, mu = 0.4 and k_stretch = 60.
  double CostOfScan(const std::string& flags) const {
    const ToolResult result = Run("landscape --x mu=0.4:0.5:2 --y k_stretch=60:90:2 --output cost " + flags);
    EXPECT_EQ(result.exit_code, 0) << result.err;
    const std::string csv = ReadBytes(folder() / "cost" / "landscape.csv");
    const std::size_t row = csv.find("\n0.4,60,,gap,");
    EXPECT_NE(row, std::string::npos) << csv;
    return std::stod(csv.substr(row + 13));
  }
  // What a fit that starts there takes for the cost.
  double CostOfFit(const std::string& flags) const {
    const ToolResult result =
        Run("identify --fit mu,k_stretch --start mu=0.4,k_stretch=60 --precision full --max_iterations 1 "
            "--report=false --output fit " +
            flags);
    EXPECT_TRUE(result.exit_code == 0 || result.exit_code == 3 || result.exit_code == 4) << result.err;
    std::istringstream csv(ReadBytes(folder() / "fit" / "convergence.csv"));
    std::string names, values;
    std::getline(csv, names);
    std::getline(csv, values);
    std::istringstream name_list(names), value_list(values);
    for (std::string name, value; std::getline(name_list, name, ',') && std::getline(value_list, value, ',');) {
      if (name == "cost") return std::stod(value);
    }
    ADD_FAILURE() << "no cost in " << names;
    return std::nan("");
  }
};

TEST_F(LandscapeSigmaTest, CostsAreThoseOfIdentify) {
  double last = 0.0;
  for (const std::string target : {"known.bin", "unknown.bin", "unknown.bin --initial first"}) {
    for (const std::string sigma : {"", "--sigma recorded", "--sigma auto", "--sigma 0.003", "--sigma 0.03"}) {
      const std::string flags = "--target " + target + " " + sigma;
      const double expected = CostOfFit(flags), cost = CostOfScan(flags);
      EXPECT_NEAR(cost, expected, 1e-9 * expected) << flags;
      // Where a start is estimated, its base and what is believed of it go with sigma, too.
      if (sigma == "--sigma 0.03" && target != "unknown.bin") {
        EXPECT_NEAR(cost, last / 100.0, 1e-9 * cost) << flags;
      }
      last = cost;
    }
  }
}

TEST_F(LandscapeSigmaTest, PlanSaysWhatItWas) {
  const auto sigma_of = [&](const std::string& flags) {
    CostOfScan(flags);
    return Plan("cost")["sigma"];
  };
  EXPECT_EQ(sigma_of("--target known.bin")["source"], "recorded");
  EXPECT_EQ(sigma_of("--target known.bin --sigma auto")["source"], "recorded");
  EXPECT_EQ(sigma_of("--target unknown.bin")["source"], "estimated");  // with the start
  EXPECT_EQ(sigma_of("--target unknown.bin --initial first")["source"], "unknown");
  EXPECT_EQ(sigma_of("--target unknown.bin --sigma auto")["source"], "estimated");
  const nlohmann::json given = sigma_of("--target unknown.bin --sigma 0.003");
  EXPECT_EQ(given["source"], "given");
  EXPECT_EQ(given["sigma_m"], 0.003);
  EXPECT_GT(given["rmse_of_root_cost_m"], 0.0);
}

TEST_F(LandscapeSigmaTest, AnotherSigmaIsAnotherScan) {
  CostOfScan("--target known.bin --sigma 0.003");
  const std::string scan =
      "landscape --x mu=0.4:0.5:2 --y k_stretch=60:90:2 --target known.bin --output cost --resume ";
  EXPECT_EQ(Run(scan + "--sigma 0.003").exit_code, 0);
  ExpectRefused(scan + "--sigma 0.004", 1, "cost: holds the landscape of another scan");
  for (const std::string wrong : {"0", "-1", "much", "nan"}) {
    ExpectRefused("landscape --target known.bin --x mu=0:1:2 --y k_stretch=60:90:2 --output x --sigma " + wrong, 1,
                  "--sigma: expected recorded, auto or a number > 0 in m, got '" + wrong + "'");
  }
  ExpectRefused("landscape plot cost --sigma 0.003", 1, "--sigma: is a flag of landscape, not of plot");
}

// The report of a fit shows the rmse of a scan by the scan's own sigma, and says where that is not the fit's.
TEST_F(LandscapeSigmaTest, ReportKnowsIt) {
  const double cost = CostOfScan("--target known.bin --sigma 0.03");
  const auto landscape_of = [&](const std::string& flags) {
    const ToolResult fit = Run("identify --target known.bin --fit mu,k_stretch --landscape cost --output out " + flags);
    EXPECT_TRUE(fit.exit_code == 0 || fit.exit_code == 4) << fit.err;
    const std::string page = ReadBytes(folder() / "out" / "report.html");
    const std::size_t start = page.find("id=\"data\">") + 10;
    return nlohmann::json::parse(page.substr(start, page.find("</script>", start) - start))["landscapes"][0];
  };
  const nlohmann::json same = landscape_of("--sigma 0.03"), other = landscape_of("");
  EXPECT_EQ(same["notes"].dump().find("another sigma"), std::string::npos) << same["notes"];
  EXPECT_NE(other["notes"].dump().find("another sigma"), std::string::npos) << other["notes"];
  EXPECT_EQ(same["rmse_of_root_cost"], other["rmse_of_root_cost"]);
  // 11 frames of 16 points less the 4 handles, in which all coordinates were seen.
  EXPECT_NEAR(same["rmse_of_root_cost"].get<double>() * std::sqrt(cost), std::sqrt(2.0 * cost / (11 * 12)) * 0.03,
              1e-12);
}

// `landscape --result`: without it nothing of it is told; shards of it join; the report has no note where both agree.
TEST_F(LandscapeSigmaTest, FollowsAResult) {
  CostOfScan("--target known.bin");
  EXPECT_FALSE(Plan("cost").contains("fit"));
  const std::string fit = "identify --target known.bin --fit mu,k_stretch,drag --output ";
  const ToolResult fitted = Run(fit + "fit --start drag=0.1");
  ASSERT_TRUE(fitted.exit_code == 0 || fitted.exit_code == 3 || fitted.exit_code == 4) << fitted.err;
  const std::string path = (folder() / "fit" / "result.json").string();
  nlohmann::ordered_json result = nlohmann::ordered_json::parse(ReadBytes(path));
  const std::string whole = "--target known.bin --result fit/result.json";
  CostOfScan(whole);
  EXPECT_EQ(Plan("cost")["fit"]["held"], nlohmann::json({{"drag", result["parameters"]["drag"]["value"]}}));
  const auto notes = [&](const std::string& flags) {
    EXPECT_LE(Run(fit + "out --start drag=0.1 --landscape cost " + flags).exit_code, 4);
    const std::string page = ReadBytes(folder() / "out" / "report.html");
    const std::size_t start = page.find("id=\"data\">") + 10;
    return nlohmann::json::parse(page.substr(start, page.find("</script>", start) - start))["landscapes"][0];
  };
  EXPECT_EQ(notes("")["notes"].dump(), "[]");

  result["model_error"] = nlohmann::json::parse(
      R"([{"points": {"times": [0, 0.1], "deviation": [0, 0.1], "variance": [0, 0.01], "alike": 3.3}}])");
  WriteBytes(path, result.dump());
  const std::string scan = "landscape --x mu=0.4:0.5:2 --y k_stretch=60:90:2 " + whole + " --output ";
  CostOfScan(whole);
  for (const std::string shard : {"0", "1"})
    EXPECT_EQ(Run(scan + "part" + shard + " --shard " + shard + "/2").exit_code, 0);
  ExpectSuccess("landscape merge part1 part0 --output merged");
  for (const std::string name : {"plan.json", "landscape.csv", "summary.json"}) {
    EXPECT_EQ(ReadBytes(folder() / "merged" / name), ReadBytes(folder() / "cost" / name)) << name;
  }
  EXPECT_TRUE(Plan("cost")["sigma"]["rmse_of_root_cost_m"].is_null());
  const nlohmann::json other = notes("");
  EXPECT_NE(other["notes"].dump().find("does not weigh frames as the fit"), std::string::npos) << other["notes"];
  EXPECT_TRUE(other["estimate_rmse_m"].is_null());

  ExpectRefused(scan + "x --set mu=0.2,k_stretch=90", 1, "--set: expected without --result");
  ExpectRefused(scan + "x --sweep materials.drag=0.2", 1, "which --result holds");
  ExpectRefused(scan + "x --target unknown.bin", 1, "is a fit of other recordings");
  const auto refuse = [&](const char* key, const nlohmann::ordered_json& value, const char* culprit) {
    nlohmann::ordered_json wrong = result;
    wrong[key] = value;
    WriteBytes(path, wrong.dump());
    ExpectRefused(scan + "x", 2, culprit);
  };
  refuse("status", "interrupted", "key 'status'");
  refuse("model_error", nlohmann::json::array(), "key 'model_error'");
  refuse("fields", nlohmann::json::object(), "key 'fields'");
  WriteBytes(path, "{\"schema\"");
  ExpectRefused(scan + "x", 2, "result.json:1");
}

}  // namespace
}  // namespace clothid::landscape_sigma_test
