// Cells are what a fit would see at their parameters, whoever evaluates them and after what.
#include "tools/landscape/landscape_scan.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <numeric>

#include "costs/rows/rollout_evaluator.h"
#include "identify/fit/fit.h"
#include "identify/landscape/scanned_fit.h"
#include "identify/result/result_json.h"
#include "sim/base/json_document.h"
#include "tests/expect_error.h"
#include "tests/temporary_folder.h"
#include "tests/tools/landscape/landscape_motion.h"

namespace clothid::landscape_scan_test {
namespace {

bool SameBits(double a, double b) { return std::memcmp(&a, &b, sizeof(a)) == 0; }

void ExpectSameCell(const LandscapeCell& a, const LandscapeCell& b, int cell) {
  EXPECT_TRUE(SameBits(a.cost, b.cost)) << cell;
  EXPECT_EQ(a.failure, b.failure) << cell;
  EXPECT_EQ(std::memcmp(&a.counts, &b.counts, sizeof(RolloutCounts)), 0) << cell;
  EXPECT_TRUE(SameBits(a.gradient_x, b.gradient_x)) << cell;
  EXPECT_TRUE(SameBits(a.gradient_y, b.gradient_y)) << cell;
}

void ExpectSameCells(const Landscape& a, const Landscape& b) {
  ASSERT_EQ(a.cells.size(), b.cells.size());
  for (std::size_t i = 0; i < a.cells.size(); ++i) ExpectSameCell(a.cells[i], b.cells[i], static_cast<int>(i));
}

TEST(LandscapeScan, CostsAndGradientsAreThoseOfAFit) {
  LandscapeScanOptions options = SmallScan();
  options.plan.has_gradients = true;
  const Landscape landscape = ScanLandscape(options);
  const std::vector<ParameterBlock> blocks = MakeBlocks(options.motions[0].scene, {"mu", "k_stretch"});
  for (int cell = 0; cell < options.plan.num_cells(); ++cell) {
    const LandscapePlace place = options.plan.PlaceOf(cell);
    const LandscapeWindow& window = options.plan.windows[place.window];
    const double mu = window.x.Value(place.ix), stiffness = window.y.Value(place.iy);
    RolloutEvaluator evaluator(options.motions[0], blocks, RolloutCostOptions());
    const Eigen::Vector2d coordinates(mu, std::log(stiffness));
    const RolloutEvaluation& expected =
        evaluator.At({coordinates, Precision::kFull, EvaluationNeed::kGradient, {0, 1}});
    ASSERT_TRUE(expected.ok()) << expected.failure;
    const LandscapeCell& found = landscape.cells[cell];
    // A fit simulates at exp(log(k)).
    const double tolerance = std::exp(std::log(stiffness)) == stiffness ? 0.0 : 1e-8;
    EXPECT_NEAR(found.cost, expected.cost, tolerance * expected.cost) << cell;
    EXPECT_NEAR(found.gradient_x, expected.gradient[0], tolerance * expected.gradient.norm()) << cell;
    EXPECT_NEAR(found.gradient_y, expected.gradient[1], tolerance * expected.gradient.norm()) << cell;
    EXPECT_EQ(found.counts.steps, evaluator.statistics().counts.steps) << cell;
    EXPECT_EQ(found.counts.contacts, evaluator.statistics().counts.contacts) << cell;
    EXPECT_GT(found.counts.contact_changes(), 0) << cell;
    EXPECT_EQ(found.failure, "");
  }
}

TEST(LandscapeScan, GradientsAreTheSlopesBetweenCells) {
  LandscapeScanOptions options = SmallScan();
  options.plan.has_gradients = true;
  LandscapeWindow& window = options.plan.windows[0];
  constexpr double kStep = 1e-4;
  window.x = {"mu", ParameterScale::kLinear, 0.25 - kStep, 0.25 + kStep, 3};
  window.y = {"k_stretch", ParameterScale::kLog, 70.0 * std::exp(-kStep), 70.0 * std::exp(kStep), 3};
  options.cells = std::vector<int>{1, 3, 4, 5, 7};
  const std::vector<LandscapeCell> cells = ScanLandscape(options).cells;
  const double scale = std::hypot(cells[4].gradient_x, cells[4].gradient_y);
  EXPECT_GT(scale, 0.1);
  EXPECT_NEAR((cells[5].cost - cells[3].cost) / (2.0 * kStep), cells[4].gradient_x, 1e-5 * scale);
  EXPECT_NEAR((cells[7].cost - cells[1].cost) / (2.0 * kStep), cells[4].gradient_y, 1e-5 * scale);
  EXPECT_TRUE(std::isnan(cells[0].cost) && cells[0].failure.empty()) << "was not asked for";
}

TEST(LandscapeScan, CellsDoNotKnowOfEachOther) {
  LandscapeScanOptions options = SmallScan("both");
  options.plan.has_gradients = true;
  const Landscape expected = ScanLandscape(options);
  for (int num_threads : {2, 5}) {
    options.num_threads = num_threads;
    ExpectSameCells(ScanLandscape(options), expected);
  }
  options.num_threads = 1;
  std::vector<int> cells(static_cast<std::size_t>(options.plan.num_cells()));
  std::iota(cells.begin(), cells.end(), 0);
  std::shuffle(cells.begin(), cells.end(), std::mt19937(3));
  options.cells = cells;
  ExpectSameCells(ScanLandscape(options), expected);
  for (int cell = 0; cell < options.plan.num_cells(); cell += 7) {
    options.cells = std::vector<int>{cell};
    ExpectSameCell(ScanLandscape(options).cells[cell], expected.cells[cell], cell);
  }
  options.cells.reset();
  options.plan.has_gradients = false;
  const Landscape plain = ScanLandscape(options);
  for (std::size_t i = 0; i < plain.cells.size(); ++i) {
    EXPECT_TRUE(SameBits(plain.cells[i].cost, expected.cells[i].cost)) << i;
    EXPECT_TRUE(std::isnan(plain.cells[i].gradient_x) && std::isnan(plain.cells[i].gradient_y)) << i;
  }
}

TEST(LandscapeScan, TheTruthCostsNothingInItsOwnCell) {
  LandscapeScanOptions options = SmallScan("both");
  options.motions[0].positions(4, 1) = std::numeric_limits<double>::quiet_NaN();
  MeasureTruth({{"mu", options.plan.windows[0].x.Value(2)}, {"k_stretch", 60.0}, {"k_bend", 1e-3}}, &options);
  EXPECT_EQ(options.held, (std::map<std::string, double>{{"k_bend", 1e-3}}));
  EXPECT_TRUE(std::isnan(options.motions[0].positions(4, 1)));
  options.plan.windows[0].y = {"k_stretch", ParameterScale::kLinear, 20.0, 100.0, 3};
  const Landscape landscape = ScanLandscape(options);
  for (int setting = 0; setting < 2; ++setting) {
    const int first = options.plan.FirstCell(setting, 0), truth = first + 1 * 4 + 2;
    for (int cell = first; cell < first + options.plan.cells_per_window(); ++cell) {
      if (cell == truth) {
        EXPECT_EQ(landscape.cells[cell].cost, 0.0);
      } else {
        EXPECT_GT(landscape.cells[cell].cost, 0.01) << cell;
      }
    }
  }
}

TEST(LandscapeScan, AFailedRolloutIsNoNumber) {
  LandscapeScanOptions options = SmallScan();
  options.plan.has_gradients = true;
  SolverOptions& solver = options.motions[0].scene.solver;
  solver.max_newton_iterations = 1;
  solver.max_substep_halvings = 0;
  const Landscape landscape = ScanLandscape(options);
  for (const LandscapeCell& cell : landscape.cells) {
    EXPECT_NE(cell.failure.find("did not converge"), std::string::npos) << cell.failure;
    EXPECT_TRUE(std::isnan(cell.cost) && std::isnan(cell.gradient_x) && std::isnan(cell.gradient_y));
    EXPECT_EQ(cell.counts.failed_steps, 1);
  }
  ExpectError(
      [&] {
        MeasureTruth({{"mu", 0.2}, {"k_stretch", 80.0}}, &options);
      },
      ErrorKind::kBadData, {"true parameters", "did not converge"});
}

TEST(LandscapeScan, TellsOfEveryCellAndEndsWhenAsked) {
  LandscapeScanOptions options = SmallScan();
  options.num_threads = 2;
  options.cells = std::vector<int>{2, 3, 5, 8, 13};
  std::vector<int> cells;
  options.on_cell = [&](int cell, const LandscapeCell& result, int num_done, int num_cells) {
    cells.push_back(cell);
    EXPECT_EQ(num_done, static_cast<int>(cells.size()));
    EXPECT_EQ(num_cells, 5);
    EXPECT_GT(result.cost, 0.0);
    EXPECT_GT(result.seconds, 0.0);
  };
  ScanLandscape(options);
  std::sort(cells.begin(), cells.end());
  EXPECT_EQ(cells, *options.cells);

  std::atomic<bool> cancel{false};
  options.cancel = &cancel;
  options.num_threads = 1;
  options.on_cell = [&](int /*cell*/, const LandscapeCell& /*result*/, int num_done, int) { cancel = num_done == 2; };
  const Landscape landscape = ScanLandscape(options);
  EXPECT_GT(landscape.cells[2].cost, 0.0);
  EXPECT_GT(landscape.cells[3].cost, 0.0);
  EXPECT_TRUE(std::isnan(landscape.cells[5].cost) && landscape.cells[5].failure.empty());

  cancel = false;
  int num_calls = 0;
  options.on_cell = [&](int, const LandscapeCell&, int, int) {
    ++num_calls;
    throw Error(ErrorKind::kIo, "the disk is full");
  };
  ExpectError([&] { ScanLandscape(options); }, ErrorKind::kIo, {"the disk is full"});
  EXPECT_EQ(num_calls, 1);
}

TEST(LandscapeScan, ACellThatIsCancelledIsNotDone) {
  LandscapeScanOptions options = SmallScan();
  std::atomic<bool> cancel{false};
  options.cancel = &cancel;
  options.motions[0].scene.obstacles[0].shape = std::make_shared<InterruptingSphere>(200, &cancel);
  options.on_cell = [](int, const LandscapeCell&, int, int) { ADD_FAILURE() << "no cell is done"; };
  const Landscape landscape = ScanLandscape(options);
  EXPECT_TRUE(cancel);
  for (const LandscapeCell& cell : landscape.cells) EXPECT_TRUE(std::isnan(cell.cost) && cell.failure.empty());
}

TEST(LandscapeScan, RefusesWhatDoesNotFit) {
  const auto expect_refused = [](LandscapeScanOptions options, const char* expected) {
    ExpectError([&] { ScanLandscape(options); }, ErrorKind::kUsage, {expected});
  };
  LandscapeScanOptions options = SmallScan();
  options.num_threads = 0;
  expect_refused(options, "thread");
  options = SmallScan();
  options.motions.clear();
  expect_refused(options, "one recording per setting");
  options = SmallScan("velocity");
  options.motions[0].scene.contact_mode = ContactMode::kGap;
  expect_refused(options, "contact modes");
  options = SmallScan();
  options.cells = std::vector<int>{24};
  expect_refused(options, "cells");
  options = SmallScan();
  options.held = {{"mu.ball", 0.1}};
  expect_refused(options, "mu.ball");
  options.held = {{"k_bend", -1.0}};
  expect_refused(options, "k_bend");

  options = SmallScan();
  const auto expect_no_truth = [&](const std::map<std::string, double>& truth, const char* expected) {
    ExpectError([&] { MeasureTruth(truth, &options); }, ErrorKind::kUsage, {"--set", expected});
  };
  expect_no_truth({{"mu", 0.2}}, "k_stretch");
  expect_no_truth({{"mu", 0.2}, {"k_stretch", 0.0}}, "k_stretch");
  expect_no_truth({{"mu", 0.2}, {"k_stretch", 50.0}, {"mu.ball", 0.3}}, "mu.ball");
  expect_no_truth({{"mu", 0.2}, {"k_stretch", 50.0}, {"weight", 0.3}}, "weight");
}

// A fit whose frames count by a known error, told by its result.json: the cell at the estimate has its cost.
TEST(LandscapeScan, FollowsAFit) {
  LandscapeScanOptions scan = SmallScan();
  RecordedMotion& motion = scan.motions[0];
  motion.sha256 = std::string(64, 'a');
  FitOptions options;
  options.parameters = {"mu", "k_stretch", "drag"};
  options.weighs_model_error = false;
  ErrorCurve curve{Eigen::Vector3d(0.0, 0.1, 0.3), Eigen::Vector3d(0.0, 1.0 / 3.0, 0.7), 7.1};
  curve.variances *= 1e-3;
  options.model_errors.resize(1);
  options.model_errors[0].CurveOf(PredictedKind::kPoints) = curve;
  FitProblem problem({motion}, options);
  const FitSummary summary = Fit(options, &problem);
  ASSERT_TRUE(summary.has_estimate()) << summary.message;
  const TemporaryFolder folder;
  folder.Write("result.json", ResultJson(summary, FitChecks(), {motion}));
  const FittedResult result = ReadFittedResult(folder.File("result.json"));
  const ErrorCurve& found = result.model_errors.at(0).CurveOf(PredictedKind::kPoints);
  EXPECT_EQ(found.times, curve.times);
  EXPECT_EQ(found.variances, curve.variances);
  EXPECT_EQ(found.alike, curve.alike);

  FollowFit(ScannedFitOf(result, motion), &scan);
  EXPECT_EQ(scan.held, (std::map<std::string, double>{{"drag", summary.parameters[2].value}}));
  LandscapeWindow& window = scan.plan.windows[0];
  window.x.lower = summary.parameters[0].value;
  window.y.lower = summary.parameters[1].value;
  window.x.upper = window.x.lower + 0.1;
  window.y.upper = 2.0 * window.y.lower;
  scan.cells = std::vector<int>{0};
  EXPECT_NEAR(ScanLandscape(scan).cells[0].cost, summary.cost, 1e-9 * summary.cost);
  scan.model_error = {};
  EXPECT_GT(ScanLandscape(scan).cells[0].cost, 1.01 * summary.cost);

  RecordedMotion other = motion;
  other.sha256 = std::string(64, 'b');
  ExpectError([&] { ScannedFitOf(result, other); }, ErrorKind::kUsage, {"--result", "other recordings"});
  other = motion;
  other.sigma_source = SigmaSource::kGiven;
  ExpectError([&] { ScannedFitOf(result, other); }, ErrorKind::kUsage, {"--result", "another sigma or start"});
}

// A fit whose rollouts the recording corrects: the cell at the estimate has its cost, and the truth is not corrected.
TEST(LandscapeScan, FollowsAFitOfCorrectedRollouts) {
  LandscapeScanOptions scan = SmallScan();
  RecordedMotion& motion = scan.motions[0];
  motion.sha256 = std::string(64, 'a');
  FitOptions options;
  options.parameters = {"mu", "k_stretch"};
  options.assimilate = {AssimilationOption::Kind::kMemory, {0.05, 0.03}};
  FitProblem problem({motion}, options);
  const FitSummary summary = Fit(options, &problem);
  ASSERT_TRUE(summary.has_estimate()) << summary.message;
  const TemporaryFolder folder;
  folder.Write("result.json", ResultJson(summary, FitChecks(), {motion}));
  const ScannedFit fit = ScannedFitOf(ReadFittedResult(folder.File("result.json")), motion);
  EXPECT_TRUE(IsSame(fit.assimilation, options.assimilate.given));
  const JsonValue json = ParseJson(ScannedFitJson(fit).dump(), "fit.json");
  EXPECT_TRUE(IsSame(ReadScannedFit(JsonNode(json, "fit.json")).assimilation, fit.assimilation));

  FollowFit(fit, &scan);
  LandscapeWindow& window = scan.plan.windows[0];
  window.x.lower = summary.parameters[0].value;
  window.y.lower = summary.parameters[1].value;
  window.x.upper = window.x.lower + 0.1;
  window.y.upper = 2.0 * window.y.lower;
  scan.cells = std::vector<int>{0};
  EXPECT_NEAR(ScanLandscape(scan).cells[0].cost, summary.cost, 1e-9 * summary.cost);
  LandscapeScanOptions uncorrected = scan;
  uncorrected.assimilation = {};
  EXPECT_GT(ScanLandscape(uncorrected).cells[0].cost, 1.01 * summary.cost);

  LandscapeScanOptions truth = uncorrected;
  const std::map<std::string, double> values = {{"mu", window.x.lower}, {"k_stretch", window.y.lower}};
  MeasureTruth(values, &truth);
  MeasureTruth(values, &scan);
  EXPECT_EQ(scan.motions[0].positions, truth.motions[0].positions);
  constexpr double kRounding = 1e-12;  // m, of a coordinate; the fit misses by 1e-7
  EXPECT_LT(ScanLandscape(scan).cells[0].cost,
            0.5 * static_cast<double>(scan.motions[0].positions.size()) * kRounding * kRounding);
}

}  // namespace
}  // namespace clothid::landscape_scan_test
