// plan.html: what it holds of plan.json, the motions, small, names shown and never run.
#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <regex>
#include <string>

#include "identify/experiment/experiment_plan.h"
#include "identify/report/report_page.h"
#include "tests/identify/report/packed_page.h"
#include "tests/temporary_folder.h"

namespace clothid::plan_page_test {
namespace {

using Json = nlohmann::ordered_json;

// Swings by two corners; falls freely, which tells nothing of its stiffness.
constexpr char kSwing[] = R"({"clothid_scene": 2, "time_step": 0.01, "duration": 0.3,
  "mesh": {"grid": {"nodes": [5, 5], "size": [0.5, 0.5]}}, "initial": {"positions": "rest"}, "handles": [0, 4],
  "materials": {"density": 0.15, "k_stretch": 300}})";
constexpr char kFall[] = R"({"clothid_scene": 2, "time_step": 0.01, "duration": 0.2,
  "mesh": {"grid": {"nodes": [3, 3], "size": [0.2, 0.2]}}, "initial": {"positions": "rest"},
  "materials": {"density": 0.15, "k_stretch": 300}})";

class PlanPageTest : public testing::Test {
 protected:
  PlanPageTest() {
    options_.scene_paths = {folder_.Write("swing.scene.json", kSwing), folder_.Write("fall.scene.json", kFall)};
    options_.fit.parameters = {"k_stretch"};
    options_.sigma = 0.002;
    options_.num_markers = 6;
    options_.start = StartSource::kScene;
    options_.num_draws = 0;
    plan_ = PlanExperiment(options_);
  }

  Json Page() const { return PageData(PlanHtml(options_, plan_)); }

  TemporaryFolder folder_;
  PlanOptions options_;
  Plan plan_;
};

TEST_F(PlanPageTest, HoldsWhatThePlanSays) {
  const Json page = Page(), json = Json::parse(PlanJson(options_, plan_));
  for (const char* key : {"recorded", "parameters", "pairs", "provenance"}) EXPECT_EQ(page[key], json[key]) << key;
  EXPECT_EQ(page["best"]["k_stretch"], Json({{"candidate", 0}, {"pair", 0}}));
  EXPECT_EQ(page["num_pairs"], 1);
  for (std::size_t c = 0; c < 2; ++c) {
    const Json &shown = page["candidates"][c], &planned = json["candidates"][c];
    for (const char* key : {"name", "failure", "parameters", "frames", "points", "worst_told"}) {
      EXPECT_EQ(shown[key], planned[key]) << key;
    }
    EXPECT_EQ(shown["improvements"][0], planned["improvements"][0]);
  }
  EXPECT_EQ(page["candidates"][1]["parameters"]["k_stretch"]["told"], false);
}

TEST_F(PlanPageTest, TellsWhatNarrowsAPrediction) {
  EXPECT_FALSE(Page().contains("prediction")) << "nobody asked";
  options_.predicted_path = folder_.Write("other.scene.json", kSwing);
  plan_ = PlanExperiment(options_);
  const Json page = Page(), &prediction = page["prediction"];
  EXPECT_EQ(prediction["name"], "other");
  EXPECT_EQ(prediction["candidate"], 0) << "the fall tells nothing";
  EXPECT_EQ(page["pairs"][prediction["pair"].get<std::size_t>()]["candidates"], Json({"swing", "fall"}));
  EXPECT_LT(page["candidates"][0]["prediction_width_m"].get<double>(),
            0.1 * page["candidates"][1]["prediction_width_m"].get<double>());
  EXPECT_NEAR(page["candidates"][1]["prediction_width_m"].get<double>(), prediction["believed_width_m"].get<double>(),
              0.01 * prediction["believed_width_m"].get<double>());
  EXPECT_NE(PlanTable(plan_).find("prediction of other"), std::string::npos);
}

