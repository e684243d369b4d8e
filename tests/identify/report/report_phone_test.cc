// report.html in windows of every width, and under fingers.
#include <gtest/gtest.h>

#include <cmath>
#include <set>
#include <string>

#include "tests/identify/report/report_browser.h"

namespace clothid::report_phone_test {
namespace {

using ReportPhoneTest = ReportBrowserTest;

TEST_F(ReportPhoneTest, FitsEveryWindow) {
  Scan();
  ASSERT_EQ(
      Run("identify --target markers.bin --fit mu,k_stretch --profile mu --starts 2 --landscape cost --output map")
          .exit_code,
      0);
  const std::string page = (folder() / "map" / "report.html").string();
  browser().Open(page, "state.replay && document.querySelector('#landscape-0 .contour path')");
  for (const int width : {400, 700, 1000, 1400}) {
    browser().Resize(width, 900);
    WaitForCharts();
    EXPECT_EQ(browser().WhatStandsOut(), "") << width;
    const std::string plots = "[...document.querySelectorAll('.plot .main-svg')].map(svg => svg.parentNode.parentNode)";
    EXPECT_EQ(browser().Evaluate(plots + ".filter(p => p.clientWidth > p.closest('.card').clientWidth).length"), 0);
  }
  browser().Resize(400, 900);
  EXPECT_EQ(browser().WhatIsTooSmall(), "");
  // Each estimate says beside itself what it is.
  EXPECT_EQ(browser().Evaluate("getComputedStyle(document.querySelector('.estimate'), '::before').content"),
            "\"estimate\"");
  // The colour bars leave the maps their width.
  EXPECT_EQ(browser().Evaluate("document.querySelector('#landscape-0 .plot').data[0].colorbar.orientation"), "h");
  EXPECT_EQ(browser().Evaluate("document.getElementById('heat-map').data[0].colorbar.orientation"), "h");
  browser().Resize(1400, 900);
  browser().WaitUntil("document.getElementById('heat-map').data[0].colorbar.orientation !== 'h'");
  ExpectPeace();
}

TEST_F(ReportPhoneTest, FingersTurnMoveAndZoom) {
  EXPECT_EQ(Text("replay-hint"), "Drag to turn, shift and drag to move, wheel to zoom.");
  browser().UseFingers();
  browser().Resize(400, 900);
  const std::string page = (folder() / "out" / "report.html").string();
  browser().Open(page, "state.replay && state.replay.frames == 31");
  EXPECT_EQ(Text("replay-hint"), "One finger turns, two fingers move and zoom.");
  browser().Evaluate("document.getElementById('stage').scrollIntoView({block: 'center'})");
  const Json box =
      browser().Evaluate("(() => { const b = part('stage').getBoundingClientRect(); return [b.left, b.top]; })()");
  const double x = box[0], y = box[1];
  const auto at = [&](double dx, double dy) { return Json::array({x + dx, y + dy}); };
  browser().Evaluate(
      "(() => { window.did = {turn: [0, 0], move: [0, 0], zoom: 1}; const {turn, move, zoom} = viewer; "
      "viewer.turn = (x, y) => { did.turn[0] += x; did.turn[1] += y; turn(x, y); }; "
      "viewer.move = (x, y) => { did.move[0] += x; did.move[1] += y; move(x, y); }; "
      "viewer.zoom = (factor) => { did.zoom *= factor; zoom(factor); }; })()");
  std::set<std::string> pictures = {LookAtReplay().picture};
  const auto expect_did = [&](const Json& expected) {
    const Json did = browser().Evaluate("did");
    for (const auto& [what, amount] : expected.items()) {
      EXPECT_LT((amount.is_array() ? std::hypot(amount[0].get<double>() - did[what][0].get<double>(),
                                                amount[1].get<double>() - did[what][1].get<double>())
                                   : std::abs(amount.get<double>() - did[what].get<double>())),
                1e-3)
          << what << ": " << did;
    }
    EXPECT_TRUE(pictures.insert(LookAtReplay().picture).second) << did;
  };
  browser().Touch({Json::array({at(150, 150)}), Json::array({at(180, 160)}), Json::array({at(200, 170)})});
  expect_did({{"turn", {50, 20}}, {"move", {0, 0}}, {"zoom", 1}});
  // Apart: nearer.
  browser().Touch({Json::array({at(150, 150), at(200, 150)}), Json::array({at(125, 150), at(225, 150)})});
  expect_did({{"turn", {50, 20}}, {"move", {0, 0}}, {"zoom", 0.5}});
  browser().Touch({Json::array({at(100, 150), at(150, 150)}), Json::array({at(110, 190), at(160, 190)})});
  expect_did({{"turn", {50, 20}}, {"move", {10, 40}}, {"zoom", 0.5}});
  // Elsewhere a finger scrolls: charts do not hold it.
  EXPECT_EQ(browser().Evaluate("part('per-frame')._fullLayout.dragmode"), false);
  ExpectPeace();
}

}  // namespace
}  // namespace clothid::report_phone_test
