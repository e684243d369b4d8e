// What a recording does not determine ends in exit code 4, by name, with every output written.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <string>

#include "tests/tools/tool_test.h"

namespace clothid::identifiability_test {
namespace {

class IdentifiabilityTest : public ToolTest {
 protected:
  // result.json of a fit that must end in exit code 4 with all its files.
  nlohmann::json ExpectNotIdentifiable(const std::string& recording, const std::string& flags) const {
    const ToolResult result = Run("identify --target '" CLOTHID_SOURCE_DIR "/datasets/" + recording +
                                  "' --jacobian sensitivity --output result " + flags);
    EXPECT_EQ(result.exit_code, 4) << result.err;
    for (const char* file : {"result.json", "convergence.csv", "predicted.bin", "report.html"}) {
      EXPECT_TRUE(std::filesystem::exists(folder() / "result" / file)) << file;
    }
    return nlohmann::json::parse(ReadBytes(folder() / "result" / "result.json"));
  }

  static void ExpectHidden(const nlohmann::json& result, const std::string& parameter) {
    const nlohmann::json& entry = result["parameters"][parameter];
    EXPECT_EQ(entry["identifiable"], false) << parameter;
    EXPECT_TRUE(entry["std"].is_null() && entry["lower95"].is_null() && entry["upper95"].is_null()) << entry;
  }

  static void ExpectRecovered(const nlohmann::json& result, const std::string& parameter, double truth) {
    const nlohmann::json& entry = result["parameters"][parameter];
    EXPECT_EQ(entry["identifiable"], true) << parameter;
    EXPECT_NEAR(entry["value"].get<double>(), truth, 1e-4 * truth) << parameter;
    EXPECT_LE(entry["lower95"].get<double>(), truth) << parameter;
    EXPECT_GE(entry["upper95"].get<double>(), truth) << parameter;
  }
};

TEST_F(IdentifiabilityTest, FrictionWithoutContact) {
  const nlohmann::json result = ExpectNotIdentifiable("wind.motion.bin", "--fit mu,k_stretch,k_bend");
  ExpectHidden(result, "mu");
  ExpectRecovered(result, "k_stretch", 60.0);
  ExpectRecovered(result, "k_bend", 4e-4);
  EXPECT_EQ(result["uncertainty"]["hidden_directions"][0]["words"], "mu");
}

TEST_F(IdentifiabilityTest, StiffnessOfAClothThatOnlySlides) {
  const nlohmann::json result = ExpectNotIdentifiable("slope.motion.bin", "--fit mu,k_stretch");
  ExpectHidden(result, "k_stretch");
  ExpectRecovered(result, "mu", 0.2);
  EXPECT_EQ(result["uncertainty"]["hidden_directions"][0]["words"], "k_stretch");
}

TEST_F(IdentifiabilityTest, TheCommonFactorOfAllThatScales) {
  const nlohmann::json result = ExpectNotIdentifiable("wind.motion.bin", "--fit k_stretch,k_bend,density,drag");
  for (const char* parameter : {"k_stretch", "k_bend", "density", "drag"}) ExpectHidden(result, parameter);
  EXPECT_EQ(result["uncertainty"]["hidden_directions"][0]["words"],
            "k_stretch, k_bend, density and drag multiplied by one factor");
  // What it does determine are ratios.
  const auto value = [&](const char* name) { return result["parameters"][name]["value"].get<double>(); };
  EXPECT_NEAR(value("k_stretch") / value("density"), 60.0 / 0.15, 1e-3 * 400.0);
  EXPECT_LT(result["rmse_m"].get<double>(), 1e-6);
}

}  // namespace
}  // namespace clothid::identifiability_test
