// Where parameters may be that have no interval.
#include "identify/uncertainty/untold_range.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace clothid::untold_range_test {
namespace {

// Of a stiffness at its lower bound, six decades below the upper one.
UntoldParameter AtLowerBound(double visible_change) {
  UntoldParameter parameter;
  parameter.scale = ParameterScale::kLog;
  parameter.value = parameter.lower_bound = 1e-8;
  parameter.upper_bound = 1e-2;
  parameter.at_bound = true;
  parameter.visible_change = visible_change;
  return parameter;
}

TEST(UntoldRangeTest, OneAtItsBoundFollowsHalfANormalDistributionInside) {
  const double range = std::log(1e6);
  const auto told = RangeOf(AtLowerBound(20.0));
  ASSERT_TRUE(told.has_value());
  EXPECT_NEAR(told->At(0.0), std::log(1e-8), 1e-12);
  EXPECT_NEAR(told->At(1.0), std::log(1e-8) + range / 20.0, 1e-12);
  EXPECT_EQ(told->At(-1.0), told->At(1.0));
  EXPECT_NEAR(told->At(30.0), std::log(1e-2), 1e-12) << "cut at the other bound";
  UntoldParameter above = AtLowerBound(20.0);
  above.value = above.upper_bound;
  EXPECT_NEAR(RangeOf(above)->At(1.0), std::log(1e-2) - range / 20.0, 1e-12);
  above.residual_scale = 3.0;
  EXPECT_NEAR(RangeOf(above)->At(1.0), std::log(1e-2) - 3.0 * range / 20.0, 1e-12);
  above.residual_scale = 0.5;
  EXPECT_NEAR(RangeOf(above)->At(1.0), std::log(1e-2) - range / 20.0, 1e-12) << "noise is at least what is known";
}

TEST(UntoldRangeTest, OneThatIsHiddenIsAnywhereThatWasBelieved) {
  UntoldParameter hidden = AtLowerBound(0.1);
  EXPECT_FALSE(RangeOf(hidden).has_value()) << "with others";
  hidden.hidden_alone = true;
  const auto told = RangeOf(hidden);
  ASSERT_TRUE(told.has_value());
  EXPECT_NEAR(told->At(0.0), std::log(1e-5), 1e-12);
  EXPECT_NEAR(told->At(-9.0), std::log(1e-7), 1e-9);
  EXPECT_NEAR(told->At(9.0), std::log(1e-3), 1e-9);
  constexpr double kQuartile = 0.6744897501960817;
  EXPECT_NEAR(told->At(kQuartile), std::log(1e-4), 1e-9);
}

TEST(UntoldRangeTest, WhatIsExcludedIsTakenOff) {
  UntoldParameter friction;
  friction.value = 0.6;
  friction.upper_bound = 2.0;
  friction.hidden_alone = true;
  friction.lower95 = 0.4;
  const auto told = RangeOf(friction);
  ASSERT_TRUE(told.has_value());
  EXPECT_NEAR(told->At(-9.0), 0.4, 1e-9);
  EXPECT_NEAR(told->At(0.0), 1.2, 1e-12);
  EXPECT_NEAR(told->At(9.0), 2.0, 1e-9);
}

TEST(UntoldRangeTest, NothingIsToldOfOneThatStalledOffItsBounds) {
  UntoldParameter stalled = AtLowerBound(20.0);
  stalled.at_bound = false;
  EXPECT_FALSE(RangeOf(stalled).has_value());
  UntoldParameter unbounded = AtLowerBound(20.0);
  unbounded.upper_bound = std::numeric_limits<double>::infinity();
  EXPECT_FALSE(RangeOf(unbounded).has_value());
}

TEST(UntoldRangeTest, AHiddenDirectionIsOfOneWhereOthersHardlyTakePart) {
  const std::vector<Eigen::VectorXd> directions = {Eigen::Vector3d(0.05, 1.0, 0.0), Eigen::Vector3d(1.0, 0.0, 0.5)};
  EXPECT_FALSE(IsHiddenAlone(directions, 0));
  EXPECT_TRUE(IsHiddenAlone(directions, 1));
  EXPECT_FALSE(IsHiddenAlone(directions, 2));
  EXPECT_FALSE(IsHiddenAlone({}, 0));
}

}  // namespace
}  // namespace clothid::untold_range_test
