// report.html in a headless Chromium: clicks through it and looks at the picture.
#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <optional>
#include <set>
#include <stdexcept>
#include <string>
#include <vector>

#include "datasets/files/sha256.h"
#include "tests/identify/report/browser.h"
#include "tests/last_line.h"
#include "tests/tools/tool_test.h"

namespace clothid {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

// A name that would change the title of a page that runs it, and a first recording of every node in it; markers in a
// second, over every kind of obstacle.
constexpr char kHostileName[] = "<img src=x onerror=document.title=name>.bin";

class ReportBrowserTest : public ToolTest {
 protected:
  void SetUp() override {
    const std::optional<std::string> chromium = FindChromium();
    if (!chromium) GTEST_SKIP() << "the package chromium is absent: install it, or set CHROMIUM to another Chromium";
    WriteBytes(folder() / "pyramid.obj",
               "v -0.2 0 -0.45\nv -0.1 0 -0.45\nv -0.1 0.1 -0.45\nv -0.2 0.1 -0.45\nv -0.15 0.05 -0.35\n"
               "f 1 4 3 2\nf 1 2 5\nf 2 3 5\nf 3 4 5\nf 4 1 5\n");
    const std::string scene = WriteScene(nlohmann::ordered_json::parse(R"({
      "clothid_scene": 1, "time_step": 0.01, "duration": 0.3,
      "mesh": {"grid": {"nodes": [8, 8], "size": [0.3, 0.3]}}, "handles": [0, 1, 2, 3, 4, 5, 6, 7],
      "obstacles": [{"name": "ball", "type": "sphere", "center": [0.15, 0.2, -0.12], "radius": 0.1, "mu": 0.5},
                    {"type": "plane", "point": [0, 0, -0.5], "normal": [0, 0, 1]},
                    {"type": "capsule", "from": [-0.1, 0.4, -0.4], "to": [0.4, 0.4, -0.4], "radius": 0.03},
                    {"type": "mesh", "obj": "pyramid.obj"}],
      "materials": {"density": 0.2, "k_stretch": 50, "k_bend": 2e-3, "drag": 0.1},
      "solver": {"step_tolerance": 1e-6}})"));
    const std::string simulate = "simulate --scene " + scene + " --set mu=0.2,k_stretch=120 --noise 0.002 ";
    ASSERT_EQ(Run(simulate + "--seed 1 --output '" + kHostileName + "'").exit_code, 0);
    ASSERT_EQ(Run(simulate + "--seed 2 --markers 12 --drop 0.1 --output markers.bin").exit_code, 0);
    ASSERT_EQ(Run("identify --target '" + std::string(kHostileName) + ",markers.bin' --output out").exit_code, 0);
    try {
      browser_ = std::make_unique<Browser>(*chromium, 1200, 900);
    } catch (const std::runtime_error&) {
      const ToolResult alone = Run("'" + *chromium + "' --headless=new --no-sandbox --dump-dom about:blank");
      if (alone.exit_code == 0) throw;
      GTEST_SKIP() << "the package chromium is damaged: '" << *chromium << "' ends with: " << LastLine(alone.err);
    }
    browser_->Open((folder() / "out" / "report.html").string(), "state.replay && state.replay.frames == 31");
  }

  Browser& browser() { return *browser_; }
  Json Text(const std::string& id) { return browser_->Evaluate("document.getElementById('" + id + "').textContent"); }

  // What the screen shows of an element: pixels that differ from the one in a corner, and their number of colours.
  struct Look {
    double drawn = 0.0;  // share of the pixels
    int colours = 0;
    std::string picture;
  };
  Look LookAtReplay() { return LookAt("canvas"); }
  Look LookAt(const std::string& id) {
    // Two frames of the browser later, all that was asked for has been drawn.
    browser_->Evaluate("new Promise(done => requestAnimationFrame(() => requestAnimationFrame(done)))");
    Look look;
    look.picture = browser_->Picture(id);
    const Json counts = browser_->Evaluate(
        "(async () => { const image = new Image(); image.src = 'data:image/png;base64," + look.picture +
        "'; await image.decode(); const canvas = document.createElement('canvas'); canvas.width = image.width; "
        "canvas.height = image.height; const context = canvas.getContext('2d'); context.drawImage(image, 0, 0); "
        "const all = new Uint32Array(context.getImageData(0, 0, image.width, image.height).data.buffer); "
        "return [all.filter(pixel => pixel !== all[all.length - 1]).length / all.length, new Set(all).size]; })()");
    look.drawn = counts[0];
    look.colours = counts[1];
    return look;
  }

  // `landscape` of the markers, with one cell as if its rollout had failed.
  void Scan() {
    ASSERT_EQ(
        Run("landscape --target markers.bin --x mu=0.05:0.6:4 --y k_stretch=30:480:4:log --output cost").exit_code, 0);
    const fs::path csv = folder() / "cost" / "landscape.csv", plan = folder() / "cost" / "plan.json";
    std::string cells = ReadBytes(csv), text = ReadBytes(plan);
    const std::string before = Sha256Hex({cells});
    const std::size_t row = cells.find('\n') + 1, end = cells.find('\n', row), cost = cells.find("gap,", row) + 4;
    cells.insert(end, "\"<b onclick=x>step 3\"");
    cells.erase(cost, cells.find(',', cost) - cost);
    WriteBytes(csv, cells);
    WriteBytes(plan, text.replace(text.find(before), before.size(), Sha256Hex({cells})));
  }

  void ExpectPeace() {
    EXPECT_EQ(browser_->complaints(), std::vector<std::string>());
    EXPECT_EQ(browser_->requests(), std::vector<std::string>());
  }

 private:
  std::unique_ptr<Browser> browser_;
};

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
  EXPECT_EQ(Text("status"), "fitted");
  EXPECT_EQ(Text("verdict"), result["verdict"][0]);
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
  browser().WaitUntil("state.frame > 3");
  EXPECT_NE(LookAtReplay().picture, first.picture);
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

}  // namespace
}  // namespace clothid
