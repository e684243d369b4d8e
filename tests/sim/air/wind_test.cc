// The wind as a function of time, its derivatives, and its keys in scene.json.
#include "sim/air/wind.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "sim/force/air_drag.h"
#include "sim/scene/scene.h"
#include "sim/scene/scene_json.h"
#include "tests/expect_error.h"

namespace clothid::wind_test {
namespace {

Wind FullWind() {
  Wind wind;
  wind.mean = {1.0, -2.0, 0.5};
  wind.gust = {0.0, 3.0, 1.0};
  wind.frequency = 9.0;
  wind.phase = 0.7;
  wind.wave_vector = {1.0, 0.5, 2.0};
  wind.profile.times = Eigen::Vector3d(0.1, 0.4, 0.5);
  wind.profile.velocities.resize(3, 3);
  wind.profile.velocities << 0.0, 1.0, 2.0, 3.0, 3.0, -1.0, 0.5, 0.0, 0.0;
  return wind;
}

// Where the waves are 0.3 rad ahead.
RestPlace Place() { return {Eigen::Vector3d(0.1, 0.2, 0.05), Eigen::Vector3d(-0.2, 0.1, 0.15)}; }

TEST(WindTest, IsMeanProfileAndWave) {
  Wind wind = FullWind();
  const double angle = 9.0 * 0.25 + 0.3 + 0.7;
  const Eigen::Vector3d wave = wind.mean + std::sin(angle) * wind.gust, whole = wave + Eigen::Vector3d(0.5, 3.0, 0.25);
  EXPECT_LT((wind.At(0.25, Place()) - whole).norm(), 1e-14);
  wind.shear = {1.0, 0.5, -2.0};
  EXPECT_LT((wind.At(0.25, Place()) - (1.0 - 0.2 + 0.05 - 0.3) * whole).norm(), 1e-14);
  wind.shear.setZero();
  wind.profile = {};
  EXPECT_LT((wind.At(0.25, Place()) - wave).norm(), 1e-14);
}

TEST(WindTest, ShearIsMeasuredFromTheCentroidOfTheArea) {
  GridOptions grid;
  grid.nodes = {3, 4};
  grid.size = {0.2, 0.6};
  grid.origin = {5.0, -1.0, 2.0};
  const Mesh mesh = MakeGrid(grid);
  Eigen::Vector3d sum = Eigen::Vector3d::Zero(), far = Eigen::Vector3d::Zero();
  for (const RestPlace& place : RestPlaces(mesh.rest_positions, NodeAreas(mesh))) {
    sum += place.from_center;
    far = far.cwiseMax(place.from_center.cwiseAbs());
  }
  EXPECT_LT(sum.norm(), 1e-12);
  std::vector<double> sizes(far.begin(), far.end());
  std::sort(sizes.begin(), sizes.end());
  EXPECT_NEAR(sizes[1], 0.1, 1e-12);
  EXPECT_NEAR(sizes[2], 0.3, 1e-12);
}

TEST(WindTest, AProfileIsConstantBeyondItsEnds) {
  const WindProfile profile = FullWind().profile;
  for (const double time : {-1.0, 0.0, 0.1}) EXPECT_EQ(profile.At(time), profile.velocities.col(0)) << time;
  for (const double time : {0.5, 3.0}) EXPECT_EQ(profile.At(time), profile.velocities.col(2)) << time;
  EXPECT_EQ(profile.At(0.4), profile.velocities.col(1));
}

TEST(WindTest, WeightsOfKnotsMakeTheProfile) {
  const WindProfile profile = FullWind().profile;
  for (const double time : {-1.0, 0.1, 0.2, 0.39, 0.4, 0.45, 0.5, 2.0}) {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (int knot = 0; knot < 3; ++knot) sum += profile.Weight(knot, time) * profile.velocities.col(knot);
    EXPECT_LT((sum - profile.At(time)).norm(), 1e-14) << time;
  }
}

TEST(WindTest, DerivativesAreDifferences) {
  Parameters parameters;
  parameters.wind = FullWind();
  parameters.wind.shear = {1.0, 0.5, -2.0};
  for (const char* name : {"wind.x", "wind.y", "wind.z", "wind.x.1", "wind.y.2", "wind.z.3", "gust.x", "gust.y",
                           "gust.z", "gust.frequency", "gust.phase", "gust.wave.x", "gust.wave.y", "gust.wave.z",
                           "wind.shear.x", "wind.shear.y", "wind.shear.z"}) {
    const ParameterId id = ParseParameter(name, std::vector<std::string>());
    EXPECT_EQ(ParameterName(id, {}), name);
    const double value = GetParameter(parameters, id), step = 1e-6;
    for (const double time : {0.0, 0.2, 0.43, 0.6}) {
      Eigen::Vector3d sides[2];
      for (const int side : {0, 1}) {
        Parameters moved = parameters;
        SetParameter(id, value + (side == 0 ? -step : step), &moved);
        EXPECT_NE(GetParameter(moved, id), value);
        sides[side] = moved.wind.At(time, Place());
      }
      const Eigen::Vector3d derivative = WindDerivative(parameters.wind, id, time, Place());
      EXPECT_LT((derivative - (sides[1] - sides[0]) / (2.0 * step)).norm(), 1e-8) << name << " " << time;
    }
  }
}

TEST(WindTest, NamesOfKnotsAreCountedFromOne) {
  for (const char* name : {"wind.x.0", "wind.x.", "wind.x.01", "wind.x.-1", "wind.x.1.1", "gust.x.1", "wind", "wind.w",
                           "wind.shear.x.1", "gust.wave"}) {
    ExpectError([&] { ParseParameter(name, std::vector<std::string>()); }, ErrorKind::kUsage,
                {"unknown parameter", name, "wind.x, wind.y, wind.z, gust.x"});
  }
  Scene scene;
  ExpectError([&] { ParseParameter("wind.x.1", scene); }, ErrorKind::kUsage, {"wind.x.1", "no such term"});
  scene.wind = FullWind();
  EXPECT_EQ(ParseParameter("wind.y.3", scene).part, 2);
  ExpectError([&] { ParseParameter("wind.y.4", scene); }, ErrorKind::kUsage, {"wind.y.4", "no such term"});
}

std::string WindScene(const std::string& keys) {
  return "{\"clothid_scene\": 2, \"duration\": 0.1, \"mesh\": {\"grid\": {\"nodes\": [2, 2], \"size\": [1, 1]}},\n" +
         keys + "}";
}

TEST(WindTest, IsReadFromJson) {
  const Scene scene = ParseScene(
      WindScene("\"wind\": {\"mean\": [1, 2, 3], \"phase\": 0.5, \"shear\": [0, 2, 1], \"profile\": {\"times\": [0, "
                "0.5], \"velocities\": "
                "[[0, 0, 1], [0, 2, 0]]}}, \"air\": {\"law\": \"quadratic\"}, \"materials\": {\"drag_normal\": 0.6, "
                "\"drag_tangential\": 0.02, \"added_mass\": 0.1},\n"
                "\"parameters\": {\"wind.x\": {\"nominal\": -4}, \"wind.z.1\": {\"lower\": -2, \"upper\": 2}}"),
      "scene.json", "");
  EXPECT_EQ(scene.wind.phase, 0.5);
  EXPECT_EQ(scene.wind.shear, Eigen::Vector3d(0.0, 2.0, 1.0));
  EXPECT_EQ(scene.wind.profile.times, Eigen::Vector2d(0.0, 0.5));
  EXPECT_EQ(scene.wind.profile.velocities.col(1), Eigen::Vector3d(0.0, 2.0, 0.0));
  EXPECT_EQ(scene.air_law, AirLaw::kQuadratic);
  EXPECT_TRUE(scene.has_directional_drag() && scene.has_wind() && !scene.has_drag());
  const Parameters nominal = scene.nominal_parameters();
  EXPECT_EQ(nominal.wind.mean, Eigen::Vector3d(-4.0, 2.0, 3.0));
  EXPECT_EQ(nominal.material.normal_drag, 0.6);
  EXPECT_EQ(nominal.material.tangential_drag, 0.02);
  EXPECT_EQ(nominal.material.added_mass, 0.1);
}

TEST(WindTest, NamesTheKeyThatIsWrong) {
  const auto expect = [](const std::string& keys, const std::string& key, const std::string& expected) {
    ExpectError([&] { ParseScene(WindScene(keys), "scene.json", ""); }, ErrorKind::kBadData,
                {("scene.json:2: key '" + key + "'").c_str(), expected.c_str()});
  };
  expect("\"air\": {\"law\": \"cubic\"}", "air.law", "\"linear\" or \"quadratic\"");
  expect("\"air\": {\"density\": 1}", "air.density", "");
  expect("\"wind\": {\"profile\": {\"times\": [0]}}", "wind.profile.velocities", "missing");
  expect("\"wind\": {\"profile\": {\"times\": [], \"velocities\": []}}", "wind.profile.times", "1 to 10000");
  expect("\"wind\": {\"profile\": {\"times\": [0, 0], \"velocities\": [[0, 0, 0], [0, 0, 0]]}}",
         "wind.profile.times[1]", "above the one before");
  expect("\"wind\": {\"profile\": {\"times\": [0, 1], \"velocities\": [[0, 0, 0]]}}", "wind.profile.velocities",
         "2 velocities");
  expect("\"parameters\": {\"wind.x.1\": {\"nominal\": 1}}", "parameters.wind.x.1", "no such term");
}

TEST(WindTest, ParametersKeepTheTimesOfTheProfile) {
  Scene scene;
  scene.wind = FullWind();
  Parameters parameters = scene.nominal_parameters();
  EXPECT_NO_THROW(ValidateDomains(parameters, scene, "here"));
  parameters.wind.profile.times[1] = 0.3;
  ExpectError([&] { ValidateDomains(parameters, scene, "here"); }, ErrorKind::kBadData, {"here", "times"});
  parameters = scene.nominal_parameters();
  parameters.wind.gust.x() = std::nan("");
  ExpectError([&] { ValidateDomains(parameters, scene, "here"); }, ErrorKind::kBadData, {"here", "wind.gust"});
}

}  // namespace
}  // namespace clothid::wind_test
