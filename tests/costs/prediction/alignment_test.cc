// Names, ranges and centre of a recording's own parameters, and the blocks made of them.
#include "costs/prediction/alignment.h"

#include <gtest/gtest.h>

#include <limits>

#include "tests/costs/synthetic_motion.h"
#include "tests/expect_error.h"

namespace clothid::alignment_test {
namespace {

using Names = std::vector<std::string>;

TEST(AlignmentTest, NamesStandForScalars) {
  EXPECT_EQ(*FindParameter("time_offset"), (ParameterId{ParameterKind::kTimeOffset, 0}));
  EXPECT_EQ(*FindParameter("shift.x"), (ParameterId{ParameterKind::kShift, 0}));
  EXPECT_EQ(*FindParameter("turn.y"), (ParameterId{ParameterKind::kTurn, 1}));
  EXPECT_EQ(*FindParameter("v0.z"), (ParameterId{ParameterKind::kStartVelocity, 2}));
  EXPECT_EQ(*FindParameter("handle_shift.x"), (ParameterId{ParameterKind::kHandleShift, 0}));
  EXPECT_EQ(*FindParameter("handle_shift2.y"), (ParameterId{ParameterKind::kHandleShift, 1, 1}));
  EXPECT_EQ(*FindParameter("handle_turn.z"), (ParameterId{ParameterKind::kHandleTurn, 2}));
  for (const char* name : {"", "shift", "shift.", "shift.w", "shift.xy", "v0", "align", "time_offset.x",
                           "handle_shift0.x", "handle_shift01.x", "handle_shift2", "handle_turn2.x"}) {
    EXPECT_FALSE(FindParameter(name).has_value()) << name;
  }
  Alignment alignment;
  alignment.Set(*FindParameter("turn.y"), 0.1);
  EXPECT_EQ(alignment.turn, Eigen::Vector3d(0.0, 0.1, 0.0));
  EXPECT_EQ(alignment.shift, Eigen::Vector3d::Zero());
}

TEST(AlignmentTest, GroupsStandForTheirAxes) {
  EXPECT_EQ(ExpandAlignmentNames({"mu", "shift", "time_offset"}),
            (Names{"mu", "shift.x", "shift.y", "shift.z", "time_offset"}));
  EXPECT_EQ(ExpandAlignmentNames({"align"}), (Names{"shift.x", "shift.y", "shift.z", "turn.x", "turn.y", "turn.z"}));
  EXPECT_EQ(ExpandAlignmentNames({"handle_shift"}), (Names{"handle_shift.x", "handle_shift.y", "handle_shift.z"}));
  EXPECT_EQ(ExpandAlignmentNames({"handle_shift2"}), (Names{"handle_shift2.x", "handle_shift2.y", "handle_shift2.z"}));
  EXPECT_EQ(ExpandAlignmentNames({"handle_turn"}), (Names{"handle_turn.x", "handle_turn.y", "handle_turn.z"}));
  EXPECT_EQ(ExpandAlignmentNames({"v0", "shift.z"}), (Names{"v0.x", "v0.y", "v0.z", "shift.z"}));
  EXPECT_EQ(OverrideNames("shift.x@2"), (Names{"shift.x@2", "shift@2", "shift.x", "shift"}));
  EXPECT_EQ(OverrideNames("mu.ball"), Names{"mu.ball"});
  EXPECT_EQ(OverrideNames("drag@12"), (Names{"drag@12", "drag"}));
  EXPECT_EQ(BaseName("shift.x@2"), "shift.x");
}

TEST(AlignmentTest, TheCenterIsThatOfWhatWasSeen) {
  RecordedMotion motion = MakeMotion(SwingScene(), {});
  motion.positions.setConstant(std::numeric_limits<double>::quiet_NaN());
  motion.positions.col(3).head<6>() << 1.0, 2.0, 3.0, 3.0, 6.0, 5.0;
  EXPECT_EQ(TurnCenter(motion), Eigen::Vector3d(2.0, 4.0, 4.0));
  motion.centroid = Eigen::Vector3d(0.5, 0.0, 0.0);
  EXPECT_EQ(TurnCenter(motion), *motion.centroid);
}

TEST(AlignmentTest, BlocksStartAtZeroWithinTheirRange) {
  MotionOptions options;
  options.frame_interval = 0.02;
  const RecordedMotion motion = MakeMotion(SwingScene(), options);
  const std::map<std::string, double> ranges = {
      {"time_offset", 0.04}, {"shift.y", 0.075}, {"turn.z", 0.2}, {"v0.x", 2.0}};
  for (const auto& [name, range] : ranges) {
    const ParameterBlock block = MakeParameterBlock(name, motion, {});
    EXPECT_EQ(block.start, 0.0);
    EXPECT_NEAR(block.upper_bound, range, 1e-12) << name;
    EXPECT_EQ(block.lower_bound, -block.upper_bound);
    EXPECT_NEAR(block.ToCoordinate(0.5 * range), 0.5, 1e-12);
    EXPECT_NEAR(block.ToValue(-1.0), -range, 1e-12);
    EXPECT_NEAR(block.ValueDerivative(0.3), range, 1e-12);
    EXPECT_GT(block.Resolution(0.0), 0.0);
  }
}

TEST(AlignmentTest, OverridesOfARecordingGoBeforeThoseOfAll) {
  const RecordedMotion motion = MakeMotion(SwingScene(), {});
  ParameterOverrides overrides;
  overrides.upper_bounds = {{"shift", 0.01}, {"shift.y", 0.02}, {"shift@2", 0.03}};
  overrides.start = {{"shift", -0.005}, {"k_stretch@2", 70.0}};
  EXPECT_EQ(MakeParameterBlock("shift.x", motion, overrides).upper_bound, 0.01);
  EXPECT_EQ(MakeParameterBlock("shift.y@1", motion, overrides).upper_bound, 0.02);
  EXPECT_EQ(MakeParameterBlock("shift.y@2", motion, overrides).upper_bound, 0.03);
  EXPECT_EQ(MakeParameterBlock("shift.z", motion, overrides).start, -0.005);
  EXPECT_EQ(MakeParameterBlock("k_stretch@2", motion, overrides).start, 70.0);
  EXPECT_EQ(MakeParameterBlock("k_stretch@1", motion, overrides).start, 50.0);
}

TEST(AlignmentTest, RefusesUnusableBounds) {
  const RecordedMotion motion = MakeMotion(SwingScene(), {});
  const auto expect = [&](const std::string& name, double start, double lower, double upper, const char* culprit) {
    ParameterOverrides overrides;
    overrides.start[name] = start;
    overrides.lower_bounds[name] = lower;
    overrides.upper_bounds[name] = upper;
    ExpectError([&] { MakeParameterBlock(name, motion, overrides); }, ErrorKind::kUsage, {name.c_str(), culprit});
  };
  expect("time_offset", 0.0, -0.01, 0.3, "within +-0.2");  // the recording lasts 0.2 s
  expect("turn.x", 0.0, -4.0, 0.1, "within");
  expect("shift.x", 0.0, 0.1, -0.1, "increasing");
  expect("shift.x", 0.0, -std::numeric_limits<double>::infinity(), 0.1, "increasing");
  expect("v0.x", 1.0, -0.1, 0.1, "outside");
  ExpectError([&] { MakeParameterBlock("weight@2", motion, {}); }, ErrorKind::kUsage, {"weight", "k_stretch", "shift"});
}

}  // namespace
}  // namespace clothid::alignment_test
