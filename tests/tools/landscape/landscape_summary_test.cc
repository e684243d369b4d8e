// The summary of a landscape that is known.
#include "tools/landscape/landscape_summary.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <string>

#include "tests/tools/landscape/bumpy_landscape.h"

namespace clothid::landscape_summary_test {
namespace {

TEST(LandscapeSummary, NumbersOfAWindow) {
  const Landscape landscape = BumpyLandscape({"a", "b"}, {1.0, 0.1}, 21);
  const LandscapeSummary summary = Summarize(landscape);
  ASSERT_EQ(summary.windows.size(), 8u);
  const WindowSummary& window = summary.Of(3, 1);  // "b" in gap mode, zoomed
  EXPECT_DOUBLE_EQ(window.minimum, 0.5);
  EXPECT_DOUBLE_EQ(window.x, kBumpyMu);
  EXPECT_NEAR(window.y, kBumpyStretch, 1e-10);
  EXPECT_LT(window.roughness.off_quadratic, 1e-12);
  EXPECT_LT(window.roughness.gradient_gap, 1e-9);
  EXPECT_EQ(window.contact.nodes_joined, 30.0);
  EXPECT_EQ(window.contact.nodes_left, 27.0);
  EXPECT_EQ(window.contact.branch_switches, 15.0);
  EXPECT_EQ(window.contact.contact_changes, 72.0);
  EXPECT_EQ(window.contact.obstacle_switches, 0.0);
  EXPECT_EQ(window.contact.contacts_per_step, 2.0);
  // The bumps have the same height in both windows of one setting, the bowl has not.
  EXPECT_GT(summary.Of(2, 1).roughness.off_quadratic, 10.0 * summary.Of(2, 0).roughness.off_quadratic);
}

// Failed rollouts count as failures and nowhere else.
TEST(LandscapeSummary, FailedCells) {
  Landscape landscape = BumpyLandscape({"a"}, {1.0}, 5);
  const int first = landscape.plan.FirstCell(1, 0);
  FailCell(first + 12, "step 3 did not converge", &landscape);  // the lowest one
  landscape.cells[first].counts.substeps = 100;
  landscape.cells[first].counts.obstacle_switches = 48;
  const WindowSummary window = Summarize(landscape).Of(1, 0);
  EXPECT_EQ(window.roughness.failed_cells, 1);
  EXPECT_EQ(window.failed_steps, 1);
  EXPECT_EQ(window.substeps, 100);
  EXPECT_GT(window.minimum, 0.5);
  EXPECT_EQ(window.contact.contact_changes, 24.0);
  EXPECT_EQ(window.contact.obstacle_switches, 2.0);              // 48 in 24 rollouts
  EXPECT_EQ(window.contact.contacts_per_step, 4800.0 / 2500.0);  // of 24 * 100 steps and the substeps
}

TEST(LandscapeSummary, NothingButFailures) {
  Landscape landscape = BumpyLandscape({"a"}, {1.0}, 3);
  for (int i = 0; i < landscape.plan.num_cells(); ++i) FailCell(i, "no", &landscape);
  const LandscapeSummary summary = Summarize(landscape);
  EXPECT_TRUE(std::isnan(summary.Of(0, 0).minimum));
  EXPECT_TRUE(std::isnan(summary.Of(0, 0).contact.contact_changes));
  const nlohmann::json window = nlohmann::json::parse(SummaryJson(summary))["settings"][0]["windows"][0];
  EXPECT_TRUE(window["minimum"]["cost"].is_null());
  EXPECT_TRUE(window["range"].is_null());
  EXPECT_TRUE(window["per_rollout"]["contact_changes"].is_null());
  EXPECT_EQ(window["roughness"]["missing"], "every cell failed");
  EXPECT_EQ(window["failed_cells"], 9);
  EXPECT_NE(SummaryTable(summary).find("a, velocity, zoom 1: every cell failed\n"), std::string::npos);
}

TEST(LandscapeSummary, JsonHoldsEverything) {
  const Landscape landscape = BumpyLandscape({"", "\"<b>\xff"}, {1.0, 0.1}, 9);
  const LandscapeSummary summary = Summarize(landscape);
  const nlohmann::json json = nlohmann::json::parse(SummaryJson(summary));
  EXPECT_EQ(json["schema"], "clothid.landscape_summary/1");
  EXPECT_EQ(json["x"], nlohmann::json::parse(R"({"parameter": "mu", "scale": "linear", "cells": 9})"));
  EXPECT_EQ(json["y"], nlohmann::json::parse(R"({"parameter": "k_stretch", "scale": "log", "cells": 9})"));
  ASSERT_EQ(json["settings"].size(), 4u);
  EXPECT_EQ(json["settings"][3]["name"], "\"<b>\xEF\xBF\xBD");  // what is no UTF-8 becomes a replacement character
  EXPECT_EQ(json["settings"][2]["contact"], "velocity");
  EXPECT_EQ(json["settings"][3]["contact"], "gap");
  ASSERT_EQ(json["settings"][2]["windows"].size(), 2u);
  const nlohmann::json& window = json["settings"][2]["windows"][1];
  const WindowSummary& expected = summary.Of(2, 1);
  EXPECT_EQ(window["zoom"], 0.1);
  EXPECT_EQ(window["x"][0], landscape.plan.windows[1].x.lower);
  EXPECT_EQ(window["minimum"]["cost"], expected.minimum);
  EXPECT_EQ(window["range"], expected.roughness.range);
  EXPECT_EQ(window["roughness"]["off_quadratic"], expected.roughness.off_quadratic);
  EXPECT_EQ(window["roughness"]["second_difference"], expected.roughness.second_difference);
  EXPECT_EQ(window["roughness"]["gradient_gap"], expected.roughness.gradient_gap);
  EXPECT_TRUE(window["roughness"]["missing"].is_null());
  EXPECT_EQ(window["per_rollout"]["contact_changes"], 48.0);
  EXPECT_EQ(window["cells"], 81);
}

TEST(LandscapeSummary, TableHasALinePerWindow) {
  const std::string table = SummaryTable(Summarize(BumpyLandscape({"", "b"}, {1.0, 0.1, 0.01}, 9)));
  EXPECT_EQ(std::count(table.begin(), table.end(), '\n'), 1 + 4 * 3 + 2);  // with a header and a legend
  EXPECT_EQ(table.find("setting"), 0u);
  EXPECT_NE(table.find("scene as it is  gap "), std::string::npos) << table;
}

}  // namespace
}  // namespace clothid::landscape_summary_test
