// The pages of `motion view` in a headless Chromium: a scene, a capture, point clouds, a tensile test, wind.
#include <gtest/gtest.h>

#include <limits>
#include <set>
#include <string>
#include <utility>

#include "datasets/motion/motion_file.h"
#include "identify/report/report_page.h"
#include "tests/identify/report/page_browser.h"

namespace clothid::view_browser_test {
namespace {

const std::string kDatasets = CLOTHID_SOURCE_DIR "/datasets/";

class ViewBrowserTest : public PageBrowserTest {
 protected:
  // The page of a file, opened.
  void View(const std::string& file) {
    ASSERT_EQ(Run("motion view '" + file + "'").exit_code, 0);
    EXPECT_LT(std::filesystem::file_size(folder() / "view.html"), kMaxReportBytes);
    Open("view.html");
  }
  void Open(const std::string& page) { browser().Open((folder() / page).string(), "state.replay"); }

  // What a laboratory brings, with two frames whose points are in another order.
  void ConvertCapture() const {
    const std::string folder = kDatasets + "capture/";
    ExpectSuccess("motion convert " + folder + "points.npy capture.bin --scene " + folder + "scene.json --transform " +
                  folder +
                  "camera.json --start_at 0 --handle_nodes 0,15,30,45,60,75,90,105,120,135,150,165,180,195,210 " +
                  "--handles " + folder + "gripper.csv --handle_time_offset 0.75");
  }

  int Frame() { return browser().Evaluate("state.frame"); }

  // Clicks on a button of the page, and where the replay is then.
  int FrameBehind(const std::string& label) {
    browser().Evaluate("[...document.querySelectorAll('#findings button')].find(made => made.textContent === '" +
                       label + "').id = 'wanted'");
    browser().Click("wanted");
    browser().Evaluate("document.getElementById('wanted').removeAttribute('id')");
    return Frame();
  }

  void ExpectDrawn(const std::string& what, double least_drawn = 0.05, int least_colours = 100) {
    const Look look = LookAt("canvas");
    EXPECT_GT(look.drawn, least_drawn) << what;
    EXPECT_GT(look.colours, least_colours) << what;
    EXPECT_TRUE(pictures_.insert(look.picture).second) << what << ": as before";
  }

