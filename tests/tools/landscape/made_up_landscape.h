// A landscape that no rollout was needed for.
#ifndef CLOTHID_TESTS_TOOLS_LANDSCAPE_MADE_UP_LANDSCAPE_H_
#define CLOTHID_TESTS_TOOLS_LANDSCAPE_MADE_UP_LANDSCAPE_H_

#include <gtest/gtest.h>

#include <cstring>
#include <string>

#include "identify/landscape/landscape_folder.h"

namespace clothid {

inline constexpr int kFailedCell = 2;

// 4 x 3 cells in two windows of two settings, cell c with the cost c/3 + 0.5 to some digits and c + 1 events of each
// kind; the one of `kFailedCell` failed.
inline Landscape MadeUpLandscape(bool has_gradients) {
  Landscape landscape;
  LandscapePlan& plan = landscape.plan;
  plan.settings = {{"touch=1e-05", ContactMode::kGap}, {"touch=1e-05", ContactMode::kVelocity}};
  plan.windows = {
      {1.0, {"mu", ParameterScale::kLinear, 0.0, 0.75, 4}, {"k_stretch", ParameterScale::kLog, 10.0, 1000.0, 3}},
      {0.1, {"mu", ParameterScale::kLinear, 0.1 / 0.3, 0.4, 4}, {"k_stretch", ParameterScale::kLog, 90.0, 110.0, 3}}};
  plan.has_gradients = has_gradients;
  for (int c = 0; c < plan.num_cells(); ++c) {
    LandscapeCell cell;
    cell.cost = c == 25 ? 8.5 : 0.5 + c / 3.0;
    cell.seconds = 0.1 + c / 7.0;
    cell.counts.steps = 20;
    cell.counts.contacts = c;
    cell.counts.nodes_joined = cell.counts.nodes_left = cell.counts.branch_switches = c + 1;
    cell.counts.obstacle_switches = c;
    cell.counts.pair_changes = 2 * c;
    if (has_gradients) {
      cell.gradient_x = -0.25;
      cell.gradient_y = 1e-300;
    }
    if (c == kFailedCell) {
      cell.cost = cell.gradient_x = cell.gradient_y = std::numeric_limits<double>::quiet_NaN();
      cell.failure = "step 3 \"failed\", residual 1e-3, badly";
      cell.counts.failed_steps = 1;
    }
    landscape.cells.push_back(cell);
  }
  return landscape;
}

inline LandscapeOrigin MadeUpOrigin(const LandscapeShard& shard) {
  LandscapeOrigin origin;
  origin.version = "1.2.3";
  origin.git = "abc";
  origin.input_sha256 = std::string(64, 'b');
  origin.truth = {{"k_stretch", 100.0}, {"mu.ball", 0.1 + 0.2}};
  origin.fingerprint = std::string(64, 'a');
  origin.sigma = {SigmaSource::kGiven, 0.1 + 0.2, 1.0 / 3.0};
  origin.shard = shard;
  return origin;
}

inline void ExpectSameLandscape(const Landscape& a, const Landscape& b) {
  const auto same = [](double x, double y) { return std::memcmp(&x, &y, sizeof(x)) == 0; };
  ASSERT_EQ(a.plan.num_cells(), b.plan.num_cells());
  EXPECT_EQ(a.plan.has_gradients, b.plan.has_gradients);
  for (int c = 0; c < a.plan.num_cells(); ++c) {
    const LandscapePlace place = a.plan.PlaceOf(c);
    EXPECT_EQ(a.plan.settings[place.setting].name, b.plan.settings[place.setting].name);
    EXPECT_EQ(a.plan.settings[place.setting].contact_mode, b.plan.settings[place.setting].contact_mode);
    EXPECT_EQ(a.plan.windows[place.window].x.parameter, b.plan.windows[place.window].x.parameter);
    EXPECT_EQ(a.plan.windows[place.window].x.Value(place.ix), b.plan.windows[place.window].x.Value(place.ix));
    EXPECT_EQ(a.plan.windows[place.window].y.Value(place.iy), b.plan.windows[place.window].y.Value(place.iy));
    EXPECT_TRUE(same(a.cells[c].cost, b.cells[c].cost)) << c;
    EXPECT_TRUE(same(a.cells[c].gradient_x, b.cells[c].gradient_x)) << c;
    EXPECT_TRUE(same(a.cells[c].gradient_y, b.cells[c].gradient_y)) << c;
    EXPECT_EQ(a.cells[c].seconds, b.cells[c].seconds) << c;
    EXPECT_EQ(a.cells[c].failure, b.cells[c].failure) << c;
    EXPECT_EQ(std::memcmp(&a.cells[c].counts, &b.cells[c].counts, sizeof(RolloutCounts)), 0) << c;
  }
}

}  // namespace clothid

#endif  // CLOTHID_TESTS_TOOLS_LANDSCAPE_MADE_UP_LANDSCAPE_H_
