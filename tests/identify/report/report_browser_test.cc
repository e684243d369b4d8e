// report.html in a headless Chromium: clicks through it and looks at the picture.
#include "tests/identify/report/report_browser.h"

#include <gtest/gtest.h>

#include <cmath>
#include <set>
#include <string>
#include <vector>

namespace clothid::report_browser_test {
namespace {

TEST_F(ReportBrowserTest, ShowsTheNumbersOfTheResult) {
  const Json result = Json::parse(ReadBytes(folder() / "out" / "result.json"));
  for (const auto& [name, parameter] : result["parameters"].items()) {
    const std::string shown =
        browser().Evaluate("document.querySelector('[data-parameter=\"" + name + "\"]').textContent");
    const double value = parameter["value"];
    EXPECT_NEAR(std::stod(shown), value, 1e-7 * value) << name;
  }
  EXPECT_NEAR(std::stod(Text("tile-rmse").get<std::string>()), 1e3 * result["rmse_m"].get<double>(), 1e-3);
  EXPECT_NEAR(std::stod(Text("tile-fit").get<std::string>()), result["fit_percent"].get<double>(), 1e-2);
  // The verdict leads, and its colour is that of what it says.
  EXPECT_EQ(result["usable"], "with care") << "the time step errs by more than the noise";
  EXPECT_EQ(Text("status"), "usable with care");
  EXPECT_EQ(Text("overall"), result["verdict"][0]);
  EXPECT_EQ(browser().Evaluate("document.getElementById('overall').className"), "overall warn");
  EXPECT_NE(
      Text("provenance").get<std::string>().find(result["provenance"]["input_sha256"].get<std::string>().substr(0, 64)),
      std::string::npos);
  // Every chart has been drawn: curves, and the image of the map.
  for (const char* id : {"per-frame", "histogram", "convergence"}) {
    EXPECT_GE(browser().Evaluate("document.querySelectorAll('#" + std::string(id) + " path.js-line').length"), 2) << id;
  }
  EXPECT_EQ(browser().Evaluate("document.querySelectorAll('#heat-map .hm image').length"), 1);
  ExpectPeace();
}

// The name of the recording is shown, not run.
TEST_F(ReportBrowserTest, NamesAreShown) {
  EXPECT_NE(Text("about").get<std::string>().find(kHostileName), std::string::npos);
  EXPECT_EQ(browser().Evaluate("document.querySelectorAll('img').length"), 0);
  EXPECT_NE(browser().Evaluate("document.title").get<std::string>().find(kHostileName), std::string::npos);
  ExpectPeace();
}

TEST_F(ReportBrowserTest, ReplaysTheMotion) {
  const Look first = LookAtReplay();
  EXPECT_GT(first.drawn, 0.1);
  EXPECT_GT(first.colours, 200);
  EXPECT_EQ(LookAtReplay().picture, first.picture) << "nothing moves by itself";

  browser().Click("play");
  EXPECT_EQ(Text("play"), "Pause");
  // What it shows by then is not looked at: on a busy machine it may be back at the start.
  browser().WaitUntil("state.frame > 3");
  browser().Click("play");
  EXPECT_EQ(Text("play"), "Play");
  const Json paused = browser().Evaluate("state.frame");
  browser().Evaluate("new Promise(done => setTimeout(done, 200))");
  EXPECT_EQ(browser().Evaluate("state.frame"), paused);

  browser().Click("scrubber");
  const int middle = browser().Evaluate("state.frame");
  EXPECT_NEAR(middle, 15, 1);
  EXPECT_EQ(Text("time").get<std::string>().rfind("0.1", 0), 0u) << Text("time");
  const Look halfway = LookAtReplay();
  EXPECT_NE(halfway.picture, first.picture);
  browser().Evaluate("showFrame(0)");
  EXPECT_EQ(LookAtReplay().picture, first.picture) << "the same frame, the same picture";
  ExpectPeace();
}

// Volumes of obstacles as they are drawn, with faces that look outward, in m^3.
constexpr char kVolumes[] = R"(state.replay.shapes.map(({positions, indices}) => {
  const point = (i) => [...positions.subarray(3 * i, 3 * i + 3)];
  let volume = 0;
  for (let i = 0; i < indices.length; i += 3) {
    volume += dot(point(indices[i]), cross(point(indices[i + 1]), point(indices[i + 2]))) / 6;
  }
  return volume;
}))";

