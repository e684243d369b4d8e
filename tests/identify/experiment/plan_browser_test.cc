// plan.html in a headless Chromium: bars, replays in step and each by itself, windows of every width.
#include <gtest/gtest.h>

#include <string>

#include "tests/identify/report/page_browser.h"

namespace clothid::plan_browser_test {
namespace {

constexpr char kSwing[] = R"({"clothid_scene": 2, "time_step": 0.01, "duration": 0.4,
  "mesh": {"grid": {"nodes": [5, 5], "size": [0.5, 0.5]}}, "initial": {"positions": "rest"}, "handles": [0, 4],
  "materials": {"density": 0.15, "k_stretch": 300}})";
constexpr char kFall[] = R"({"clothid_scene": 2, "time_step": 0.01, "duration": 0.2,
  "mesh": {"grid": {"nodes": [3, 3], "size": [0.2, 0.2]}}, "initial": {"positions": "rest"},
  "materials": {"density": 0.15, "k_stretch": 300}})";

class PlanBrowserTest : public PageBrowserTest {
 protected:
  // The page of a plan of two motions, one with a hostile name, and of what they tell of a third, opened.
  void OpenPlan() {
    WriteBytes(folder() / "<img src=x onerror=alert(1)>.json", kSwing);
    WriteBytes(folder() / "fall.json", kFall);
    WriteBytes(folder() / "other.json", kSwing);
    ASSERT_EQ(Run("plan --scenes '<img src=x onerror=alert(1)>.json,fall.json' --fit k_stretch,density --sigma 0.002 "
                  "--predict other.json "
                  "--prior density=0.15:1.05 "
                  "--draws 0 --initial scene --forces=false --output out")
                  .exit_code,
              0);
    browser().Open((folder() / "out" / "plan.html").string(), "part('motions-caption').textContent.length > 0");
  }
};

TEST_F(PlanBrowserTest, MotionsPlayInStepOrEachByItself) {
  OpenPlan();
  EXPECT_EQ(browser().Evaluate("document.querySelector('.motion h3').textContent"), "<img src=x onerror=alert(1)>");
  EXPECT_EQ(browser().Evaluate("document.querySelectorAll('img').length"), 0);
  browser().Evaluate("document.querySelectorAll('canvas').forEach((made, i) => { made.id = `canvas-${i}`; })");
  const std::string first = LookAt("canvas-0").picture;
  EXPECT_GT(LookAt("canvas-0").colours, 50);
  browser().Evaluate("showAll(0.3)");
  EXPECT_NE(LookAt("canvas-0").picture, first);
  EXPECT_EQ(browser().Evaluate("panels.map((panel) => panel.frame)"), Json({30, 20})) << "the last frame stays";
  const std::string mark = "Number(document.querySelector('.motion .mark').getAttribute('x1'))";
  const double before = browser().Evaluate(mark);
  browser().Click("in-step");
  browser().Evaluate("jump(panels[0], 0.1)");
  EXPECT_EQ(browser().Evaluate("panels.map((panel) => panel.frame)"), Json({10, 20}));
  EXPECT_LT(browser().Evaluate(mark).get<double>(), before - 50.0);
  browser().Click("in-step");
  browser().Click("play");
  browser().WaitUntil("panels[1].frame > 2 && clock.isPlaying");
  browser().Click("play");
  EXPECT_EQ(browser().Evaluate("clock.isPlaying"), false);
  ExpectPeace();
}

TEST_F(PlanBrowserTest, SaysWhatIsToldAndFitsEveryWindow) {
  OpenPlan();
  EXPECT_EQ(browser().Evaluate("document.querySelectorAll('.parameter').length"), 2);
  EXPECT_GT(browser().Evaluate("document.querySelectorAll('.track.untold').length").get<int>(), 0);
  EXPECT_NE(Text("intervals").get<std::string>().find("not told: "), std::string::npos);
  EXPECT_NE(Text("intervals").get<std::string>().find("noise \u00b1 "), std::string::npos);
  const std::string prediction = Text("prediction");
  EXPECT_NE(prediction.find("\u00b1 "), std::string::npos) << prediction;
  EXPECT_LT(prediction.find("onerror"), prediction.find("fall")) << "the narrowest first";
  EXPECT_NE(Text("prediction-caption").get<std::string>().find("Of other"), std::string::npos);
  for (const int width : {400, 700, 1000, 1400}) {
    browser().Resize(width, 900);
    EXPECT_EQ(browser().WhatStandsOut(), "") << width;
  }
  browser().Resize(400, 900);
  EXPECT_EQ(browser().WhatIsTooSmall(), "");
  ExpectPeace();
}

}  // namespace
}  // namespace clothid::plan_browser_test