 private:
  std::set<std::string> pictures_;
};

TEST_F(ViewBrowserTest, ASceneIsSimulatedAndPlayed) {
  View(kDatasets + "drape.scene.json");
  EXPECT_EQ(Text("heading"), "Scene");
  EXPECT_EQ(Text("status"), "ok");
  EXPECT_NE(Text("facts").get<std::string>().find("ball (mu 0.57)"), std::string::npos) << Text("facts");
  ExpectDrawn("the start", 0.1, 200);
  browser().Click("play");
  browser().WaitUntil("state.frame > 10");
  browser().Click("play");
  ExpectDrawn("in motion", 0.1, 200);
  // The forces at its handles, with a mark that goes along.
  EXPECT_EQ(browser().Evaluate("document.querySelectorAll('#forces .curve').length"), 3);
  const std::string mark = "Number(document.querySelector('#forces .mark').getAttribute('x1'))";
  const double before = browser().Evaluate(mark);
  browser().Evaluate("showFrame(80)");
  EXPECT_GT(browser().Evaluate(mark).get<double>(), before + 50.0);
  browser().Click("forces");
  EXPECT_NEAR(Frame(), 40, 6);
  browser().Click("start");
  ExpectDrawn("the start of a simulation beside it", 0.1, 200);
  ExpectPeace();
}

TEST_F(ViewBrowserTest, FindingsLeadToTheirFrames) {
  ConvertCapture();
  View("capture.bin");
  EXPECT_EQ(Text("status"), "1 warning");
  EXPECT_EQ(Frame(), 0);
  ExpectDrawn("the first frame");
  EXPECT_EQ(FrameBehind("frames 21 to 22"), 21);
  EXPECT_EQ(Text("time"), "2.740 s, frame 21 (0 to 25)");
  EXPECT_EQ(Text("seen"), "1 of 225 points not seen");
  ExpectDrawn("points in another order");
  EXPECT_EQ(FrameBehind("frame 18"), 18);
  EXPECT_EQ(Text("seen"), "all points seen");
  ExpectDrawn("before the gap");
  // Every finding that names frames has a row below the slider; the end of it is the last frame.
  EXPECT_EQ(browser().Evaluate("document.querySelectorAll('#timeline g').length"), 3);
  browser().Evaluate(
      "(() => { const b = document.querySelector('#timeline svg').getBoundingClientRect(); "
      "document.querySelector('#timeline svg').dispatchEvent(new MouseEvent('click', {clientX: b.right - 1})); })()");
  EXPECT_EQ(Frame(), 25);
  browser().Open((folder() / "view.html#frame=7").string(), "state.replay && state.frame === 7");
  ExpectPeace();
}

// Other points in every frame, and not as many.
TEST_F(ViewBrowserTest, CloudsAreDrawn) {
  ExpectSuccess("simulate --scene " + kDatasets + "slope.scene.json --cloud 400 --drop 0.1 --output cloud.bin");
  View("cloud.bin");
  const std::string seen = Text("seen");
  EXPECT_NE(seen.find(" points in the cloud"), std::string::npos) << seen;
  ExpectDrawn("a cloud over the start of a simulation", 0.02, 20);
  browser().Evaluate("jumpTo(31)");
  ExpectDrawn("another cloud", 0.02, 20);
  EXPECT_NE(Text("seen"), seen);
  ExpectPeace();
}

// Clamps and a gauge, and no point of the cloth.
TEST_F(ViewBrowserTest, ATensileTestIsDrawn) {
  Json scene = Json::parse(R"({"clothid_scene": 1, "time_step": 0.01, "duration": 0.5, "gravity": [0, 0, -9.81],
    "mesh": {"grid": {"nodes": [5, 5], "size": [0.07, 0.07], "axes": [[1, 0, 0], [0, 0, 1]]}},
    "initial": {"positions": "rest"}, "handles": {"nodes": [0, 1, 2, 3, 4, 20, 21, 22, 23, 24], "path": "clamps.csv"},
    "materials": {"density": 0.3, "k_stretch": 100}})");
  std::string path = "time", first = "0", last = "0.5";
  for (int i = 0; i < 10; ++i) {
    const std::string k = std::to_string(i), x = std::to_string(0.0175 * (i % 5));
    path += ",x" + k + ",y" + k + ",z" + k;
    first += "," + x + (i < 5 ? ",0,0" : ",0,0.07");
    last += "," + x + (i < 5 ? ",0,0" : ",0,0.08");
  }
  WriteBytes(folder() / "clamps.csv", path + "\n" + first + "\n" + last + "\n");
  WriteBytes(folder() / "clamps.json", scene.dump());
  ExpectSuccess("simulate --scene clamps.json --forces --output tensile.bin");
  MotionTensors tensors = ReadMotionTensors((folder() / "tensile.bin").string());
  tensors.positions.setConstant(std::numeric_limits<double>::quiet_NaN());
  WriteMotion(tensors, (folder() / "tensile.bin").string());
  View("tensile.bin");
  EXPECT_EQ(Text("seen"), "25 of 25 points not seen");
  EXPECT_EQ(browser().Evaluate("part('start').checked"), true) << "else there would be nothing but handles";
  ExpectDrawn("the start between the clamps", 0.01, 10);
  browser().Evaluate("jumpTo(50)");
  ExpectDrawn("clamps that have moved", 0.01, 10);
  EXPECT_EQ(browser().Evaluate("document.querySelectorAll('#forces .curve').length"), 3);
  ExpectPeace();
}

TEST_F(ViewBrowserTest, WindIsDrawn) {
  ASSERT_EQ(Run("simulate --scene " + kDatasets +
                "wind.scene.json --noise 0.001 --drop 0.05 --output wind.bin --view "
                "page.html")
                .exit_code,
            0);
  ASSERT_EQ(Run("motion view wind.bin").exit_code, 0);
  Open("page.html");
  EXPECT_EQ(Text("heading"), "Recording");
  EXPECT_EQ(browser().Evaluate("document.querySelectorAll('#wind .curve').length"), 3);
  browser().Evaluate("jumpTo(30)");
  ExpectDrawn("with wind");
  const std::string picture = LookAt("canvas").picture;
  browser().Evaluate("(state.replay.wind = undefined, redraw())");
  ExpectDrawn("without its cone");
  browser().Evaluate("(state.replay.wind = data.wind, redraw())");
  EXPECT_EQ(LookAt("canvas").picture, picture);
  ExpectPeace();
}

TEST_F(ViewBrowserTest, FitsEveryWindowAndNotebooks) {
  ConvertCapture();
  const std::string converted = (folder() / "capture.bin").string();
  for (const std::string& file : {converted, kDatasets + "wind.scene.json"}) {
    View(file);
    for (const int width : {400, 700, 1000, 1400}) {
      browser().Resize(width, 900);
      EXPECT_EQ(browser().WhatStandsOut(), "") << file << " " << width;
    }
    browser().Resize(400, 900);
    EXPECT_EQ(browser().WhatIsTooSmall(), "") << file;
  }
  std::string page = ReadBytes(folder() / "view.html"), escaped;
  for (const char letter : page) escaped += letter == '"' ? "&quot;" : letter == '&' ? "&amp;" : std::string(1, letter);
  WriteBytes(folder() / "notebook.html", "<!DOCTYPE html><meta charset=\"utf-8\"><iframe srcdoc=\"" + escaped +
                                             "\" style=\"width: 100%; height: 700px\"></iframe>");
  browser().Open((folder() / "notebook.html").string(),
                 "frames[0].document.getElementById('time').textContent.includes('frame 0')");
  ExpectPeace();
}

}  // namespace
}  // namespace clothid::view_browser_test
