// Pages that our programs write, opened in a headless Chromium. Without one the tests are skipped.
#ifndef CLOTHID_TESTS_IDENTIFY_REPORT_PAGE_BROWSER_H_
#define CLOTHID_TESTS_IDENTIFY_REPORT_PAGE_BROWSER_H_

#include <gtest/gtest.h>

#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "tests/identify/report/browser.h"
#include "tests/last_line.h"
#include "tests/tools/tool_test.h"

namespace clothid {

class PageBrowserTest : public ToolTest {
 protected:
  using Json = nlohmann::json;

  void SetUp() override {
    const std::optional<std::string> chromium = FindChromium();
    if (!chromium) GTEST_SKIP() << "the package chromium is absent: install it, or set CHROMIUM to another Chromium";
    try {
      if (!browser_) browser_ = std::make_unique<Browser>(*chromium);
      browser_->OpenPage(900, 700);
    } catch (const std::runtime_error&) {
      const ToolResult alone = Run("'" + *chromium + "' --headless=new --no-sandbox --dump-dom about:blank");
      if (alone.exit_code == 0) throw;
      GTEST_SKIP() << "the package chromium is damaged: '" << *chromium << "' ends with: " << LastLine(alone.err);
    }
  }

  static void TearDownTestSuite() { browser_.reset(); }

  Browser& browser() { return *browser_; }
  Json Text(const std::string& id) { return browser_->Evaluate("document.getElementById('" + id + "').textContent"); }

  // What the screen shows of an element: pixels that differ from the one in a corner, and their number of colours.
  struct Look {
    double drawn = 0.0;  // share of the pixels
    int colours = 0;
    std::string picture;
  };

  // Charts follow the width of the window a moment later.
  void WaitForCharts() {
    browser_->WaitUntil(
        "[...document.querySelectorAll('.js-plotly-plot')].every(p => Math.abs(p._fullLayout.width - p.clientWidth) < "
        "1)");
  }

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

  void ExpectPeace() {
    EXPECT_EQ(browser_->complaints(), std::vector<std::string>());
    EXPECT_EQ(browser_->requests(), std::vector<std::string>());
  }

 private:
  inline static std::unique_ptr<Browser> browser_;  // of all cases of a suite, with a page for each
};

}  // namespace clothid

#endif  // CLOTHID_TESTS_IDENTIFY_REPORT_PAGE_BROWSER_H_
