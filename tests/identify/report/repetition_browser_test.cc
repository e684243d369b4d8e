// Forest plots of repetitions in a headless Chromium.
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "datasets/motion/motion_file.h"
#include "identify/fit/fit.h"
#include "identify/report/report_page.h"
#include "tests/identify/report/made_repetitions.h"
#include "tests/identify/report/page_browser.h"

namespace clothid::repetition_browser_test {
namespace {

class RepetitionBrowserTest : public PageBrowserTest {
 protected:
  void Open(const std::string& html) {
    WriteBytes(folder() / "report.html", html);
    browser().Open((folder() / "report.html").string(), "document.querySelector('#repetitions .caption')");
  }

  void OpenPooled() { Open(MadePooledHtml()); }

  void OpenFit() {
    const std::string scene = WriteScene(SphereJson());
    ASSERT_EQ(Run("simulate --scene " + scene + " --noise 0.001 --output a.bin").exit_code, 0);
    const std::vector<RecordedMotion> motions = {ReadMotion((folder() / "a.bin").string())};
    FitOptions fit;
    fit.parameters = {"k_stretch"};
    FitProblem problem(motions, fit);
    const FitSummary summary = Fit(fit, &problem);
    ASSERT_TRUE(summary.has_estimate()) << summary.message;
    Open(ReportHtml(summary, ChecksOf(MadeRepetitions()), motions));
  }

