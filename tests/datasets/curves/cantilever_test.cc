#include "datasets/curves/cantilever.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "datasets/curves/heavy_elastica.h"
#include "datasets/motion/motion_file.h"
#include "sim/rollout/rollout.h"
#include "sim/rollout/simulator.h"
#include "tests/expect_error.h"
#include "tests/temporary_folder.h"

namespace clothid::cantilever_test {
namespace {

constexpr double kRadians = 0.017453292519943295;  // of a degree
constexpr double kWeight = 0.15 * 9.81;            // N/m^2

// The tip of a strip of unit length by shooting from the clamp: theta'(0) until theta'(1) = 0 of
// theta'' = -(1 - s) cos(theta)/(c/L)^3, by Runge and Kutta; z upwards.
Eigen::Vector2d ShootElastica(double share) {
  constexpr int kSteps = 2000;
  const double load = 1.0 / (share * share * share), h = 1.0 / kSteps;
  const auto rates = [&](double s, const Eigen::Vector4d& y) {
    return Eigen::Vector4d(y[1], -load * (1.0 - s) * std::cos(y[0]), std::cos(y[0]), -std::sin(y[0]));
  };
  const auto end = [&](double curvature) {
    Eigen::Vector4d y(0.0, curvature, 0.0, 0.0);
    for (int i = 0; i < kSteps; ++i) {
      const double s = i * h;
      const Eigen::Vector4d k1 = rates(s, y), k2 = rates(s + 0.5 * h, y + 0.5 * h * k1);
      const Eigen::Vector4d k3 = rates(s + 0.5 * h, y + 0.5 * h * k2), k4 = rates(s + h, y + h * k3);
      y += h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4);
    }
    return y;
  };
  // The smallest root: with less curvature at the clamp the tip bends upwards.
  double low = 0.0, high = 0.5 * load;
  for (int i = 0; i < 60; ++i) {
    const double middle = 0.5 * (low + high);
    (end(middle)[1] < 0.0 ? low : high) = middle;
  }
  return end(0.5 * (low + high)).tail<2>();
}

double Peirce(double angle) { return std::cbrt(std::cos(0.5 * angle) / (8.0 * std::tan(angle))); }

CantileverStrip Strip(double overhang) {
  CantileverStrip strip;
  strip.overhang = overhang;
  strip.density = 0.15;
  strip.sigma = 1e-3;
  strip.nominal = 1e-4;
  return strip;
}

TEST(HeavyElasticaTest, AgreesWithShootingFromTheClamp) {
  for (const double degrees : {2.0, 15.0, 41.5, 60.0}) {
    const SaggingStrip strip = SagOfAngle(degrees * kRadians);
    const Eigen::Vector2d tip = ShootElastica(strip.bending_length);
    EXPECT_NEAR(std::atan2(-tip.y(), tip.x()), degrees * kRadians, 1e-5);
    EXPECT_NEAR(strip.tip_x, tip.x(), 1e-5);
    EXPECT_NEAR(strip.tip_z, tip.y(), 1e-5);
    const SaggingStrip same = SagOfBendingLength(strip.bending_length);
    EXPECT_NEAR(same.tip_z, strip.tip_z, 1e-9);
  }
}

TEST(HeavyElasticaTest, PeircesFormulaIsCloseToIt) {
  const auto ratio = [](double degrees) {
    return std::pow(Peirce(degrees * kRadians) / SagOfAngle(degrees * kRadians).bending_length, 3);
  };
  EXPECT_NEAR(ratio(12.0), 1.004, 1e-3);
  EXPECT_NEAR(ratio(30.0), 1.03, 2e-3);
  EXPECT_NEAR(ratio(41.5), 1.057, 3e-3);
  EXPECT_NEAR(ratio(60.0), 1.14, 3e-3);
  // Small angles are those of a beam: L^3/(8 c^3).
  EXPECT_NEAR(std::pow(SagOfAngle(kLeastSag).bending_length, -3) / 8.0, std::tan(kLeastSag), 1e-3 * kLeastSag);
}

TEST(CantileverRecordingTest, ARolloutComesToRestAsTheElasticaDoes) {
  for (const double degrees : {15.0, 41.5, 65.0}) {
    for (const double overhang : {0.05, 0.2}) {
      const SaggingStrip sag = SagOfAngle(degrees * kRadians);
      CantileverStrip strip = Strip(overhang);
      strip.nominal = kWeight * std::pow(sag.bending_length * overhang, 3);
      const Eigen::Vector2d tip = overhang * Eigen::Vector2d(sag.tip_x, sag.tip_z);
      const RecordedMotion motion = InterpretMotion(RecordCantilever(tip, strip, "strip"), "strip");
      const int num_steps = motion.scene.num_steps();
      Simulator simulator(motion.scene);
      const Rollout rollout = Simulate(motion.scene.nominal_parameters(), num_steps, &simulator);
      ASSERT_TRUE(rollout.ok());
      const Eigen::Vector3d end = rollout.positions(num_steps).segment<3>(3 * motion.points[0].nodes[0]);
      const Eigen::Vector3d before = rollout.positions(num_steps - 5).segment<3>(3 * motion.points[0].nodes[0]);
      EXPECT_LT((end - before).norm(), 1e-5 * overhang) << degrees << " " << overhang;
      EXPECT_EQ(motion.positions.col(motion.num_frames() - 1)[0], tip.x());
      // By the angle that a bench would read.
      const double length = overhang * SagOfAngle(std::atan2(-end.z(), end.x())).bending_length;
      EXPECT_NEAR(kWeight * std::pow(length, 3) / strip.nominal, 1.0, 3e-3) << degrees << " " << overhang;
    }
  }
}

TEST(CantileverRecordingTest, IsSeenAtRestAlone) {
  Eigen::Matrix2Xd profile(2, 5);
  profile << 0.02, 0.04, 0.06, 0.08, 0.09, -0.002, -0.01, -0.02, -0.04, -0.05;
  CantileverStrip strip = Strip(0.1);
  const RecordedMotion tip = InterpretMotion(RecordCantilever({0.08, -0.05}, strip, "strip"), "strip");
  EXPECT_EQ(tip.scene.start_time, 0.0);
  EXPECT_TRUE(tip.positions.leftCols(tip.num_frames() - 1).array().isNaN().all());
  EXPECT_TRUE(std::isnan(tip.positions(1, tip.num_frames() - 1)));  // sideways nothing was measured
  EXPECT_EQ(tip.scene.bending.orthotropic, false);
  const Eigen::Vector3d rest = tip.scene.mesh.rest_positions.col(tip.points[0].nodes[0]);
  EXPECT_LT((rest - Eigen::Vector3d(0.1, 0.0, 0.0)).norm(), 1e-12);
  strip.has_warp = true;
  for (const auto& [direction, name] : {std::pair(PullDirection::kWarp, "bend_warp"),
                                        {PullDirection::kWeft, "bend_weft"},
                                        {PullDirection::kBias, "bend_twist"}}) {
    strip.direction = direction;
    EXPECT_EQ(ParameterOfCantilever(strip), name);
    const RecordedMotion cloud = InterpretMotion(RecordProfile(profile, strip, "strip"), "strip");
    EXPECT_TRUE(cloud.scene.bending.orthotropic);
    EXPECT_EQ(cloud.clouds.back().row(2).tail(5), profile.row(1));
    EXPECT_TRUE(cloud.clouds.back().col(0).isZero(0.0));
    EXPECT_EQ(cloud.clouds.front().cols(), 0);
  }
  strip.density = 0.0;
  ExpectError([&] { RecordProfile(profile, strip, "strip"); }, ErrorKind::kUsage, {"expected numbers > 0"});
}

class CantileverTableTest : public testing::Test {
 protected:
  CantileverTable Read(const std::string& text) const { return ReadCantileverTable(folder_.Write("b.csv", text)); }

