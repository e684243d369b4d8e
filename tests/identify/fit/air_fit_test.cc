// Drag by direction, added mass and wind as unknowns: found again where the motion tells them, named where it does not.
#include <gtest/gtest.h>

#include <map>
#include <string>
#include <vector>

#include "identify/fit/fit.h"
#include "tests/costs/synthetic_motion.h"
#include "tests/expect_error.h"

namespace clothid::air_fit_test {
namespace {

FitSummary RunFit(const RecordedMotion& motion, const std::vector<std::string>& parameters) {
  FitOptions options;
  options.parameters = parameters;
  options.max_iterations = 100;
  FitProblem problem({motion}, options);
  return Fit(options, &problem);
}

void ExpectRecovered(const FitSummary& summary, const std::map<std::string, double>& truth) {
  EXPECT_EQ(summary.status, FitStatus::kConverged) << summary.message;
  ASSERT_EQ(summary.parameters.size(), truth.size());
  for (const FittedParameter& parameter : summary.parameters) {
    const double value = truth.at(parameter.name);
    EXPECT_NEAR(parameter.value, value, 1e-4 * std::abs(value)) << parameter.name;
  }
  ASSERT_TRUE(summary.uncertainty.has_value());
  for (const ParameterUncertainty& parameter : summary.uncertainty->parameters) EXPECT_TRUE(parameter.identifiable);
}

Scene WindySwing(AirLaw law) {
  Scene scene = SwingScene();
  scene.air_law = law;
  scene.material.drag = 0.0;
  scene.material.normal_drag = 0.4;
  scene.material.tangential_drag = 0.1;
  scene.material.added_mass = 0.05;
  scene.wind.mean = {0.3, 0.5, -0.2};
  return scene;
}

TEST(AirFitTest, FindsDragByDirectionAddedMassAndWind) {
  const std::map<std::string, double> truth = {
      {"drag_normal", 0.7}, {"drag_tangential", 0.06}, {"added_mass", 0.12}, {"wind.x", -0.8}};
  for (const AirLaw law : {AirLaw::kLinear, AirLaw::kQuadratic}) {
    const RecordedMotion motion = MakeMotion(WindySwing(law), {truth, 0.0, 0.0, 0.0});
    ExpectRecovered(RunFit(motion, {"drag_normal", "drag_tangential", "added_mass", "wind.x"}), truth);
  }
}

TEST(AirFitTest, FindsTheKnotsOfAProfileAndGusts) {
  Scene scene = WindySwing(AirLaw::kLinear);
  scene.wind.profile.times = Eigen::Vector3d(0.0, 0.1, 0.2);
  scene.wind.profile.velocities = Eigen::Matrix3d::Zero();
  const std::map<std::string, double> knots = {{"wind.y.1", 0.7}, {"wind.y.2", -0.5}, {"wind.y.3", 1.2}};
  ExpectRecovered(RunFit(MakeMotion(scene, {knots, 0.0, 0.0, 0.0}), {"wind.y.1", "wind.y.2", "wind.y.3"}), knots);
  scene.wind.gust = {0.5, 0.5, 0.5};
  scene.wind.frequency = 15.0;
  scene.wind.phase = 0.3;
  const std::map<std::string, double> gust = {{"gust.z", 0.9}, {"gust.frequency", 19.0}, {"gust.phase", 0.1}};
  ExpectRecovered(RunFit(MakeMotion(scene, {gust, 0.0, 0.0, 0.0}), {"gust.z", "gust.frequency", "gust.phase"}), gust);
}

TEST(AirFitTest, FindsHowTheWindVariesOverTheCloth) {
  Scene scene = WindySwing(AirLaw::kQuadratic);
  scene.wind.shear = {0.5, 0.5, 0.0};
  const std::map<std::string, double> shear = {{"wind.shear.x", 2.0}, {"wind.shear.y", -1.2}, {"wind.y", 0.8}};
  ExpectRecovered(RunFit(MakeMotion(scene, {shear, 0.0, 0.0, 0.0}), {"wind.shear.x", "wind.shear.y", "wind.y"}), shear);
  scene.wind.gust = {0.5, 0.5, 0.5};
  scene.wind.frequency = 15.0;
  scene.wind.wave_vector = {3.0, 1.0, 0.0};
  const std::map<std::string, double> wave = {{"gust.wave.x", 5.0}, {"gust.wave.y", -0.7}};
  ExpectRecovered(RunFit(MakeMotion(scene, {wave, 0.0, 0.0, 0.0}), {"gust.wave.x", "gust.wave.y"}), wave);
}

// A cloth that hangs still in a steady wind tells how hard the wind pushes, not how fast it is.
TEST(AirFitTest, NamesWindAgainstDragOfAClothThatHangsStill) {
  Scene scene = SphereScene();
  scene.obstacles.clear();
  scene.material.damping = 1.0;
  scene.material.drag = 0.5;
  scene.wind.mean = {0.0, 0.0, 1.0};
  scene.duration = 20.0;
  {
    Simulator simulator(scene);
    scene.initial_positions = Simulate(scene.nominal_parameters(), scene.num_steps(), &simulator).positions(2000);
  }
  scene.duration = 0.1;
  RecordedMotion motion = MakeMotion(scene, {{}, 1e-4, 0.0, 1e-4});
  const FitSummary summary = RunFit(motion, {"drag", "wind.z"});
  ASSERT_TRUE(summary.uncertainty.has_value());
  for (const ParameterUncertainty& parameter : summary.uncertainty->parameters) EXPECT_FALSE(parameter.identifiable);
  ASSERT_EQ(summary.uncertainty->hidden_directions.size(), 1u);
  const std::string words = summary.uncertainty->hidden_directions[0].words;
  EXPECT_NE(words.find("drag"), std::string::npos) << words;
  EXPECT_NE(words.find("wind.z"), std::string::npos) << words;
}

TEST(AirFitTest, WindNeedsDrag) {
  Scene scene = SwingScene();
  scene.material.drag = 0.0;
  ExpectError([&] { MakeParameterBlock("wind.x", scene, {}); }, ErrorKind::kUsage, {"wind.x", "without drag"});
  ParameterOverrides overrides;
  overrides.start["drag_normal"] = 0.3;
  EXPECT_NO_THROW(MakeParameterBlock("wind.x", scene, overrides));
}

}  // namespace
}  // namespace clothid::air_fit_test
