// report.html of a fit of two recordings, opened in a headless Chromium.
#ifndef CLOTHID_TESTS_IDENTIFY_REPORT_REPORT_BROWSER_H_
#define CLOTHID_TESTS_IDENTIFY_REPORT_REPORT_BROWSER_H_

#include <gtest/gtest.h>

#include <filesystem>
#include <memory>
#include <string>

#include "datasets/files/sha256.h"
#include "tests/identify/report/page_browser.h"

namespace clothid {

// A name that would change the title of a page that runs it, and a first recording of every node in it; markers in a
// second, over every kind of obstacle.
inline constexpr char kHostileName[] = "<img src=x onerror=document.title=name>.bin";

class ReportBrowserTest : public PageBrowserTest {
 protected:
  void SetUp() override {
    PageBrowserTest::SetUp();
    if (IsSkipped()) return;
    if (!made_) MakeReport();
    if (HasFatalFailure()) return;
    std::filesystem::copy(made_->path(), folder(), std::filesystem::copy_options::recursive);
    browser().Open((folder() / "out" / "report.html").string(), "state.replay && state.replay.frames == 31");
  }
  static void TearDownTestSuite() {
    made_.reset();
    PageBrowserTest::TearDownTestSuite();
  }

  // The recordings and their report, once for all cases of a suite.
  void MakeReport() {
    WriteBytes(folder() / "pyramid.obj",
               "v -0.2 0 -0.45\nv -0.1 0 -0.45\nv -0.1 0.1 -0.45\nv -0.2 0.1 -0.45\nv -0.15 0.05 -0.35\n"
               "f 1 4 3 2\nf 1 2 5\nf 2 3 5\nf 3 4 5\nf 4 1 5\n");
    const std::string scene = WriteScene(nlohmann::ordered_json::parse(R"({
      "clothid_scene": 1, "time_step": 0.01, "duration": 0.3,
      "mesh": {"grid": {"nodes": [8, 8], "size": [0.3, 0.3]}}, "handles": [0, 1, 2, 3, 4, 5, 6, 7],
      "obstacles": [{"name": "ball", "type": "sphere", "center": [0.15, 0.2, -0.12], "radius": 0.1, "mu": 0.5},
                    {"type": "plane", "point": [0, 0, -0.5], "normal": [0, 0, 1]},
                    {"type": "capsule", "from": [-0.1, 0.4, -0.4], "to": [0.4, 0.4, -0.4], "radius": 0.03},
                    {"type": "box", "center": [0, 0.5, -0.4], "size": [0.1, 0.1, 0.1], "rotation": [0, 0, 1, 2]},
                    {"type": "table", "center": [0.4, 0.4, -0.4], "normal": [0, 0, 1], "size": [0.2, 0.1],
                     "thickness": 0.03},
                    {"type": "cylinder", "from": [0.4, 0, -0.5], "to": [0.4, 0.1, -0.4], "radius": 0.05},
                    {"type": "torus", "center": [0.4, 0.2, -0.4], "axis": [0.2, 0, 1], "radius": 0.1,
                     "tube_radius": 0.03},
                    {"type": "bowl", "center": [-0.2, 0.3, -0.3], "axis": [0.2, 0, 1], "radius": 0.08, "angle": 80,
                     "thickness": 0.01},
                    {"type": "mesh", "obj": "pyramid.obj"}],
      "materials": {"density": 0.2, "k_stretch": 50, "k_bend": 2e-3, "drag": 0.1},
      "solver": {"step_tolerance": 1e-6}})"));
    const std::string simulate = "simulate --scene " + scene + " --set mu=0.2,k_stretch=120 --noise 0.002 ";
    ASSERT_EQ(Run(simulate + "--seed 1 --output '" + kHostileName + "'").exit_code, 0);
    ASSERT_EQ(Run(simulate + "--seed 2 --markers 12 --drop 0.1 --output markers.bin").exit_code, 0);
    ASSERT_EQ(Run("identify --target '" + std::string(kHostileName) + ",markers.bin' --output out").exit_code, 0);
    made_ = std::make_unique<TemporaryFolder>();
    std::filesystem::remove(made_->path());
    std::filesystem::rename(folder(), made_->path());
    std::filesystem::create_directory(folder());
  }

  Look LookAtReplay() { return LookAt("canvas"); }

  // `landscape` of the markers, with one cell as if its rollout had failed.
  void Scan() {
    ASSERT_EQ(
        Run("landscape --target markers.bin --x mu=0.05:0.6:4 --y k_stretch=30:480:4:log --output cost").exit_code, 0);
    const std::filesystem::path csv = folder() / "cost" / "landscape.csv", plan = folder() / "cost" / "plan.json";
    std::string cells = ReadBytes(csv), text = ReadBytes(plan);
    const std::string before = Sha256Hex({cells});
    const std::size_t row = cells.find('\n') + 1, end = cells.find('\n', row), cost = cells.find("gap,", row) + 4;
    cells.insert(end, "\"<b onclick=x>step 3\"");
    cells.erase(cost, cells.find(',', cost) - cost);
    WriteBytes(csv, cells);
    WriteBytes(plan, text.replace(text.find(before), before.size(), Sha256Hex({cells})));
  }

 private:
  inline static std::unique_ptr<TemporaryFolder> made_;
};

}  // namespace clothid

#endif  // CLOTHID_TESTS_IDENTIFY_REPORT_REPORT_BROWSER_H_