  // A row of the table of a parameter, the head being row 0.
  static std::string Row(int table, int row) {
    return "document.querySelectorAll('#repetitions-" + std::to_string(table) + " tr')[" + std::to_string(row) + "]";
  }
  std::string RowText(int table, int row) { return browser().Evaluate(Row(table, row) + ".textContent"); }
  // The middle and the width of what is drawn there, in shares of the chart.
  Json Drawn(int table, int row, const std::string& what) {
    return browser().Evaluate("(() => { const row = " + Row(table, row) + ", all = row.querySelector('.forest')" +
                              ".getBoundingClientRect(), boxes = [...row.querySelectorAll('" + what +
                              "')].map(e => e.getBoundingClientRect()); if (!boxes.length) return null; const left = " +
                              "Math.min(...boxes.map(b => b.left)), right = Math.max(...boxes.map(b => b.right)); " +
                              "return [((left + right) / 2 - all.left) / all.width, (right - left) / all.width]; })()");
  }
  void ExpectHas(const std::string& text, const std::string& part) {
    EXPECT_NE(text.find(part), std::string::npos) << part << " in: " << text;
  }
};

TEST_F(RepetitionBrowserTest, DrawsEstimatesOnALogarithmicAxis) {
  OpenPooled();
  const Json result = browser().Evaluate("result.repetitions.parameters.k_stretch");
  // One straight line from the logarithms of the values to where they are drawn.
  const double first = Drawn(0, 1, ".square")[0], outlier = Drawn(0, 5, ".square")[0];
  const double slope = (outlier - first) / std::log(90.0 / 50.0);
  const auto place = [&](double value) { return first + slope * std::log(value / 50.0); };
  EXPECT_NEAR(Drawn(0, 3, ".square")[0], place(49.0), 2e-3);
  EXPECT_NEAR(Drawn(0, 4, ".interval")[1], slope * std::log((50.5 + 7.84) / (50.5 - 7.84)), 2e-3);
  const double lower = result["lower95"], upper = result["upper95"], mean = result["mean"];
  EXPECT_NEAR(Drawn(0, 7, ".diamond")[1], slope * std::log(upper / lower), 2e-3);
  EXPECT_NEAR(Drawn(0, 7, ".diamond")[0], place(mean), 2e-3);
  EXPECT_NEAR(Drawn(0, 7, ".mean")[0], place(mean), 2e-3);
  const double next_lower = result["next_lower95"], next_upper = result["next_upper95"];
  EXPECT_NEAR(Drawn(0, 8, ".next")[1], slope * std::log(next_upper / next_lower), 2e-3);
  // Areas of squares are as their weights: the one that knows least is the smallest of those that are pooled.
  const double least = Drawn(0, 4, ".square")[1], most = Drawn(0, 1, ".square")[1];
  EXPECT_LT(least, most);
  ExpectPeace();
}

TEST_F(RepetitionBrowserTest, SaysWhatIsDrawn) {
  OpenPooled();
  ExpectHas(RowText(0, 2), "b.bin51 (49.04 … 52.96)");
  ExpectHas(RowText(0, 5), "does not fit the others: ");
  EXPECT_EQ(browser().Evaluate(Row(0, 5) + ".querySelectorAll('.square.misfit').length"), 1);
  EXPECT_EQ(browser().Evaluate("document.querySelectorAll('#repetitions .square.misfit').length"), 1);
  ExpectHas(RowText(0, 6), "f.bin not used");
  EXPECT_EQ(browser().Evaluate(Row(0, 6) + ".querySelector('.weight').textContent"), "");
  ExpectHas(RowText(0, 7), "Mean of 5 recordings");
  ExpectHas(RowText(0, 8), "Next specimen");
  const std::string text = Text("repetitions");
  ExpectHas(text, "f.bin is not used: do not use: the fit has not converged");
  ExpectHas(text, "Cochran's Q: ");
  ExpectHas(text, browser().Evaluate("data.repetition_lines.k_stretch"));
  EXPECT_EQ(text.find("Joint fit"), std::string::npos) << "there is none";
  // Pooled of two recordings: nothing of the next specimen.
  ExpectHas(RowText(1, 1), "0.3 (");
  ExpectHas(RowText(1, 3), "has no mu");
  EXPECT_EQ(Drawn(1, 3, ".square"), Json());
  ExpectHas(RowText(1, 4), "does not tell mu alone");
  ExpectHas(RowText(1, 8), "told by three recordings or more");
  // One recording alone: no mean.
  ExpectHas(RowText(2, 1), "alone in telling k_bend");
  EXPECT_EQ(browser().Evaluate("document.querySelectorAll('#repetitions-2 .diamond').length"), 0);
  ExpectPeace();
}

TEST_F(RepetitionBrowserTest, NamesAreShown) {
  OpenPooled();
  ExpectHas(RowText(0, 1), kHostileRecording);
  EXPECT_EQ(browser().Evaluate("document.querySelectorAll('img').length"), 0);
  EXPECT_EQ(browser().Evaluate("document.title"), "Repetitions: 6 finished fits");
  ExpectPeace();
}

TEST_F(RepetitionBrowserTest, FitsEveryWindow) {
  OpenPooled();
  for (const int width : {400, 700, 1400}) {
    browser().Resize(width, 900);
    EXPECT_EQ(browser().WhatStandsOut(), "") << width;
    EXPECT_GT(browser().Evaluate(Row(0, 1) + ".querySelector('.forest').getBoundingClientRect().width"), 200) << width;
    // Marks of the axis lie apart.
    EXPECT_EQ(browser().Evaluate("(() => { const boxes = [...document.querySelectorAll('#repetitions-0 .axis text')]"
                                 ".slice(0, -1).map(t => t.getBoundingClientRect()); return boxes.length > 2 && "
                                 "boxes.every((b, i) => i === 0 || b.left > boxes[i - 1].right); })()"),
              true)
        << width;
  }
  ExpectPeace();
}

TEST_F(RepetitionBrowserTest, AFitHasItsJointEstimateBesideThem) {
  OpenFit();
  ExpectHas(RowText(0, 9), "Joint fit");
  const Json estimate = browser().Evaluate("result.parameters.k_stretch.value");
  const double first = Drawn(0, 1, ".square")[0], outlier = Drawn(0, 5, ".square")[0];
  EXPECT_NEAR(Drawn(0, 9, "path.joint")[0],
              first + (outlier - first) * std::log(estimate.get<double>() / 50.0) / std::log(90.0 / 50.0), 2e-3);
  EXPECT_TRUE(browser().Evaluate("!!(part('repetitions').compareDocumentPosition(part('per-frame')) & 4)"));
  for (const int width : {400, 1400}) {
    browser().Resize(width, 900);
    WaitForCharts();
    EXPECT_EQ(browser().WhatStandsOut(), "") << width;
  }
  ExpectPeace();
}

}  // namespace
}  // namespace clothid::repetition_browser_test
