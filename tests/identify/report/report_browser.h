// report.html of a fit of two recordings, opened in a headless Chromium.
#ifndef CLOTHID_TESTS_IDENTIFY_REPORT_REPORT_BROWSER_H_
#define CLOTHID_TESTS_IDENTIFY_REPORT_REPORT_BROWSER_H_

#include <gtest/gtest.h>

#include <memory>
#include <optional>
#include <stdexcept>
#include <string>

#include "datasets/files/sha256.h"
#include "tests/identify/report/browser.h"
#include "tests/last_line.h"
#include "tests/tools/tool_test.h"

namespace clothid {

// A name that would change the title of a page that runs it, and a first recording of every node in it; markers in a
// second, over every kind of obstacle.
inline constexpr char kHostileName[] = "<img src=x onerror=document.title=name>.bin";

class ReportBrowserTest : public ToolTest {
 protected:
  using Json = nlohmann::json;

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
    browser_->WaitForFrames();
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

  // The pixels of a picture that have the hue of `name` in the legend, and how bright their median is beside it.
  struct Hue {
    double share = 0.0, brightness = 0.0;
  };
  Hue HueIn(const std::string& picture, const std::string& name) {
    const Json found = browser_->Evaluate(
        "(async () => { const image = new Image(); image.src = 'data:image/png;base64," + picture +
        "'; await image.decode(); const canvas = document.createElement('canvas'); canvas.width = image.width; "
        "canvas.height = image.height; const context = canvas.getContext('2d'); context.drawImage(image, 0, 0); "
        "const wanted = legendColour('" +
        name +
        "').map(v => 255 * v), total = wanted[0] + wanted[1] + wanted[2]; "
        "const {data: all} = context.getImageData(0, 0, image.width, image.height), bright = []; "
        "for (let i = 0; i < all.length; i += 4) { const scale = (all[i] + all[i + 1] + all[i + 2]) / total; "
        "if ([0, 1, 2].every(k => Math.abs(all[i + k] - scale * wanted[k]) < 12)) bright.push(scale); } "
        "bright.sort((a, b) => a - b); return [4 * bright.length / all.length, bright[bright.length >> 1] || 0]; })()");
    return {found[0], found[1]};
  }

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

  void ExpectPeace() {
    EXPECT_EQ(browser_->complaints(), std::vector<std::string>());
    EXPECT_EQ(browser_->requests(), std::vector<std::string>());
  }

 private:
  std::unique_ptr<Browser> browser_;
};

}  // namespace clothid

#endif  // CLOTHID_TESTS_IDENTIFY_REPORT_REPORT_BROWSER_H_
