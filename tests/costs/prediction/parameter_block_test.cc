// Values and internal coordinates, and where start and bounds come from.
#include "costs/prediction/parameter_block.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <limits>
#include <utility>

#include "tests/costs/synthetic_motion.h"
#include "tests/expect_error.h"

namespace clothid::parameter_block_test {
namespace {

TEST(ParameterBlockTest, CoordinatesInvertAndDifferentiate) {
  for (ParameterScale scale : {ParameterScale::kLinear, ParameterScale::kLog}) {
    ParameterBlock block;
    block.scale = scale;
    for (double value : {1e-4, 0.3, 250.0}) {
      const double q = block.ToCoordinate(value);
      EXPECT_NEAR(block.ToValue(q), value, 1e-14 * value);
      const double step = 1e-6;
      const double difference = (block.ToValue(q + step) - block.ToValue(q - step)) / (2.0 * step);
      EXPECT_NEAR(block.ValueDerivative(q), difference, 1e-9 * std::max(1.0, value));
    }
  }
}

TEST(ParameterBlockTest, WideBoundsDoNotComeNearer) {
  const Scene scene = SphereScene();
  const auto is_at_bound = [&](const std::string& name, const char* lower, const char* upper, double value) {
    ParameterOverrides overrides;
    if (*lower != 0) overrides.lower_bounds[name] = std::atof(lower);
    if (*upper != 0) overrides.upper_bounds[name] = std::atof(upper);
    const ParameterBlock block = MakeParameterBlock(name, scene, overrides);
    return block.IsAtBound(block.ToCoordinate(value));
  };
  EXPECT_TRUE(is_at_bound("mu", "", "", 0.0019));
  EXPECT_FALSE(is_at_bound("mu", "", "", 0.0021));
  EXPECT_TRUE(is_at_bound("mu", "", "500", 0.0019));
  EXPECT_FALSE(is_at_bound("mu", "", "500", 0.47));
  EXPECT_TRUE(is_at_bound("mu", "", "500", 499.999));
  EXPECT_TRUE(is_at_bound("mu", "0.1", "0.3", 0.1001)) << "narrow bounds count as they are";
  EXPECT_FALSE(is_at_bound("mu", "0.1", "0.3", 0.1003));
  EXPECT_TRUE(is_at_bound("k_stretch", "1e-100", "1e100", 1.01e-100));
  EXPECT_FALSE(is_at_bound("k_stretch", "1e-100", "1e100", 1.1e-100));
}

TEST(ParameterBlockTest, DefaultsComeFromTheScene) {
  Scene scene = SphereScene();
  scene.material.damping = 0.5;
  const ParameterBlock friction = MakeParameterBlock("mu", scene, {});
  EXPECT_EQ(friction.scale, ParameterScale::kLinear);
  EXPECT_EQ(friction.start, 0.2);
  EXPECT_EQ(friction.lower_bound, 0.0);
  EXPECT_EQ(friction.upper_bound, 2.0);
  const ParameterBlock stretch = MakeParameterBlock("k_stretch", scene, {});
  EXPECT_EQ(stretch.scale, ParameterScale::kLog);
  EXPECT_EQ(stretch.start, 50.0);
  EXPECT_DOUBLE_EQ(stretch.lower_bound, 6.54 / 100.0);
  EXPECT_DOUBLE_EQ(stretch.upper_bound, 4070.0 * 100.0);
  EXPECT_DOUBLE_EQ(MakeParameterBlock("damping", scene, {}).lower_bound, 0.5 / 1e4);
  EXPECT_DOUBLE_EQ(MakeParameterBlock("damping", scene, {}).upper_bound, 0.5 * 1e4);
  for (const char* name : {"k_bend", "density", "drag", "damping"}) {
    EXPECT_EQ(MakeParameterBlock(name, scene, {}).scale, ParameterScale::kLog) << name;
  }
}

TEST(ParameterBlockTest, OverridesGoBeforeTheSceneBeforeDefaults) {
  Scene scene = SphereScene();
  scene.parameters["k_stretch"].nominal = 70.0;
  scene.parameters["k_stretch"].upper_bound = 900.0;
  scene.parameters["k_stretch"].frozen = true;
  ParameterOverrides overrides;
  ParameterBlock block = MakeParameterBlock("k_stretch", scene, overrides);
  EXPECT_EQ(block.start, 70.0);
  EXPECT_DOUBLE_EQ(block.lower_bound, 6.54 / 100.0);
  EXPECT_EQ(block.upper_bound, 900.0);
  EXPECT_TRUE(block.frozen);
  overrides.start["k_stretch"] = 80.0;
  overrides.lower_bounds["k_stretch"] = 10.0;
  overrides.upper_bounds["k_stretch"] = 100.0;
  block = MakeParameterBlock("k_stretch", scene, overrides);
  EXPECT_EQ(block.start, 80.0);
  EXPECT_EQ(block.lower_bound, 10.0);
  EXPECT_EQ(block.upper_bound, 100.0);
}

TEST(ParameterBlockTest, BoundsFollowFromWhatWasMeasured) {
  Scene scene = SphereScene();
  const auto bounds = [&](const std::string& name, double start) {
    const ParameterBlock block = MakeParameterBlock(name, scene, {{{name, start}}, {}, {}, {}});
    return std::pair(block.lower_bound, block.upper_bound);
  };
  EXPECT_EQ(bounds("k_stretch", 30.0), bounds("k_stretch", 1e3)) << "whatever the start is";
  EXPECT_DOUBLE_EQ(bounds("k_stretch", 1e6).second, 1e8) << "but for one far beyond of what was measured";
  EXPECT_DOUBLE_EQ(bounds("k_stretch", 1e-2).first, 1e-4);
  EXPECT_DOUBLE_EQ(bounds("density", 0.15).first, 0.031 / 100.0);
  EXPECT_DOUBLE_EQ(bounds("density", 0.15).second, 48.8);
  EXPECT_DOUBLE_EQ(bounds("k_bend", 1e-4).first, 1.1e-8);
  EXPECT_DOUBLE_EQ(bounds("k_bend", 1e-4).second, 0.011);
  scene.fabric = "knit";
  EXPECT_DOUBLE_EQ(bounds("k_stretch", 36.0).first, 0.36) << "a hundredth of the start";
  EXPECT_DOUBLE_EQ(bounds("k_stretch", 36.0).second, 8270.0);
  EXPECT_DOUBLE_EQ(bounds("density", 0.245).first, 0.00245);
  scene.bending.law = BendingLaw::kEdges;
  EXPECT_DOUBLE_EQ(bounds("k_bend", 1e-4).second, 1.0) << "no rigidity of a cloth";
}

// Obstacles and pieces are those of the same name, wherever they stand; of what the number of a part is, the kind says.
TEST(ParameterBlockTest, KnowsItselfInOtherScenes) {
  Scene scene = SphereScene();
  scene.wind.profile = {Eigen::Vector2d(0.0, 1.0), Eigen::Matrix<double, 3, 2>::Ones()};
  scene.material.drag = 0.1;
  const ParameterBlock knot = MakeParameterBlock("wind.y.2", scene, {});
  EXPECT_EQ(knot.id, (ParameterId{ParameterKind::kWind, 1, 1}));
  EXPECT_EQ(knot.unit, 10.0);
  scene.obstacles.front().name = "ball";
  const ParameterBlock friction = MakeParameterBlock("mu.ball@1", scene, {});
  EXPECT_EQ(friction.id, (ParameterId{ParameterKind::kFriction, 0, 0}));
  Scene other = scene;
  other.obstacles.insert(other.obstacles.begin(), scene.obstacles.front());
  other.obstacles.front().name = "floor";
  EXPECT_EQ(friction.IdIn(other), (ParameterId{ParameterKind::kFriction, 0, 1}));
  EXPECT_EQ(knot.IdIn(other), knot.id);
  other.obstacles.clear();
  EXPECT_THROW(friction.IdIn(other), Error);
  const ParameterBlock shift = MakeParameterBlock("shift.z@2", MakeMotion(SphereScene(), {}), {});
  EXPECT_EQ(shift.IdIn(other), (ParameterId{ParameterKind::kShift, 2}));
}

TEST(ParameterBlockTest, PriorsAreOfTheSceneOrGiven) {
  Scene scene = SphereScene();
  scene.parameters["k_stretch"].prior = {100.0, 2.0};
  const ParameterBlock stretch = MakeParameterBlock("k_stretch", scene, {});
  EXPECT_DOUBLE_EQ(stretch.PriorCoordinate(), std::log(100.0));
  EXPECT_DOUBLE_EQ(stretch.PriorStd(), std::log(2.0));
  EXPECT_FALSE(MakeParameterBlock("mu", scene, {}).prior.is_given());
  ParameterOverrides overrides;
  overrides.priors = ParseParameterPriors("k_stretch = 50:3, mu=0.3:0.1,k_stretch@2=70:4", "--prior");
  EXPECT_EQ(MakeParameterBlock("k_stretch@1", scene, overrides).prior.center, 50.0);
  EXPECT_EQ(MakeParameterBlock("k_stretch@2", scene, overrides).prior.spread, 4.0);
  EXPECT_EQ(MakeParameterBlock("mu", scene, overrides).PriorCoordinate(), 0.3);
  EXPECT_EQ(MakeParameterBlock("mu", scene, overrides).PriorStd(), 0.1);
  RecordedMotion motion = MakeMotion(scene, {});
  overrides.priors = {{"shift", {0.0, 1e-3}}};
  const ParameterBlock shift = MakeParameterBlock("shift.y", motion, overrides);
  EXPECT_DOUBLE_EQ(shift.PriorStd() * shift.unit, 1e-3);
  EXPECT_EQ(PriorText({1e-5, 2.0}, ParameterScale::kLog), "1e-05, factor 2");
  EXPECT_EQ(PriorText({0.3, 0.1}, ParameterScale::kLinear), "0.3 +- 0.1");
  for (const char* text : {"mu", "mu=0.3", "mu=0.3:", "mu=:0.1", "=0.3:0.1", "mu=0.3:0.1:2", "mu=0.3:nan", ","}) {
    ExpectError([&] { ParseParameterPriors(text, "--prior"); }, ErrorKind::kUsage, {"--prior: expected NAME="});
  }
  ExpectError([&] { ParseParameterPriors("mu=1:1,mu=1:1", "--prior"); }, ErrorKind::kUsage, {"'mu' is given twice"});
}

TEST(ParameterBlockTest, FrictionWithoutObstaclesHasAStart) {
  const ParameterBlock block = MakeParameterBlock("mu", SwingScene(), {});
  EXPECT_GT(block.start, block.lower_bound);
  EXPECT_LT(block.start, block.upper_bound);
}

TEST(ParameterBlockTest, RefusesUnusableValues) {
  Scene scene = SphereScene();
  const auto make = [&](const std::string& name, double start, double lower, double upper) {
    ParameterOverrides overrides;
    if (!std::isnan(start)) overrides.start[name] = start;
    if (!std::isnan(lower)) overrides.lower_bounds[name] = lower;
    if (!std::isnan(upper)) overrides.upper_bounds[name] = upper;
    MakeParameterBlock(name, scene, overrides);
  };
  const double none = std::numeric_limits<double>::quiet_NaN();
  ExpectError([&] { make("weight", none, none, none); }, ErrorKind::kUsage, {"weight"});
  ExpectError([&] { make("mu.ghost", none, none, none); }, ErrorKind::kUsage, {"mu.ghost"});
  ExpectError([&] { make("mu", -0.1, none, none); }, ErrorKind::kUsage, {"mu", "starting value"});
  ExpectError([&] { make("mu", 0.5, 0.6, none); }, ErrorKind::kUsage, {"mu", "outside"});
  ExpectError([&] { make("mu", none, 0.6, 0.1); }, ErrorKind::kUsage, {"mu", "bounds"});
  ExpectError([&] { make("k_stretch", none, 0.0, none); }, ErrorKind::kUsage, {"k_stretch", "positive"});
  ExpectError([&] { make("k_stretch", 0.0, none, none); }, ErrorKind::kUsage, {"k_stretch", "positive"});
  scene.material.bending_stiffness = 0.0;
  ExpectError([&] { make("k_bend", none, none, none); }, ErrorKind::kUsage, {"k_bend", "positive nominal value"});
  EXPECT_NO_THROW(make("k_bend", 1e-3, none, none));
  ExpectError([&] { make("damping", none, none, none); }, ErrorKind::kUsage, {"damping", "positive nominal value"});
  EXPECT_NO_THROW(make("damping", 1e-3, none, none));
}

}  // namespace
}  // namespace clothid::parameter_block_test