  void ExpectRefused(const std::string& text, const char* place, const char* expected) const {
    ExpectError([&] { Read(text); }, ErrorKind::kBadData, {place, expected});
  }

  TemporaryFolder folder_;
};

TEST_F(CantileverTableTest, ReadsOverhangsAnglesAndProfiles) {
  CantileverTable table = Read("Specimen;Overhang [cm];Angle\n;;\xc2\xb0\n1;10,0;41,5\n2;11;42\n");
  EXPECT_NEAR(table.overhangs[1], 0.11, 1e-15);
  EXPECT_NEAR(table.angles[0], kBenchAngle, 1e-8);
  EXPECT_FALSE(table.is_bench_angle || table.is_profile());
  EXPECT_NEAR(table.BendingLengths()[0], 0.04999, 1e-5);
  table = Read("Overhang [mm]\n100,0\n");
  EXPECT_TRUE(table.is_bench_angle);
  EXPECT_NEAR(table.BendingLengths()[0], 0.04999, 1e-5);
  table = Read("x,y\nmm,mm\n20,1\n40,4\n60,9\n80,16\n100,25\n");
  EXPECT_TRUE(table.is_profile() && table.is_turned);
  EXPECT_EQ(table.profile(1, 4), -0.025);
  EXPECT_NEAR(table.overhangs[0], 0.10399, 1e-5);
  EXPECT_NEAR(table.angles[0], std::atan(0.25), 1e-12);
}

TEST_F(CantileverTableTest, RefusesBadTables) {
  const std::string header = "Overhang [mm];Angle [deg]\n", points = "x [mm];z [mm]\n";
  ExpectRefused("Length [mm];Angle [deg]\n100;40\n", "b.csv:2: ", "of overhang alone; or of x and z of a profile");
  ExpectRefused("Overhang;Angle [deg]\n100;40\n", "b.csv:1: column 'Overhang'", "mm, cm or m, found none");
  ExpectRefused("Overhang [mm];Angle [grad]\n100;40\n", "b.csv:1: column 'Angle [grad]'",
                "expected the unit deg or rad");
  ExpectRefused(header, "b.csv:1: ", "expected rows of numbers");
  ExpectRefused(header + "100;40\n0;41\n", "b.csv:3: ", "expected an overhang of 5 to 1000 mm, found 0 mm");
  ExpectRefused(header + "100;88\n", "b.csv:2: ", "expected an angle of 1 to 75 degrees below the level, found 88");
  ExpectRefused("Overhang [mm];Angle [rad]\n100;41.5\n", "b.csv:2: ", "expected an angle of 1 to 75 degrees");
  ExpectRefused(points + "20;-1\n40;-4\n", "b.csv:3: ", "expected at least 5 points of a profile, found 2");
  ExpectRefused(points + "20;-1\n40;-4\n30;-9\n80;-16\n90;-25\n", "b.csv:4: ", "on, forwards");
  ExpectRefused(points + "20;-1\n30;-2\n40;-4\n50;-9\n150;-50\n", "b.csv:6: ", "expected points all along the strip");
  ExpectRefused(points + "20;-1\n40;1\n60;-1\n80;1\n90;0\n", "b.csv:6: ", "expected a profile that sags");
}

}  // namespace
}  // namespace clothid::cantilever_test