TEST_F(ReportBrowserTest, DrawsEveryShapeInItsSize) {
  const auto ball = [](double radius) { return 4.0 / 3.0 * M_PI * std::pow(radius, 3); };
  const double r = 0.015, rim = 80.0 / 180.0 * M_PI;  // of the table's edges and of the bowl
  const double rim_from_axis = 0.085 * std::sin(rim) + 4.0 * 0.005 / (3.0 * M_PI) * std::cos(rim);
  const std::vector<double> expected = {
      ball(0.1),
      ball(0.03) + M_PI * 0.03 * 0.03 * 0.5,
      0.001,
      2.0 * r * 0.17 * 0.07 + M_PI * r * r * (0.17 + 0.07) + ball(r),
      M_PI * 0.05 * 0.05 * std::hypot(0.1, 0.1),
      2.0 * M_PI * M_PI * 0.1 * 0.03 * 0.03,
      0.5 * (ball(0.09) - ball(0.08)) * (1.0 - std::cos(rim)) + M_PI * M_PI * 0.005 * 0.005 * rim_from_axis,
      0.001 / 3.0};
  const std::vector<double> volumes = browser().Evaluate(kVolumes);
  ASSERT_EQ(volumes.size(), expected.size());
  for (std::size_t i = 0; i < volumes.size(); ++i) {
    EXPECT_NEAR(volumes[i] / expected[i], 1.0, 0.02) << i << ": of so many corners";
  }
}

TEST_F(ReportBrowserTest, LooksInEveryWay) {
  browser().Evaluate("showFrame(25)");
  std::set<std::string> pictures = {LookAtReplay().picture};
  const auto expect_new = [&](const std::string& what) {
    const Look look = LookAtReplay();
    EXPECT_GT(look.drawn, 0.05) << what;
    EXPECT_GT(look.colours, 200) << what;
    EXPECT_TRUE(pictures.insert(look.picture).second) << what;
  };
  browser().Click("error-colours");
  expect_new("error colours");
  EXPECT_EQ(browser().Evaluate("document.getElementById('scale').hidden"), false);
  const auto select = [&](const std::string& id, const std::string& value) {
    browser().Evaluate("(() => { const e = document.getElementById('" + id + "'); e.value = '" + value +
                       "'; e.dispatchEvent(new Event('change')); })()");
  };
  select("view", "side");
  expect_new("side by side");
  browser().Click("error-colours");
  expect_new("side by side without error colours");
  EXPECT_EQ(Text("label-right"), "predicted");

  select("recording", "1");
  browser().WaitUntil("state.replay && state.replay.points === 12");
  browser().Evaluate("showFrame(25)");
  expect_new("markers beside the cloth");
  select("view", "overlay");
  expect_new("markers on the cloth");
  browser().Click("error-colours");
  expect_new("error colours of markers");
  select("convergence-axis", "seconds");

  browser().Evaluate("viewer.turn(120, 40), viewer.zoom(0.8), redraw()");
  expect_new("turned");
  browser().Click("reset");
  EXPECT_FALSE(pictures.insert(LookAtReplay().picture).second) << "back where it was";
  ExpectPeace();
}

TEST_F(ReportBrowserTest, ShowsTheForceThatIsMissing) {
  const auto is_hidden = [&](const std::string& id) {
    return browser().Evaluate("document.getElementById('" + id + "').hidden");
  };
  EXPECT_EQ(is_hidden("force-colours-label"), true) << "nothing corrected these rollouts";
  browser().Evaluate(
      "(() => { const {replay} = state; part('force-colours-label').hidden = false; replay.largest_force = 2; "
      "replay.missingForce = "
      "Float32Array.from({length: replay.frames * replay.node_count}, (_, i) => 2 * (i % 64) / 63); })()");
  const Look before = LookAtReplay();
  browser().Click("force-colours");
  EXPECT_NE(LookAtReplay().picture, before.picture);
  EXPECT_EQ(is_hidden("scale"), false);
  EXPECT_EQ(Text("scale-end"), "2 N/m²");
  browser().Click("force-colours");
  EXPECT_EQ(LookAtReplay().picture, before.picture);
  ExpectPeace();
}

