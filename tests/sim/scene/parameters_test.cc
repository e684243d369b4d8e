#include "sim/scene/parameters.h"

#include <gtest/gtest.h>

#include <cmath>

#include "sim/scene/scene.h"
#include "tests/expect_error.h"

namespace clothid::parameters_test {
namespace {

const std::vector<std::string>& Names() {
  static const std::vector<std::string> names = {"ball", "floor"};
  return names;
}

TEST(ParseParameter, TurnsNamesIntoIdsAndBack) {
  for (const char* name : {"k_stretch", "k_bend", "density", "drag", "damping", "mu", "mu.ball", "mu.floor"}) {
    EXPECT_EQ(ParameterName(ParseParameter(name, Names()), Names()), name);
  }
  EXPECT_EQ(ParseParameter("mu", Names()).part, kWhole);
  EXPECT_EQ(ParseParameter("mu.floor", Names()).part, 1);
}

TEST(ParseParameter, ListsTheNamesItKnows) {
  for (const char* name : {"", "k", "mu.", "mu.wall", "mu.ball2", "K_STRETCH"}) {
    ExpectError([&] { ParseParameter(name, Names()); }, ErrorKind::kUsage,
                {"unknown parameter", name, "k_stretch, k_bend, density, drag, damping, k_warp, ",
                 "bend_twist, drag_normal, drag_tangential, added_mass, pressure, mu, mu.ball, mu.floor, mu.self, wind.x, "});
  }
}

TEST(ParseParameterValues, ReadsNamesAndNumbers) {
  EXPECT_TRUE(ParseParameterValues("", "--start").empty());
  const std::map<std::string, double> values = ParseParameterValues("mu=0.1,k_stretch=5e1", "--start");
  EXPECT_EQ(values, (std::map<std::string, double>{{"mu", 0.1}, {"k_stretch", 50.0}}));
  EXPECT_EQ(ParseParameterValues(" mu = 0.1, k_stretch= 5e1 ", "--start"), values);
}

TEST(ParseParameterValues, NamesTheFlagAndWhatIsWrong) {
  const auto expect = [](const char* text, const char* culprit) {
    ExpectError([&] { ParseParameterValues(text, "--start"); }, ErrorKind::kUsage, {"--start: ", culprit});
  };
  for (const char* text : {"mu", "=1", "mu=", "mu=a", "mu=1x", "mu=nan", "mu=inf"}) {
    expect(text, (std::string("NAME=NUMBER, a finite one, got '") + text + "'").c_str());
  }
  for (const char* text : {",", "mu=1,", ",mu=1", "mu=1,,drag=2"}) expect(text, "got ''");
  expect("mu=1,mu=2", "'mu' is given twice");
}

TEST(Parameters, AreReadAndSetById) {
  Parameters parameters;
  parameters.friction_coefficients = {0.1, 0.2};
  double value = 1.0;
  for (const char* name : {"k_stretch", "k_bend", "density", "drag", "damping", "mu.ball", "mu.floor"}) {
    SetParameter(ParseParameter(name, Names()), value += 1.0, &parameters);
  }
  EXPECT_EQ(parameters.material.stretch_stiffness, 2.0);
  EXPECT_EQ(parameters.material.bending_stiffness, 3.0);
  EXPECT_EQ(parameters.material.density, 4.0);
  EXPECT_EQ(parameters.material.drag, 5.0);
  EXPECT_EQ(parameters.material.damping, 6.0);
  EXPECT_EQ(parameters.friction_coefficients, (std::vector<double>{7.0, 8.0}));
  EXPECT_EQ(GetParameter(parameters, ParseParameter("mu.floor", Names())), 8.0);
  EXPECT_EQ(GetParameter(parameters, ParseParameter("density", Names())), 4.0);
}

TEST(Parameters, ShareTheFrictionOfAllObstacles) {
  Parameters parameters;
  parameters.friction_coefficients = {0.1, 0.2};
  const ParameterId all = ParseParameter("mu", Names());
  SetParameter(all, 0.5, &parameters);
  EXPECT_EQ(parameters.friction_coefficients, (std::vector<double>{0.5, 0.5}));
  EXPECT_EQ(GetParameter(parameters, all), 0.5);
  EXPECT_TRUE(std::isnan(GetParameter(Parameters(), all)));
}

TEST(ValidateParameters, NamesWhatIsOutOfRange) {
  Scene scene;
  scene.obstacles.resize(1);
  scene.obstacles[0].name = "ball";
  Parameters parameters = scene.nominal_parameters();
  EXPECT_NO_THROW(ValidateParameters(parameters, scene, "scene.json"));
  for (const char* name : {"k_stretch", "k_bend", "density", "drag", "damping", "mu.ball"}) {
    for (const double value : {-1.0, std::nan(""), HUGE_VAL}) {
      Parameters wrong = parameters;
      SetParameter(ParseParameter(name, {"ball"}), value, &wrong);
      ExpectError([&] { ValidateParameters(wrong, scene, "scene.json"); }, ErrorKind::kBadData, {"scene.json: ", name});
    }
  }
  const auto expect_zero = [&](const char* name, bool allowed) {
    Parameters zero = parameters;
    SetParameter(ParseParameter(name, {"ball"}), 0.0, &zero);
    if (allowed) {
      EXPECT_NO_THROW(ValidateParameters(zero, scene, "scene.json")) << name;
    } else {
      ExpectError([&] { ValidateParameters(zero, scene, "scene.json"); }, ErrorKind::kBadData, {name, "> 0"});
    }
  };
  for (const char* name : {"k_bend", "drag", "damping", "mu.ball"}) expect_zero(name, true);
  for (const char* name : {"k_stretch", "density"}) expect_zero(name, false);
  for (const char* name : {"k_bend", "drag", "damping"}) {
    Parameters more = parameters;
    SetParameter(ParseParameter(name, {"ball"}), 1.0, &more);
    ExpectError([&] { ValidateParameters(more, scene, "scene.json"); }, ErrorKind::kBadData, {name, "without it"});
  }
  parameters.friction_coefficients.clear();
  ExpectError([&] { ValidateParameters(parameters, scene, "scene.json"); }, ErrorKind::kBadData, {"1 obstacles"});
}

}  // namespace
}  // namespace clothid::parameters_test
