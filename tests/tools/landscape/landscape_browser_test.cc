// landscape.html in a headless Chromium: wide and narrow, what its colours and marks say, names that are shown.
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <memory>
#include <optional>
#include <string>

#include "identify/landscape/landscape_folder.h"
#include "tests/identify/report/browser.h"
#include "tests/temporary_folder.h"
#include "tests/tools/landscape/bumpy_landscape.h"
#include "tools/landscape/landscape_plot.h"
#include "tools/landscape/landscape_summary.h"

namespace clothid::landscape_browser_test {
namespace {

using Json = nlohmann::json;

constexpr char kHostileName[] = "<img src=x onerror=document.title=name>";
constexpr int kNumCells = 9;

// Two windows in two contact modes, the corner of the first failed.
LandscapePart Part() {
  LandscapePart part;
  part.landscape = BumpyLandscape({kHostileName}, {1.0, 0.1}, kNumCells);
  FailCell(0, "step 3 <b>did</b> not converge", &part.landscape);
  part.origin.version = "1.2.3";
  part.origin.input_sha256 = std::string(64, 'b');
  part.origin.truth = {{"mu", 0.36}, {"k_stretch", 250.0}};
  part.origin.sigma = {SigmaSource::kGiven, 0.002, 1e-3};
  return part;
}

class LandscapeBrowserTest : public testing::Test {
 protected:
  void SetUp() override {
    if (!FindChromium())
      GTEST_SKIP() << "the package chromium is absent: install it, or set CHROMIUM to another Chromium";
    if (!browser_) browser_ = std::make_unique<Browser>(*FindChromium());
  }
  static void TearDownTestSuite() { browser_.reset(); }

  // In a window of that size; without 3D where there is no room for surfaces.
  void Open(const LandscapePart& part, int width = 600, int height = 900) {
    browser_->OpenPage(width, height);
    Load(part);
  }
  void Load(const LandscapePart& part) {
    const std::string html = LandscapeHtml(part, Summarize(part.landscape));
    browser_->Open(folder_.Write("landscape.html", html), "panels.length > 0 && panels[0].contours._fullLayout");
  }
  Browser& browser() { return *browser_; }
  // Of the map of the first window and setting.
  Json Trace(const std::string& name, const std::string& of) {
    return browser_->Evaluate("panels[0].contours.data.find(t => (t.name || t.type) === '" + name + "')." + of);
  }
  void Select(const std::string& id, const std::string& value) {
    browser_->Evaluate("(() => { part('" + id + "').value = '" + value + "'; part('" + id +
                       "').dispatchEvent(new Event('change')); })()");
  }
  void ExpectPeace() {
    EXPECT_EQ(browser_->complaints(), std::vector<std::string>());
    EXPECT_EQ(browser_->requests(), std::vector<std::string>());
  }

