#include <gtest/gtest.h>

#include <algorithm>
#include <string>

#include "tests/expect_error.h"
#include "tools/benchmark/fits/figure3_table.h"

namespace clothid {
namespace {

// One offset, so that it takes seconds.
Figure3Options SmallOptions() {
  Figure3Options options;
  options.offsets = {0.3};
  options.touches = {1e-5};
  options.zooms = {0.01};
  options.cells = 5;
  options.starts_per_axis = 1;
  options.noise = 0.0;
  return options;
}

class Figure3Test : public testing::Test {
 protected:
  static void SetUpTestSuite() { figure_ = new Figure3(RunFigure3(SmallOptions())); }
  static void TearDownTestSuite() { delete figure_; }

  static const Figure3* figure_;
};

const Figure3* Figure3Test::figure_ = nullptr;

TEST_F(Figure3Test, ScansEverySettingAndWindow) {
  ASSERT_EQ(figure_->settings.size(), 2u);
  EXPECT_EQ(figure_->settings[0].Name(), "ball.center.x=0.3");
  EXPECT_EQ(figure_->settings[1].Name(), "ball.center.x=0.3;touch=1e-05");
  ASSERT_EQ(figure_->summary.plan.windows.size(), 2u);
  ASSERT_EQ(figure_->summary.windows.size(), 4u);
  for (const WindowSummary& window : figure_->summary.windows) {
    EXPECT_EQ(window.roughness.cells, 25);
    EXPECT_EQ(window.roughness.failed_cells, 0);
    EXPECT_GT(window.roughness.off_quadratic, 0.0);
    EXPECT_GT(window.contact.contacts_per_step, 0.0);
    EXPECT_GT(window.contact.nodes_joined, 0.0);
  }
}

// The zoom is centred at the truth, where the setting's own recording comes from.
TEST_F(Figure3Test, TheCostIsZeroAtTheTruthInBothModes) {
  for (int setting = 0; setting < 2; ++setting) {
    const WindowSummary& zoom = figure_->summary.Of(setting, 1);
    EXPECT_LT(zoom.minimum, 1e-9 * zoom.roughness.range);
    EXPECT_NEAR(zoom.x, kFigure3Friction, 1e-12);
    EXPECT_NEAR(zoom.y, kFigure3Stiffness, 1e-9);
  }
}

TEST_F(Figure3Test, FitsFindTheTruth) {
  ASSERT_EQ(figure_->fits.size(), 2u);
  EXPECT_TRUE(figure_->fits[0].reached);  // in gap mode; the other may fail, which is what is measured
  EXPECT_NEAR(figure_->fits[0].value[0], kFigure3Friction, 1e-4 * kFigure3Friction);
  EXPECT_NEAR(figure_->fits[0].value[1], kFigure3Stiffness, 1e-4 * kFigure3Stiffness);
}

TEST_F(Figure3Test, IsTheSameOnTwoThreads) {
  Figure3Options options = SmallOptions();
  options.num_threads = 2;
  const Figure3 again = RunFigure3(options);
  EXPECT_EQ(Figure3Csv(again), Figure3Csv(*figure_));
  EXPECT_EQ(Figure3FitsCsv(again), Figure3FitsCsv(*figure_));
  EXPECT_EQ(Figure3Table(again), Figure3Table(*figure_));
}

TEST_F(Figure3Test, WritesOneRowPerWindowAndFit) {
  const std::string windows = Figure3Csv(*figure_), fits = Figure3FitsCsv(*figure_);
  EXPECT_EQ(std::count(windows.begin(), windows.end(), '\n'), 1 + 4);
  EXPECT_EQ(std::count(fits.begin(), fits.end(), '\n'), 1 + 2);
}

// Made-up windows: three offsets whose roughness grows with events, or falls.
TEST(Figure3CorrelationTest, FollowsTheOrderOfTheOffsets) {
  Figure3 figure;
  figure.summary.plan.windows.resize(2);
  for (int i = 0; i < 3; ++i) {
    figure.settings.push_back({0.1 * i, ContactMode::kVelocity, 1e-5});
    for (int w = 0; w < 2; ++w) {
      WindowSummary window;
      window.contact.contact_changes = 10.0 + i;
      window.roughness.off_quadratic = w == 0 ? 0.01 * (i + 1) : 0.01 / (i + 1);
      figure.summary.windows.push_back(window);
    }
  }
  EXPECT_DOUBLE_EQ(RoughnessAgainstEvents(figure, 1e-5, 0).rho, 1.0);
  EXPECT_DOUBLE_EQ(RoughnessAgainstEvents(figure, 1e-5, 1).rho, -1.0);
}

TEST(Figure3OptionsTest, RefusesWhatIsOutOfRange) {
  const auto expect_error = [](const char* flag, void (*change)(Figure3Options*)) {
    Figure3Options options = SmallOptions();
    change(&options);
    ExpectError([&] { options.Validate(); }, ErrorKind::kUsage, {flag});
  };
  expect_error("--offsets", [](Figure3Options* options) { options->offsets.clear(); });
  expect_error("--touch", [](Figure3Options* options) { options->touches = {-1.0}; });
  expect_error("--zoom", [](Figure3Options* options) { options->zooms = {0.01, 0.03}; });
  expect_error("--zoom", [](Figure3Options* options) { options->zooms = {1.5}; });
  expect_error("--cells", [](Figure3Options* options) { options->cells = 2; });
  expect_error("--starts", [](Figure3Options* options) { options->starts_per_axis = -1; });
  expect_error("--noise", [](Figure3Options* options) { options->noise = -1.0; });
  expect_error("--threads", [](Figure3Options* options) { options->num_threads = 0; });
}

}  // namespace
}  // namespace clothid