TEST_F(PlanPageTest, InformationIsThatOfTheMap) {
  const InformationMap& map = plan_.candidates[0].map;
  const Json column = Page()["candidates"][0]["information"]["parameters"]["k_stretch"];
  const double largest = column["largest"];
  EXPECT_EQ(largest, map.per_node.maxCoeff());
  EXPECT_DOUBLE_EQ(column["total"], map.per_frame.sum() + map.of_forces.sum());
  const std::vector<unsigned char> nodes = Unpack(column["nodes"]);
  ASSERT_EQ(nodes.size(), 25u);
  int num_seen = 0;
  for (std::size_t n = 0; n < nodes.size(); ++n) {
    if (nodes[n] == 255) continue;
    ++num_seen;
    const double told = map.per_node(static_cast<Eigen::Index>(n), 0);
    if (told <= 1e-5 * largest) continue;
    EXPECT_NEAR(largest * std::pow(10.0, 6.0 * (nodes[n] / 254.0 - 1.0)), told, 0.06 * told);
  }
  EXPECT_EQ(num_seen, 6) << "all others are no markers";
  ASSERT_EQ(column["frames"].size(), 31u);
  EXPECT_NEAR(column["frames"][20].get<double>(), map.per_frame(20, 0), 1e-3 * map.per_frame(20, 0));
}

TEST_F(PlanPageTest, MotionsAreThoseOfTheNominalCloth) {
  const NominalMotion& motion = plan_.candidates[0].motion;
  const Json replay = Page()["candidates"][0]["replay"];
  EXPECT_EQ(replay["points"], 25);
  EXPECT_EQ(replay["handles"], Json({0, 4}));
  ASSERT_EQ(replay["times"].size(), 31u);
  const std::vector<int> last = UnpackPositions(replay["recorded"], 75).back();
  for (std::size_t i = 0; i < last.size(); ++i) {
    const double step = replay["step"], position = replay["origin"][i % 3].get<double>() + step * last[i];
    EXPECT_NEAR(position, motion.positions(static_cast<Eigen::Index>(i), 30), step);
  }
  EXPECT_LT(motion.positions(3 * 22 + 2, 30), -0.1) << "it swings down";
}

TEST_F(PlanPageTest, FailedCandidatesSayWhy) {
  plan_.candidates[1] = CandidatePlan();
  plan_.candidates[1].name = "fall";
  plan_.candidates[1].failure = "step 3: no";
  plan_.pairs.clear();
  const Json page = Page();
  EXPECT_EQ(page["candidates"][1]["failure"], "step 3: no");
  EXPECT_FALSE(page["candidates"][1].contains("replay"));
  EXPECT_EQ(page["best"]["k_stretch"]["pair"], -1);
}

// Every k-th frame of many long motions that do not compress.
TEST_F(PlanPageTest, IsSmallWhateverTheMotions) {
  CandidatePlan& first = plan_.candidates[0];
  std::mt19937_64 generator(3);
  std::uniform_real_distribution<float> uniform(0.0f, 1.0f);
  constexpr int kFrames = 12000;
  first.motion.times = first.map.times = Eigen::VectorXd::LinSpaced(kFrames, 0.0, 10.0);
  first.map.per_frame = Eigen::MatrixXd::Ones(kFrames, 1);
  first.motion.positions.resize(75, kFrames);
  for (float& coordinate : first.motion.positions.reshaped()) coordinate = uniform(generator);
  first.improvements.clear();
  plan_.pairs.clear();
  plan_.candidates.assign(9, CandidatePlan(first));
  options_.scene_paths.resize(9);
  const std::string html = PlanHtml(options_, plan_);
  EXPECT_LT(html.size(), kMaxReportBytes);
  EXPECT_GT(html.size(), kMaxReportBytes / 2);
  const Json page = PageData(html);
  for (const Json& candidate : page["candidates"]) EXPECT_GT(candidate["replay"].value("every", 0), 1);
  EXPECT_EQ(page["candidates"][8]["information"]["parameters"]["k_stretch"]["frames"].size(), 400u);
}

TEST_F(PlanPageTest, IsOneFileWhoseNamesAreNotRun) {
  const std::string hostile = "</script><img src=x onerror=\"alert(1)\">";
  plan_.candidates[0].name = hostile;
  plan_.candidates[0].failed_cloths = {hostile};
  options_.command_line = hostile;
  const std::string html = PlanHtml(options_, plan_);
  EXPECT_EQ(PageData(html)["candidates"][0]["name"], hostile);
  EXPECT_EQ(html.find("<img"), std::string::npos);
  EXPECT_EQ(html.find("http:"), std::string::npos);
  EXPECT_EQ(html.find("https:"), std::string::npos);
  EXPECT_EQ(html.find("{{"), std::string::npos);
  EXPECT_FALSE(std::regex_search(html, std::regex("<(script|link|iframe)[^>]*(src|href)", std::regex::icase)));
  EXPECT_EQ(PlanHtml(options_, plan_), html) << "the same bytes on every run";
}

}  // namespace
}  // namespace clothid::plan_page_test
