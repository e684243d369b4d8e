// card.html in a headless Chromium.
#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "tests/identify/report/page_browser.h"

namespace clothid::card_browser_test {
namespace {

class CardBrowserTest : public PageBrowserTest {};

TEST_F(CardBrowserTest, ShowsConstantsAndTheCurveThatToldThem) {
  std::string curve = "Width;50;mm\nGauge length;200;mm\n\nExtension;Force\nmm;N\n";
  for (int i = 0; i <= 50; ++i) {
    curve += std::to_string(0.8 * i) + ";" + std::to_string(std::expm1(0.016 * i) + 0.002 * std::sin(31.0 * i)) + "\n";
  }
  WriteBytes(folder() / "curve.csv", curve);
  ASSERT_EQ(Run("motion convert_curve curve.csv curve.bin --direction weft").exit_code, 0);
  ASSERT_EQ(Run("identify --target curve.bin --fit k_weft,stiffening_weft --output r").exit_code, 0);
  browser().Open((folder() / "r/card.html").string(), "document.querySelector('#curves svg')");
  const std::string constants = Text("constants"), recordings = Text("recordings");
  const Json card = Json::parse(ReadBytes(folder() / "r/fabric.json"));
  for (const auto& [name, constant] : card["constants"].items()) {
    EXPECT_NE(constants.find(name), std::string::npos) << name << " in: " << constants;
  }
  EXPECT_NE(constants.find("strain 0"), std::string::npos) << constants;
  EXPECT_NE(recordings.find("tensile curve81 nodes"), std::string::npos) << recordings;
  EXPECT_EQ(browser().Evaluate("document.querySelectorAll('#curves path.curve').length"), 2);
  EXPECT_NE(Text("curves").get<std::string>().find("force fitted: "), std::string::npos) << Text("curves");
  EXPECT_GT(LookAt("curves").drawn, 0.001);
}

}  // namespace
}  // namespace clothid::card_browser_test
