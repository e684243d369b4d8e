// Intervals hold the truth about as often as they say, whatever was seen and whatever was not known. Every setting is
// fitted to a few recordings that differ by their noise; `tools/benchmark/measure_fits seeds` looks at more.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>
#include <string>

#include "identify/fit/fit.h"
#include "identify/uncertainty/uncertainty.h"
#include "tests/costs/start/forget_start.h"
#include "tests/costs/synthetic_motion.h"
#include "tests/sim/shipped_scenes.h"

namespace clothid::coverage_test {
namespace {

constexpr double kNoise = 1e-3;            // m
constexpr double kTimeOffset = -6e-3;      // s
constexpr double kOutlierDistance = 0.02;  // m
constexpr double kMissing = std::numeric_limits<double>::quiet_NaN();
const std::map<std::string, double> kTruth = {{"mu", 0.24}, {"k_stretch", 70.0}};

struct Setting {
  const char* name;
  double drop_fraction = 0.0, outlier_fraction = 0.0;  // the chance of a point
  double frame_interval = 0.0;                         // s; 0: every step
  bool has_clock_error = false;                        // which is fitted, too
  StartSource start = StartSource::kScene;
  const char* loss = "none";
};

// The shipped drape on a coarser mesh, for 0.5 s.
RecordedMotion ExactDrape(const Setting& setting) {
  Scene scene = ShippedScene("drape", 8);
  scene.duration = 0.5;
  return MakeMotion(scene, {kTruth, 0.0, setting.frame_interval, kNoise});
}

RecordedMotion Seen(const Setting& setting, unsigned seed, RecordedMotion motion) {
  AddLastingNoise(kNoise, 0.0, seed, &motion);
  std::mt19937_64 generator(seed + 1000);
  std::uniform_real_distribution<double> chance(0.0, 1.0);
  std::normal_distribution<double> far(0.0, kOutlierDistance);
  for (int frame = 0; frame < motion.num_frames(); ++frame) {
    for (int p = 0; p < motion.num_points(); ++p) {
      auto point = motion.positions.col(frame).segment<3>(3 * p);
      if (chance(generator) < setting.drop_fraction) point.setConstant(kMissing);
      if (chance(generator) < setting.outlier_fraction) {
        for (double& coordinate : point) coordinate += far(generator);
      }
    }
  }
  if (setting.has_clock_error) motion.times.array() -= kTimeOffset;
  return IsUnknown(setting.start) ? ForgetStart(setting.start, std::move(motion)) : motion;
}

FitSummary FitOf(const Setting& setting, const RecordedMotion& motion) {
  FitOptions options;
  options.parameters = {"mu", "k_stretch"};
  if (setting.has_clock_error) options.parameters.push_back("time_offset");
  options.overrides.start = {{"mu", 0.3}, {"k_stretch", 90.0}};
  options.jacobian = JacobianMethod::kSensitivity;
  options.loss = ParseRobustLoss(setting.loss);
  options.check_interval = false;
  FitProblem problem({motion}, options);
  return Fit(options, &problem);
}

double TruthOf(const std::string& name) { return name == "time_offset" ? kTimeOffset : kTruth.at(name); }

class CoverageTest : public testing::TestWithParam<Setting> {};

INSTANTIATE_TEST_SUITE_P(
    Settings, CoverageTest,
    testing::Values(Setting{"AllPoints"}, Setting{"HalfThePoints", 0.5}, Setting{"FewFrames", 0.0, 0.0, 0.03},
                    Setting{"AClockThatIsOff", 0.0, 0.0, 0.03, true},
                    Setting{"AnUnknownStart", 0.0, 0.0, 0.0, false, StartSource::kRest},
                    Setting{"OutliersUnderARobustLoss", 0.0, 0.05, 0.0, false, StartSource::kScene, "huber:2"}),
    [](const testing::TestParamInfo<Setting>& setting) { return std::string(setting.param.name); });

TEST_P(CoverageTest, IntervalsHoldTheTruth) {
  constexpr int kNumSeeds = 12;
  const RecordedMotion exact = ExactDrape(GetParam());
  int num_intervals = 0, num_covered = 0;
  double squares = 0.0;  // of errors over reported standard deviations
  for (unsigned seed = 1; seed <= kNumSeeds; ++seed) {
    const FitSummary fit = FitOf(GetParam(), Seen(GetParam(), seed, exact));
    EXPECT_EQ(fit.status, FitStatus::kConverged) << fit.message;
    ASSERT_TRUE(fit.uncertainty.has_value()) << fit.message;
    for (std::size_t i = 0; i < fit.parameters.size(); ++i) {
      const ParameterUncertainty& uncertainty = fit.uncertainty->parameters[i];
      const double truth = TruthOf(fit.parameters[i].name);
      squares += std::pow((fit.parameters[i].value - truth) / uncertainty.std, 2);
      num_covered += uncertainty.lower95 <= truth && truth <= uncertainty.upper95;
      ++num_intervals;
    }
  }
  RecordProperty("covered", num_covered);
  RecordProperty("deviation", std::to_string(std::sqrt(squares / num_intervals)));
  // Three standard errors of so few.
  EXPECT_GE(num_covered, 0.8 * num_intervals);
  EXPECT_GT(std::sqrt(squares / num_intervals), 0.5);
  EXPECT_LT(std::sqrt(squares / num_intervals), 1.5);
}

double StdOf(const Setting& setting) {
  const FitSummary fit = FitOf(setting, Seen(setting, 1, ExactDrape(setting)));
  EXPECT_TRUE(fit.uncertainty.has_value()) << fit.message;
  return fit.uncertainty->parameters[1].std;
}

TEST(IntervalWidthTest, LessDataAreLessCertain) {
  const double all = StdOf({"all"});
  EXPECT_NEAR(StdOf({"half", 0.5}) / all, std::sqrt(2.0), 0.3);
  EXPECT_NEAR(StdOf({"few frames", 0.0, 0.0, 0.03}) / all, std::sqrt(3.0), 0.5);
}

TEST(IntervalWidthTest, ARobustLossKeepsItUnderOutliers) {
  const double clean = StdOf({"clean"});
  EXPECT_LT(StdOf({"robust", 0.0, 0.05, 0.0, false, StartSource::kScene, "huber:2"}), 2.0 * clean);
  EXPECT_GT(StdOf({"not robust", 0.0, 0.05}), 3.0 * clean);
}

}  // namespace
}  // namespace clothid::coverage_test