 private:
  TemporaryFolder folder_;
  inline static std::unique_ptr<Browser> browser_;
};

TEST_F(LandscapeBrowserTest, FitsEveryWindow) {
  Open(Part(), 400);
  for (const int width : {400, 700, 1000, 1400}) {
    browser().Resize(width, 900);
    browser().WaitUntil(
        "!panels[0].staleMap && Math.abs(panels[0].contours._fullLayout.width - panels[0].contours.clientWidth) < 1");
    EXPECT_EQ(browser().WhatStandsOut(), "") << width;
    // The window is used to its right margin.
    const double right = browser().Evaluate("Math.max(...panels.map(p => p.card.getBoundingClientRect().right))");
    EXPECT_GE(right, std::min(width - 21, 1340)) << width;
    EXPECT_GT(browser().Evaluate("panels[0].contours._fullLayout._size.w").get<double>(), 250.0) << width;
  }
  browser().Resize(400, 900);
  EXPECT_EQ(browser().WhatIsTooSmall(), "");
  EXPECT_EQ(Trace("contour", "colorbar.orientation"), "h");
  ExpectPeace();
}

TEST_F(LandscapeBrowserTest, SettingsStandSideBySide) {
  Open(Part(), 1400, 300);  // low, so that the second window is out of sight: 3D takes its time
  EXPECT_EQ(browser().Evaluate("panels.length"), 4);
  const Json corners = browser().Evaluate(
      "panels.map(p => [p.card.getBoundingClientRect().left, p.card.getBoundingClientRect().top].map(Math.round))");
  EXPECT_LT(corners[0][0], corners[1][0]);
  EXPECT_EQ(corners[0][1], corners[1][1]) << "one window, two settings";
  EXPECT_LT(corners[0][1], corners[2][1]) << "the next window below";
  EXPECT_EQ(corners[0][0], corners[2][0]);
  // Surfaces are drawn beside the maps, one of them turns where it is clicked, and the others follow.
  browser().WaitUntil("panels[0].surface.querySelector('img')?.complete && panels[1].surface.querySelector('img')");
  const Json before = browser().Evaluate("panels[1].surface.querySelector('img').src.length");
  browser().Evaluate("panels[0].surface.querySelector('button').click()");
  browser().WaitUntil("turning.plot.querySelector('canvas')");
  browser().Evaluate("Plotly.relayout(turning.plot, {'scene.camera': {eye: {x: 2, y: 0.1, z: 0.3}}}).then(() => true)");
  browser().WaitUntil("panels[1].surface.querySelector('img').src.length !== " + before.dump());
  ExpectPeace();
}

// By default the logarithm of what a cell costs above the lowest one, whose valley takes more than one colour.
TEST_F(LandscapeBrowserTest, ColoursShowTheValley) {
  const LandscapePart part = Part();
  Open(part);
  EXPECT_EQ(browser().Evaluate("part('measure').value"), "above");
  const WindowSummary lowest = Summarize(part.landscape).Of(0, 0);
  const double range = lowest.roughness.range;
  const Json z = Trace("contour", "z");
  double next = range;
  int below_tenth = 0;
  for (int cell = 1; cell < kNumCells * kNumCells; ++cell) {
    const double above = part.landscape.cells[cell].cost - lowest.minimum;
    if (above < 0.1 * range) ++below_tenth;
    if (above == 0.0) continue;
    next = std::min(next, above);
    EXPECT_NEAR(z[cell / kNumCells][cell % kNumCells], std::log10(above), 1e-6) << cell;
  }
  EXPECT_GT(below_tenth, 10);
  EXPECT_EQ(z[0][0], Json()) << "failed";
  EXPECT_EQ(Trace("contour", "colorbar.title.text"), "above lowest");
  const double low = Trace("contour", "zmin"), high = Trace("contour", "zmax");
  EXPECT_NEAR(high, std::log10(range), 1e-6);
  EXPECT_NEAR(low, std::log10(0.5 * next), 1e-6) << "colours do not end in the spike of the lowest cell";
  EXPECT_LT(low, high - 1.5) << "a tenth of the range has half of the colours";
  // Marks of the bar are costs, not logarithms.
  const Json marks = Trace("contour", "colorbar.tickvals"), texts = Trace("contour", "colorbar.ticktext");
  ASSERT_GE(marks.size(), 3u);
  for (std::size_t i = 0; i < marks.size(); ++i) {
    EXPECT_NEAR(std::stod(texts[i].get<std::string>()), std::pow(10.0, marks[i].get<double>()),
                1e-6 * std::pow(10.0, marks[i].get<double>()));
  }

  Select("measure", "cost");
  EXPECT_NEAR(Trace("contour", "z[4][5]"), part.landscape.cells[4 * kNumCells + 5].cost, 1e-9);
  Select("measure", "rmse");
  EXPECT_EQ(Trace("contour", "colorbar.title.text"), "rmse, mm");

  LandscapePart old = part;
  old.origin.sigma.reset();
  Load(old);
  EXPECT_EQ(browser().Evaluate("[...part('measure').options].map(o => o.value).join()"), "above,cost");
  ExpectPeace();
}

// Every cell the same: no logarithm of nothing, and no colours.
TEST_F(LandscapeBrowserTest, FlatAndFailedWindows) {
  LandscapePart part = Part();
  const int count = part.landscape.plan.cells_per_window();
  for (int cell = 0; cell < count; ++cell) {
    part.landscape.cells[cell].cost = 2.0;
    part.landscape.cells[cell].failure.clear();
    FailCell(count + cell, "no", &part.landscape);
  }
  Open(part);
  EXPECT_EQ(Trace("contour", "showscale"), false);
  browser().WaitUntil("panels[2].contours._fullLayout || (panels[2].card.scrollIntoView(), false)");
  EXPECT_EQ(browser().Evaluate("panels[2].contours.data.map(t => t.name || t.type).join()"), "failed");
  ExpectPeace();
}

TEST_F(LandscapeBrowserTest, MarksWhatMatters) {
  const LandscapePart part = Part();
  Open(part);
  const WindowSummary lowest = Summarize(part.landscape).Of(0, 0);
  EXPECT_NEAR(Trace("lowest cell", "x[0]"), lowest.x, 1e-12);
  EXPECT_NEAR(Trace("lowest cell", "y[0]"), lowest.y, 1e-9);
  EXPECT_EQ(Trace("truth", "x"), Json({0.36}));
  EXPECT_EQ(Trace("truth", "y"), Json({250.0}));
  EXPECT_EQ(Trace("failed", "x.length"), 1);
  EXPECT_NE(Trace("failed", "text[0]").get<std::string>().find("failed: step 3 &lt;b&gt;did"), std::string::npos);
  // A mark at the edge of a map is drawn, too.
  EXPECT_EQ(browser().Evaluate("[...panels[0].contours.querySelectorAll('.points path')]"
                               ".filter(p => getComputedStyle(p).display !== 'none').length"),
            3);
  const std::string words = browser().Evaluate("panels[0].card.textContent");
  for (const char* expected : {"★lowest cell: mu ", "◯truth: mu 0.36, k_stretch 250 N/m", "✕1 of 81 cells failed"}) {
    EXPECT_NE(words.find(expected), std::string::npos) << words;
  }
  EXPECT_EQ(browser().Evaluate("part('status').textContent"), "1 of 324 cells failed");
  // The truth lies outside of the zoom.
  EXPECT_EQ(browser().Evaluate("panels[2].card.textContent.includes('truth')"), false);
  EXPECT_NE(browser().Evaluate("part('provenance').textContent").get<std::string>().find("2 mm, given by --sigma"),
            std::string::npos);

  // Names are shown, not run.
  EXPECT_NE(browser().Evaluate("part('groups').textContent").get<std::string>().find(kHostileName), std::string::npos);
  EXPECT_EQ(browser().Evaluate("document.title"), "Landscape of the cost over mu and k_stretch");
  EXPECT_EQ(browser().Evaluate("document.querySelectorAll('img[src=x], b.x').length"), 0);
  browser().Evaluate("part('licences-details').open = true");
  browser().WaitUntil("part('licences-shown').textContent.includes('MIT')");
  ExpectPeace();
}

}  // namespace
}  // namespace clothid::landscape_browser_test
