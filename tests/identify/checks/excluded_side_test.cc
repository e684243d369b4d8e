// What is said of a parameter whose derivative tells nothing is true at its bounds, too: there it is tried, and values
// that are excluded are the end of an interval.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "identify/result/result_json.h"
#include "identify/run.h"
#include "tests/costs/synthetic_motion.h"
#include "tests/identify/simulated_recordings.h"

namespace clothid::excluded_side_test {
namespace {

constexpr double kTangent = 0.36397023;  // of the 20 degrees of the slope

// A sheet that lies on a slope, and sticks to it with more friction than its tangent. `held`: nodes that are handles.
RecordedMotion OnSlope(double friction, const std::string& held = "") {
  nlohmann::json scene = nlohmann::json::parse(
      R"({"clothid_scene": 2, "time_step": 0.01, "duration": 0.3,
          "mesh": {"grid": {"nodes": [4, 4], "size": [0.2, 0.2],
                            "axes": [[0.9396926207859084, 0, -0.3420201433256687], [0, 1, 0]]}},
          "initial": {"velocity": [0, 0, 0]},
          "obstacles": [{"name": "s", "type": "plane", "point": [0, 0, 0],
                         "normal": [0.3420201433256687, 0, 0.9396926207859084]}],
          "materials": {"density": 0.15, "k_stretch": 50, "k_bend": 1e-4}})");
  scene["obstacles"][0]["mu"] = friction;
  if (!held.empty()) scene["handles"] = nlohmann::json::parse(held);
  SyntheticOptions options;
  options.noise_sigma = 1e-3;
  return AsFitted(SimulatedText(scene.dump(), options));
}

RunResult FitOf(const RecordedMotion& motion, std::vector<std::string> parameters, double friction = 0.5) {
  RunOptions options;
  options.targets = {motion};
  const bool has_friction = std::find(parameters.begin(), parameters.end(), "mu") != parameters.end();
  if (has_friction) options.fit.overrides.start["mu"] = friction;
  options.fit.parameters = std::move(parameters);
  return Identify(options);
}

bool Says(const RunResult& result, const std::string& words) {
  const std::vector<std::string> lines = result.verdict.Lines();
  return std::any_of(lines.begin(), lines.end(),
                     [&](const std::string& line) { return line.find(words) != std::string::npos; });
}

void ExpectAtLeast(const RunResult& result, double friction) {
  const ParameterUncertainty& mu = result.summary.uncertainty->parameters[0];
  EXPECT_NEAR(mu.lower95, friction, 0.01 * friction) << result.table;
  EXPECT_TRUE(std::isnan(mu.upper95) && std::isnan(mu.std)) << result.table;
  EXPECT_FALSE(mu.identifiable);
  EXPECT_EQ(result.exit_code, kExitNotIdentifiable) << result.table;
  EXPECT_EQ(result.verdict.parameters[0], Usability::kWithCare) << result.table;
  EXPECT_TRUE(Says(result, "mu is at least 0.36")) << result.table;
  EXPECT_FALSE(Says(result, "moved from bound to bound")) << result.table;
}

TEST(ExcludedSideTest, ClothThatSticksWouldSlideWithLessFriction) {
  const RunResult result = FitOf(OnSlope(0.5), {"mu"});
  ExpectAtLeast(result, kTangent);
  EXPECT_EQ(result.verdict.line.rfind("usable with care: mu is at least 0.36", 0), 0u) << result.verdict.line;
  EXPECT_NE(result.table.find("at least 0.36"), std::string::npos) << result.table;
  EXPECT_LT(result.summary.statistics.rollouts, 40);
}

TEST(ExcludedSideTest, ResultJsonHasTheOneEnd) {
  const RecordedMotion motion = OnSlope(0.5);
  const RunResult result = FitOf(motion, {"mu"});
  const nlohmann::json json = nlohmann::json::parse(ResultJson(result.summary, result.checks, {motion}));
  const nlohmann::json& mu = json["parameters"]["mu"];
  EXPECT_NEAR(mu["lower95"].get<double>(), kTangent, 0.01 * kTangent);
  EXPECT_TRUE(mu["upper95"].is_null() && mu["std"].is_null()) << mu;
  EXPECT_EQ(mu["identifiable"], false);
  ASSERT_EQ(json["uncertainty"]["bound_checks"].size(), 1u);
  EXPECT_EQ(json["uncertainty"]["bound_checks"][0]["of"], "mu");
  EXPECT_GT(json["uncertainty"]["bound_checks"][0]["rise_below"].get<double>(), 1e3);
  EXPECT_NEAR(json["uncertainty"]["bound_checks"][0]["rise_above"].get<double>(), 0.0, 1e-6);
}

TEST(ExcludedSideTest, FromTheBoundItself) { ExpectAtLeast(FitOf(OnSlope(0.5), {"mu"}, kMaxFriction), kTangent); }

// The others are at their best where mu is held.
TEST(ExcludedSideTest, BesideAParameterThatIsTold) {
  const RunResult result = FitOf(OnSlope(0.5), {"mu", "density"});
  ASSERT_EQ(result.summary.parameters[0].name, "mu");
  EXPECT_NEAR(result.summary.uncertainty->parameters[0].lower95, kTangent, 0.01 * kTangent) << result.table;
}

TEST(ExcludedSideTest, WhereNothingTouchesTheSentenceIsTrueAndStays) {
  MotionOptions truth;
  truth.noise = truth.sigma = 1e-3;
  Scene scene = SphereScene();
  scene.obstacles[0].shape = std::make_shared<Sphere>(Eigen::Vector3d(0.15, 0.2, -5.0), 0.1);
  const RunResult result = FitOf(MakeMotion(scene, truth), {"mu"});
  EXPECT_TRUE(Says(result, "not identifiable: mu: moved from bound to bound, the prediction changes by 0 standard"))
      << result.table;
  ASSERT_EQ(result.summary.bound_checks.size(), 1u);
  // But for rounding.
  EXPECT_NEAR(result.summary.bound_checks[0].rise_below, 0.0, 1e-9);
  EXPECT_NEAR(result.summary.bound_checks[0].rise_above, 0.0, 1e-9);
  EXPECT_FALSE(result.summary.uncertainty->parameters[0].has_excluded_side());
  EXPECT_EQ(result.exit_code, kExitNotIdentifiable);
}

// A common factor changes nothing however far it goes; density alone would.
TEST(ExcludedSideTest, DirectionsAreTriedAtTheirEnds) {
  MotionOptions truth;
  truth.noise = truth.sigma = 1e-3;
  const RunResult result = FitOf(MakeMotion(SwingScene(), truth), {"k_stretch", "k_bend", "density", "drag"});
  EXPECT_TRUE(Says(result, "multiplied by one factor: moved from bound to bound, the prediction changes by "))
      << result.table;
  ASSERT_EQ(result.summary.bound_checks.size(), 1u);
  EXPECT_EQ(result.summary.bound_checks[0].direction, 0);
  EXPECT_LT(result.summary.bound_checks[0].change(), 0.1);
}

TEST(ExcludedSideTest, PaysNothingWhereAllIsTold) {
  MotionOptions truth;
  truth.noise = truth.sigma = 1e-3;
  const RunResult result = FitOf(MakeMotion(SwingScene(), truth), {"k_stretch"});
  EXPECT_TRUE(result.summary.bound_checks.empty());
}

}  // namespace
}  // namespace clothid::excluded_side_test