TEST_F(ReportBrowserTest, DrawsEstimatesAgainstTheirMemory) {
  const std::string card = "document.getElementById('memories-card')";
  EXPECT_EQ(browser().Evaluate(card + ".hidden"), true);
  browser().Evaluate(
      "(() => { const value = (v) => ({k_stretch: v, mu: null}); result.assimilation = {"
      "trials: [[0.02, 90], [0.06, 100]].map(([memory_s, v]) => ({memory_s, values: value(v), "
      "lower95: value(v - 5), upper95: value(v + 5)})), lead_times: [{lead_s: 0.1, rmse_m: 0.001, "
      "still_rmse_m: 0.02}, {lead_s: 0.2, rmse_m: 0.002, still_rmse_m: 0.03}]}; drawMemories(); })()");
  EXPECT_EQ(browser().Evaluate(card + ".hidden"), false);
  EXPECT_EQ(browser().Evaluate(card + ".querySelectorAll('.plot .main-svg').length > 0"), true);
  EXPECT_EQ(browser().Evaluate("document.querySelectorAll('#memories > .plot').length"), 3) << "and lead times";
  EXPECT_EQ(browser().Evaluate("document.querySelector('#memories .plot').data[1].error_y.array[0]"), 5);
  ExpectPeace();
}

// Seen from above and from below, a cloth is of its colour in the legend.
TEST_F(ReportBrowserTest, ClothHasTheColourOfTheLegend) {
  browser().Evaluate("(part('view').value = 'side', setLabels(), state.replay.obstacles = [], showFrame(5))");
  for (const double pitch : {1.2, -1.2}) {
    browser().Evaluate("(viewer.load(state.replay), viewer.turn(0, " + std::to_string((pitch - 0.32) / 0.008) +
                       "), redraw())");
    const std::string picture = LookAtReplay().picture;
    for (const std::string name : {"recorded", "predicted"}) {
      const Hue seen = HueIn(picture, name);
      EXPECT_GT(seen.share, 0.03) << name << " " << pitch;
      EXPECT_GT(seen.brightness, 0.8) << name << " " << pitch;
      EXPECT_LT(seen.brightness, 1.02) << name << " " << pitch;
    }
  }
  ExpectPeace();
}

TEST_F(ReportBrowserTest, SaysWhereTheStartIsLeftOut) {
  const std::string sentence = "Without the first frame, where the simulation starts.";
  EXPECT_EQ(Text("histogram-caption").get<std::string>().find(sentence), std::string::npos);
  browser().Evaluate("(data.recordings[0].histogram.leaves_out_start = true, drawHistogram(data.recordings[0]))");
  EXPECT_NE(Text("histogram-caption").get<std::string>().find(sentence), std::string::npos);
}

