// Landscapes in report.html: what the page holds of one, the region of both parameters, and what a cost says of the
// rmse.
#include "identify/report/report_landscape.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "identify/report/report_page.h"
#include "identify/report/vendor/plotly.h"
#include "tests/costs/synthetic_motion.h"
#include "tests/expect_error.h"
#include "tests/identify/report/packed_page.h"

namespace clothid::report_landscape_test {
namespace {

using Json = nlohmann::ordered_json;

constexpr char kHostileReason[] = "</script><img src=x onerror=\"alert(1)\">";
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

RecordedMotion Motion() {
  MotionOptions options;
  options.true_values = {{"k_stretch", 150.0}};
  options.noise = 1e-3;
  return MakeMotion(SphereScene(), options);
}

FitSummary RunFit(const RecordedMotion& motion, FitLandscape* landscape) {
  FitOptions options;
  options.parameters = {"mu", "k_stretch", "drag"};
  FitProblem problem({motion}, options);
  FitSummary summary = Fit(options, &problem);
  MatchLandscape(problem.blocks(), landscape);
  return summary;
}

// nx x ny cells of made-up costs in two windows, the cell (1, 0) of the second failed.
FitLandscape MakeLandscape(int nx = 4, int ny = 3) {
  FitLandscape landscape;
  landscape.folder = "cost";
  LandscapePlan& plan = landscape.landscape.plan;
  plan.settings = {{"", ContactMode::kGap}};
  plan.windows = {
      {1.0, {"mu", ParameterScale::kLinear, 0.0, 0.6, nx}, {"k_stretch", ParameterScale::kLog, 10.0, 1e3, ny}},
      {0.1, {"mu", ParameterScale::kLinear, 0.2, 0.26, nx}, {"k_stretch", ParameterScale::kLog, 80.0, 120.0, ny}}};
  for (int cell = 0; cell < plan.num_cells(); ++cell) {
    landscape.landscape.cells.emplace_back();
    landscape.landscape.cells.back().cost = 100.0 + cell;
  }
  LandscapeCell& failed = landscape.landscape.cells[plan.FirstCell(0, 1) + 1];
  failed.cost = kNaN;
  failed.failure = kHostileReason;
  landscape.rmse_of_root_cost = 1e-3;
  return landscape;
}

// The page without the library, whose own texts mention addresses.
std::string OwnText(std::string html) {
  for (const std::string_view foreign : {PlotlyLibrary(), PlotlyLicences()})
    html.erase(html.find(foreign), foreign.size());
  return html;
}

TEST(ReportLandscapeTest, PageHoldsTheCells) {
  const RecordedMotion motion = Motion();
  FitChecks checks;
  checks.landscapes = {MakeLandscape()};
  const FitSummary summary = RunFit(motion, &checks.landscapes[0]);
  const std::string html = ReportHtml(summary, checks, {motion});
  const Json data = PageData(html);
  ASSERT_EQ(data["landscapes"].size(), 1u);
  const Json& shown = data["landscapes"][0];
  EXPECT_EQ(shown["x"], Json({{"parameter", "mu"}, {"scale", "linear"}}));
  EXPECT_EQ(shown["y"], Json({{"parameter", "k_stretch"}, {"scale", "log"}}));
  ASSERT_EQ(shown["windows"].size(), 2u);
  const Json &whole = shown["windows"][0], &zoom = shown["windows"][1];
  EXPECT_EQ(whole["x"], Json({0.0, 0.2, 0.4, 0.6}));
  EXPECT_EQ(whole["y"], Json({10.0, 100.0, 1000.0}));
  EXPECT_EQ(whole["cost"], Json({100.0, 101.0, 102.0, 103.0, 104.0, 105.0, 106.0, 107.0, 108.0, 109.0, 110.0, 111.0}));
  EXPECT_TRUE(whole["failures"]["cells"].empty());
  // A failed rollout is no number.
  EXPECT_TRUE(zoom["cost"][1].is_null());
  EXPECT_EQ(zoom["cost"][2], 114.0);
  EXPECT_EQ(zoom["failures"]["cells"], Json::parse("[[1, 0]]"));
  EXPECT_EQ(zoom["failures"]["reasons"][0], kHostileReason);
  EXPECT_EQ(shown["rmse_of_root_cost"], 1e-3);
  EXPECT_NEAR(shown["estimate_rmse_m"].get<double>(), summary.error.rmse(), 1e-8 * summary.error.rmse());
  ASSERT_EQ(shown["notes"].size(), 1u);
  EXPECT_NE(shown["notes"][0].get<std::string>().find("drag has its nominal value"), std::string::npos);

  const std::string own = OwnText(html);
  EXPECT_EQ(own.find("<img"), std::string::npos);
  EXPECT_EQ(own.find("http"), own.find("http-equiv"));
  EXPECT_EQ(own.find("http", own.find("http-equiv") + 1), std::string::npos);
  EXPECT_LT(html.size(), kMaxReportBytes);
}

TEST(ReportLandscapeTest, PageWithoutOneHasNothingOfIt) {
  const RecordedMotion motion = Motion();
  FitLandscape landscape = MakeLandscape();
  const FitSummary summary = RunFit(motion, &landscape);
  const std::string own = OwnText(ReportHtml(summary, FitChecks(), {motion}));
  EXPECT_EQ(own.find("andscape"), std::string::npos);
  FitChecks checks;
  checks.landscapes = {landscape};
  EXPECT_NE(OwnText(ReportHtml(summary, checks, {motion})).find("andscape"), std::string::npos);
}

TEST(ReportLandscapeTest, LargeOnesAreThinned) {
  const RecordedMotion motion = Motion();
  FitLandscape landscape = MakeLandscape(400, 301);
  const FitSummary summary = RunFit(motion, &landscape);
  const Json shown = LandscapeJson(landscape, summary, FitChecks(), {motion}, 100000);
  EXPECT_LT(shown.dump().size(), 100000u);
  const Json& window = shown["windows"][0];
  const int every = window["every"];
  EXPECT_GT(every, 1);
  EXPECT_EQ(window["cost"].size(), window["x"].size() * window["y"].size());
  EXPECT_EQ(window["cost"][window["x"].size() + 1], 100.0 + every * 400 + every);
  EXPECT_NEAR(window["x"][1], landscape.landscape.plan.windows[0].x.Value(every), 1e-9);
  // However little there is to spend.
  EXPECT_LT(LandscapeJson(landscape, summary, FitChecks(), {motion}, 0).dump().size(), 10000u);
}

// Reasons of failures take no more room than is worth it.
TEST(ReportLandscapeTest, ManyReasonsAreOne) {
  const RecordedMotion motion = Motion();
  FitLandscape landscape = MakeLandscape(30, 30);
  const FitSummary summary = RunFit(motion, &landscape);
  for (std::size_t i = 0; i < landscape.landscape.cells.size(); ++i) {
    landscape.landscape.cells[i].cost = kNaN;
    landscape.landscape.cells[i].failure = std::to_string(i) + std::string(1000, 'x');
  }
  const Json shown = LandscapeJson(landscape, summary, FitChecks(), {motion}, 100000);
  EXPECT_LT(shown.dump().size(), 100000u);
  EXPECT_EQ(shown["windows"][0]["failures"]["cells"].size(), 900u);
  EXPECT_LE(shown["windows"][0]["failures"]["reasons"].size(), 20u);
}

TEST(ReportLandscapeTest, RegionIsTheJointOne) {
  const RecordedMotion motion = Motion();
  FitLandscape landscape = MakeLandscape();
  FitSummary summary = RunFit(motion, &landscape);
  ASSERT_TRUE(summary.uncertainty);
  Uncertainty& uncertainty = *summary.uncertainty;
  uncertainty.parameters[0].coordinate_std = 0.01;
  uncertainty.parameters[1].coordinate_std = 0.05;
  uncertainty.correlation(0, 1) = uncertainty.correlation(1, 0) = -0.8;
  uncertainty.quantile95 = kNormal95;
  summary.coordinates.head(2) << 0.3, std::log(150.0);
  Eigen::Matrix2d covariance;
  covariance << 1e-4, -0.8 * 5e-4, -0.8 * 5e-4, 2.5e-3;
  const Eigen::Matrix2Xd region = ConfidenceRegion(landscape, summary);
  ASSERT_GT(region.cols(), 30);
  EXPECT_EQ(region.col(0), region.col(region.cols() - 1)) << "closed";
  for (Eigen::Index i = 0; i < region.cols(); ++i) {
    const Eigen::Vector2d q(region(0, i) - 0.3, std::log(region(1, i) / 150.0));
    EXPECT_NEAR(q.dot(covariance.inverse() * q), -2.0 * std::log(0.05), 1e-9);
  }
  // Cut at the bounds, as intervals are.
  summary.coordinates[0] = 0.01;
  EXPECT_EQ(ConfidenceRegion(landscape, summary).row(0).minCoeff(), 0.0);
  uncertainty.parameters[1].coordinate_std = kNaN;
  EXPECT_EQ(ConfidenceRegion(landscape, summary).cols(), 0);
}

TEST(ReportLandscapeTest, AxesAreParametersOfTheFit) {
  const RecordedMotion motion = Motion();
  const auto match = [&](std::vector<std::string> shared, std::vector<std::string> each, int recording) {
    FitOptions options;
    options.parameters = std::move(shared);
    options.each = std::move(each);
    FitLandscape landscape = MakeLandscape();
    landscape.recording = recording;
    MatchLandscape(FitProblem({motion, motion}, options).blocks(), &landscape);
    return landscape;
  };
  const FitLandscape found = match({"mu"}, {"k_stretch", "time_offset"}, 1);
  EXPECT_EQ(found.x.block.name, "mu");
  EXPECT_EQ(found.y.block.name, "k_stretch@2");
  EXPECT_EQ(found.others, (std::vector<std::string>{"time_offset@2"}));
  ExpectError([&] { match({"mu", "k_bend"}, {}, 0); }, ErrorKind::kUsage, {"--landscape: cost", "'k_stretch'"});
  ExpectError([&] { match({"mu.ball", "k_stretch"}, {}, 0); }, ErrorKind::kUsage, {"--landscape: cost", "'mu'"});
}

TEST(ReportLandscapeTest, CostTellsTheRmse) {
  RecordedMotion motion = Motion();
  motion.positions.block<3, 1>(3 * 7, 3).setConstant(kNaN);
  motion.positions(3 * 9, 4) = kNaN;
  const auto expect_rmse = [](const RecordedMotion& recorded, const Eigen::MatrixXd& predicted) {
    const Observation observation(recorded);
    const double cost = 0.5 * observation.Residuals(predicted).squaredNorm();
    const double rmse = observation.Compare(predicted).rmse();
    EXPECT_NEAR(RmseOfRootCost(recorded) * std::sqrt(cost), rmse, 1e-12 * rmse);
  };
  const Eigen::MatrixXd predicted = Eigen::MatrixXd::Constant(motion.positions.rows(), motion.positions.cols(), 0.1);
  for (const double sigma : {0.0, 2e-3}) {
    motion.sigma = sigma > 0.0 ? Eigen::VectorXd::Constant(motion.num_points(), sigma) : Eigen::VectorXd();
    expect_rmse(motion, predicted);
  }
  motion.sigma[8] = 3e-3;
  EXPECT_TRUE(std::isnan(RmseOfRootCost(motion)));
}

}  // namespace
}  // namespace clothid::report_landscape_test
