#include "tools/landscape/landscape_plan.h"

#include <gtest/gtest.h>

#include <set>

#include "tests/costs/synthetic_motion.h"
#include "tests/expect_error.h"

namespace clothid::landscape_plan_test {
namespace {

LandscapeFlags Flags() {
  LandscapeFlags flags;
  flags.x = "mu=0:0.6:4";
  flags.y = "k_stretch=10:1000:3:log";
  return flags;
}

LandscapePlan Plan(const LandscapeFlags& flags) { return MakeLandscapePlan(flags, SphereScene()); }

TEST(LandscapePlan, TheWholeAlone) {
  const LandscapePlan plan = Plan(Flags());
  ASSERT_EQ(plan.windows.size(), 1u);
  EXPECT_EQ(plan.windows[0].zoom, 1.0);
  EXPECT_EQ(plan.num_cells(), 12);
  ASSERT_EQ(plan.settings.size(), 1u);
  EXPECT_EQ(plan.settings[0].name, "");
  EXPECT_EQ(plan.settings[0].contact_mode, ContactMode::kGap);
  EXPECT_FALSE(plan.has_gradients);
  Scene scene = SphereScene();
  scene.contact_mode = ContactMode::kVelocity;
  EXPECT_EQ(MakeLandscapePlan(Flags(), scene).settings[0].contact_mode, ContactMode::kVelocity);
}

TEST(LandscapePlan, WindowsFallAndSettingsMultiply) {
  LandscapeFlags flags = Flags();
  flags.zoom_around = "k_stretch=100,mu=0.3";
  flags.zoom = "0.01,0.1,0.03";
  flags.sweep = "ball.center.x=-0.1,0.1;touch=1e-5,1e-3";
  flags.contact = "both";
  flags.gradients = true;
  const LandscapePlan plan = Plan(flags);
  ASSERT_EQ(plan.windows.size(), 4u);
  const double zooms[] = {1.0, 0.1, 0.03, 0.01};
  for (int i = 0; i < 4; ++i) EXPECT_EQ(plan.windows[i].zoom, zooms[i]);
  EXPECT_DOUBLE_EQ(plan.windows[1].x.lower, 0.27);
  EXPECT_DOUBLE_EQ(plan.windows[1].y.lower, 100.0 * std::pow(10.0, -0.1));
  ASSERT_EQ(plan.settings.size(), 8u);
  EXPECT_EQ(plan.settings[0].name, "ball.center.x=-0.1;touch=1e-05");
  EXPECT_EQ(plan.settings[1].name, "ball.center.x=-0.1;touch=1e-05");
  EXPECT_EQ(plan.settings[1].contact_mode, ContactMode::kVelocity);
  EXPECT_EQ(plan.settings[2].name, "ball.center.x=-0.1;touch=0.001");
  EXPECT_EQ(plan.settings[7].name, "ball.center.x=0.1;touch=0.001");
  EXPECT_EQ(plan.num_cells(), 8 * 4 * 12);
  EXPECT_TRUE(plan.has_gradients);
  flags.zoom_only = true;
  EXPECT_EQ(Plan(flags).windows.size(), 3u);
  EXPECT_EQ(Plan(flags).windows.front().zoom, 0.1);
}

TEST(LandscapePlan, NamesTheWrongFlag) {
  const auto expect_refused = [](const LandscapeFlags& flags, const char* flag, const char* expected) {
    ExpectError([&] { Plan(flags); }, ErrorKind::kUsage, {flag, expected});
  };
  LandscapeFlags flags = Flags();
  flags.x = "";
  expect_refused(flags, "--x", "missing");
  flags = Flags();
  flags.y = "";
  expect_refused(flags, "--y", "missing");
  flags.y = "mu=0:1:5";
  expect_refused(flags, "--y", "on --x already");
  flags.y = "mu.ball=0:1:5";
  expect_refused(flags, "--y", "include each other");
  flags = Flags();
  flags.contact = "gaps";
  expect_refused(flags, "--contact", "gap, velocity or both");
  flags = Flags();
  flags.sweep = "touch";
  expect_refused(flags, "--sweep", "touch");
  flags = Flags();
  flags.x = "mu=0:1:5000";
  flags.y = "k_stretch=1:2:5000";
  expect_refused(flags, "--x, --y", "at most 4000000 cells");
  flags.x = "mu=0:1:2147483647";
  flags.y = "k_stretch=1:2:9000000000";
  expect_refused(flags, "--x, --y", "at most 4000000 cells");
}

TEST(LandscapePlan, NamesTheWrongZoom) {
  const auto expect_refused = [](const char* around, const char* zoom, const char* flag, const char* expected) {
    LandscapeFlags flags = Flags();
    flags.zoom_around = around;
    flags.zoom = zoom;
    ExpectError([&] { Plan(flags); }, ErrorKind::kUsage, {flag, expected});
  };
  expect_refused("mu=0.3,k_stretch=100", "", "--zoom_around", "with --zoom");
  expect_refused("", "0.1", "--zoom", "with --zoom_around");
  expect_refused("mu=0.3", "0.1", "--zoom_around", "'k_stretch'");
  expect_refused("mu=0.3,k_stretch=100,k_bend=1", "0.1", "--zoom_around", "axes alone");
  expect_refused("mu=0.7,k_stretch=100", "0.1", "--zoom_around", "from 0 to 0.6");
  expect_refused("mu=0.3,k_stretch=nan", "0.1", "--zoom_around", "k_stretch");
  for (const char* zoom : {"1", "0", "-0.1", "2", "a", "0.1,", ","}) {
    expect_refused("mu=0.3,k_stretch=100", zoom, "--zoom", "between 0 and 1");
  }
  expect_refused("mu=0.3,k_stretch=100", "0.1,0.03,0.1", "--zoom", "twice");
  expect_refused("mu=0.3,k_stretch=100", "1e-17", "--zoom", "too small");
  LandscapeFlags flags = Flags();
  flags.zoom_only = true;
  ExpectError([&] { Plan(flags); }, ErrorKind::kUsage, {"--zoom_only"});
}

TEST(LandscapePlan, ShardsTakeEveryCellOnce) {
  const LandscapePlan plan = Plan(Flags());
  for (const int count : {1, 2, 3, 7, 12, 15}) {
    std::multiset<int> cells;
    for (int index = 0; index < count; ++index) {
      const LandscapeShard shard = ParseShard(std::to_string(index) + "/" + std::to_string(count));
      EXPECT_EQ(shard.is_whole(), count == 1);
      for (const int cell : shard.Cells(plan)) cells.insert(cell);
    }
    EXPECT_EQ(cells.size(), 12u);
    EXPECT_EQ(std::set<int>(cells.begin(), cells.end()).size(), 12u);
  }
  EXPECT_EQ(ParseShard("1/5").Cells(plan), (std::vector<int>{1, 6, 11}));
  EXPECT_TRUE(ParseShard("").is_whole());
  for (const char* text : {"1", "/", "1/", "3/3", "-1/3", "0/0", "1/2/3", "a/b", "0/99999999999"}) {
    ExpectError([&] { ParseShard(text); }, ErrorKind::kUsage, {"--shard", "0 <= I < N"});
  }
}

}  // namespace
}  // namespace clothid::landscape_plan_test