TEST_F(ReportBrowserTest, ShowsTheLandscape) {
  Scan();
  ASSERT_EQ(Run("identify --target markers.bin --fit mu,k_stretch --landscape cost --output map").exit_code, 0);
  browser().Open((folder() / "map" / "report.html").string(), "document.querySelector('#landscape-0 .contour path')");
  const std::string plot = "document.querySelector('#landscape-0 .plot')";
  const auto trace = [&](const std::string& name, const std::string& of) {
    return browser().Evaluate(plot + ".data.find(t => (t.name || t.type) === '" + name + "')." + of);
  };
  // Cells by value, the failed one as a mark and never as a number.
  EXPECT_EQ(trace("contour", "z.flat().filter(z => z === null).length"), 1);
  EXPECT_EQ(trace("contour", "z[0][0]"), Json());
  EXPECT_EQ(trace("failed", "x"), Json({0.05}));
  EXPECT_EQ(trace("failed", "y"), Json({30.0}));
  EXPECT_NE(trace("failed", "text[0]").get<std::string>().find("failed: &lt;b onclick=x&gt;step 3"), std::string::npos);
  const std::string caption = browser().Evaluate("document.querySelector('#landscape-0').textContent");
  EXPECT_NE(caption.find("1 of 16 cells failed"), std::string::npos) << caption;
  EXPECT_NE(caption.find("Lowest cell: "), std::string::npos) << caption;

  // The estimate with its intervals, the region around it, and the way there.
  const Json result = Json::parse(ReadBytes(folder() / "map" / "result.json"))["parameters"];
  EXPECT_EQ(trace("estimate", "x[0]"), result["mu"]["value"]);
  EXPECT_EQ(trace("estimate", "y[0]"), result["k_stretch"]["value"]);
  EXPECT_NEAR(trace("estimate", "error_x.array[0]"),
              result["mu"]["upper95"].get<double>() - result["mu"]["value"].get<double>(), 1e-12);
  EXPECT_GT(trace("95 % region", "x.length"), 30);
  EXPECT_EQ(trace("start", "x[0]"), result["mu"]["start"]);
  EXPECT_EQ(trace("way of the fit", "x.length"), browser().Evaluate("data.convergence.iteration.length"));

  // Axes as they were scanned, with units, and round marks.
  EXPECT_EQ(browser().Evaluate(plot + "._fullLayout.xaxis.type"), "linear");
  EXPECT_EQ(browser().Evaluate(plot + "._fullLayout.yaxis.type"), "log");
  EXPECT_EQ(browser().Evaluate(plot + "._fullLayout.yaxis.title.text"), "k_stretch, N/m");
  EXPECT_EQ(browser().Evaluate(plot + "._fullLayout.yaxis.ticktext.join()"), "50,100,200");
  EXPECT_EQ(trace("contour", "colorbar.title.text"), "rmse, mm");
  // The rmse of a cell is that of the fit, had it stayed there.
  const double lowest = browser().Evaluate("Math.min(..." + plot +
                                           ".data[0].text.flat().filter(t => t).map("
                                           "t => Number(/rmse ([^ ]*) mm/.exec(t)[1])))");
  const double estimate = 1e3 * browser().Evaluate("result.rmse_m").get<double>();
  EXPECT_GT(lowest, 0.999 * estimate);
  EXPECT_LT(lowest, 30.0 * estimate);
  const Look look = LookAt("landscape-0");
  EXPECT_GT(look.drawn, 0.2);
  EXPECT_GT(look.colours, 30);
  ExpectPeace();
}

// On the cloth, with a colour bar, hatched where it is not determined; on a phone, too.
TEST_F(ReportBrowserTest, ShowsTheField) {
  const ToolResult fit = Run("identify --target markers.bin --fit mu,k_stretch --field k_stretch:3x3 --output field");
  ASSERT_TRUE(fit.exit_code == 0 || fit.exit_code == 4) << fit.exit_code << fit.err;
  browser().Open((folder() / "field" / "report.html").string(), "document.querySelector('#field-0 .hm image')");
  const std::string plot = "document.querySelector('#field-0 .plot')";
  const Json result = Json::parse(ReadBytes(folder() / "field" / "result.json"))["fields"]["fields"]["k_stretch"];
  // Cells next to the corners of the cloth are nearly those control nodes.
  EXPECT_NEAR(browser().Evaluate("data.fields[0].value[0][0]").get<double>() / result["values"][0][0].get<double>(),
              1.0, 0.1);
  EXPECT_EQ(browser().Evaluate(plot + ".data[0].colorbar.title.text"), "k_stretch, N/m");
  const int undetermined = browser().Evaluate("data.fields[0].determined.flat().filter(d => d === 0).length");
  ASSERT_GT(undetermined, 0) << "12 markers do not tell nine stiffnesses";
  EXPECT_GT(browser().Evaluate(plot + ".data.find(t => t.name === 'not determined').x.length"), undetermined / 2);
  const std::string caption = browser().Evaluate("document.querySelector('#field-0').textContent");
  EXPECT_NE(caption.find("determined at "), std::string::npos) << caption;
  for (const int width : {400, 1400}) {
    browser().Resize(width, 900);
    WaitForCharts();
    EXPECT_EQ(browser().WhatStandsOut(), "") << width;
    // A square cloth is square.
    const std::string layout = plot + "._fullLayout", x = layout + ".xaxis._length", y = layout + ".yaxis._length";
    EXPECT_NEAR(browser().Evaluate(x + " / " + y), 1.0, 0.05) << width;
    EXPECT_GE(browser().Evaluate(x), 150) << width;
  }
  ExpectPeace();
}

}  // namespace
}  // namespace clothid::report_browser_test
