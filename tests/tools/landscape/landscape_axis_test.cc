#include "tools/landscape/landscape_axis.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/expect_error.h"

namespace clothid::landscape_axis_test {
namespace {

const std::vector<std::string> kObstacles = {"ball", "floor"};

LandscapeAxis Parse(const std::string& text) { return ParseAxis(text, "--x", kObstacles); }

void ExpectRefused(const std::string& text, const char* expected) {
  ExpectError([&] { Parse(text); }, ErrorKind::kUsage, {"--x", expected});
}

TEST(LandscapeAxis, ReadsBothScales) {
  const LandscapeAxis linear = Parse("mu.ball=0:0.6:33");
  EXPECT_EQ(linear.parameter, "mu.ball");
  EXPECT_EQ(linear.scale, ParameterScale::kLinear);
  EXPECT_EQ(linear.lower, 0.0);
  EXPECT_EQ(linear.upper, 0.6);
  EXPECT_EQ(linear.num_cells, 33);
  EXPECT_DOUBLE_EQ(linear.Value(16), 0.3);
  const LandscapeAxis log = Parse("k_stretch=1e1:1e4:4:log");
  EXPECT_EQ(log.scale, ParameterScale::kLog);
  EXPECT_EQ(log.Value(0), 10.0);
  EXPECT_DOUBLE_EQ(log.Value(1), 100.0);
  EXPECT_EQ(log.Value(3), 1e4);
}

TEST(LandscapeAxis, RefusesWhatCannotBeScanned) {
  for (const char* text : {"", "mu", "=0:1:3", "mu=", "mu=0:1", "mu=0:1:3:log:4", "mu=0:1:3:lin",
                           "mu=0:1:3:", "mu=a:1:3", "mu=0:1:2.5", "mu=0:nan:3", "mu=0:inf:3", "mu 0:1:3"}) {
    ExpectError([&] { Parse(text); }, ErrorKind::kUsage, {"--x"});
  }
  ExpectRefused("mu=0.6:0:33", "lower end below");
  ExpectRefused("mu=0.6:0.6:33", "lower end below");
  for (const char* text : {"mu=0:0.6:1", "mu=0:0.6:0", "mu=0:0.6:-3"}) ExpectRefused(text, "at least 2 cells");
  ExpectRefused("weight=0:1:3", "unknown parameter 'weight'");
  ExpectRefused("mu.wall=0:1:3", "mu.ball");
  ExpectRefused("mu=0:1:3:log", "above 0 on a log axis");
  ExpectRefused("k_bend=-1:1:3:log", "above 0 on a log axis");
  ExpectRefused("k_stretch=0:1:3", "above 0");
  ExpectRefused("density=-1:1:3", "above 0");
  ExpectRefused("mu=-0.1:1:3", "at least 0");
  ExpectError([] { ParseAxis("mu=0:1:3", "--y", {}); }, ErrorKind::kUsage, {"--y", "no obstacle"});
}

TEST(LandscapeAxis, ZoomsInItsOwnScale) {
  const LandscapeAxis whole = Parse("mu=0:0.6:33");
  const LandscapeAxis middle = ZoomInto(whole, 0.3, 0.1, "--zoom");
  EXPECT_DOUBLE_EQ(middle.lower, 0.27);
  EXPECT_DOUBLE_EQ(middle.upper, 0.33);
  EXPECT_EQ(middle.num_cells, 33);
  const LandscapeAxis log = ZoomInto(Parse("k_stretch=1:1e4:5:log"), 100.0, 0.5, "--zoom");
  EXPECT_DOUBLE_EQ(log.lower, 10.0);
  EXPECT_NEAR(log.upper, 1e3, 1e-11);
}

TEST(LandscapeAxis, AZoomStaysInsideTheWhole) {
  for (const char* text : {"mu=0:0.6:33", "k_stretch=0.1:0.7:5:log"}) {
    const LandscapeAxis whole = Parse(text);
    for (const double zoom : {0.9, 0.1, 1e-6}) {
      for (const double center : {whole.lower, whole.Value(1), whole.Value(2), whole.upper}) {
        const LandscapeAxis axis = ZoomInto(whole, center, zoom, "--zoom");
        EXPECT_GE(axis.lower, whole.lower);
        EXPECT_LE(axis.upper, whole.upper);
        EXPECT_LE(axis.lower, center);
        EXPECT_GE(axis.upper, center);
        if (axis.scale == ParameterScale::kLinear) {
          EXPECT_NEAR(axis.upper - axis.lower, zoom * (whole.upper - whole.lower), 1e-15);
        } else {
          EXPECT_NEAR(std::log(axis.upper / axis.lower), zoom * std::log(whole.upper / whole.lower), 1e-14);
        }
      }
    }
    EXPECT_EQ(ZoomInto(whole, whole.lower, 0.1, "--zoom").lower, whole.lower);
    EXPECT_EQ(ZoomInto(whole, whole.upper, 0.1, "--zoom").upper, whole.upper);
    ExpectError([&] { ZoomInto(whole, whole.upper, 1e-16, "--zoom"); }, ErrorKind::kUsage, {"--zoom", "too small"});
  }
}

TEST(LandscapeAxis, KnowsWhatSetsWhat) {
  const auto id = [](const char* name) { return ParseParameter(name, kObstacles); };
  EXPECT_TRUE(Includes(id("mu"), id("mu")));
  EXPECT_TRUE(Includes(id("mu"), id("mu.floor")));
  EXPECT_FALSE(Includes(id("mu.floor"), id("mu")));
  EXPECT_FALSE(Includes(id("mu.floor"), id("mu.ball")));
  EXPECT_FALSE(Includes(id("k_stretch"), id("k_bend")));
}

}  // namespace
}  // namespace clothid::landscape_axis_test
