#include "identify/repetition/repetitions.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "identify/uncertainty/uncertainty.h"
#include "tests/identify/repetition/single_fits.h"

namespace clothid {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

TEST(RepetitionsTest, PoolsStiffnessByItsLogarithmAndFrictionByItsValue) {
  const std::vector<SingleFit> fits = {Fit("a", {Stiffness(60.0, 3.0), Friction(0.2, 0.01)}),
                                       Fit("b", {Stiffness(80.0, 4.0), Friction(0.3, 0.01)}),
                                       Fit("c", {Stiffness(70.0, 3.5), Friction(0.25, 0.01)})};
  const Repetitions repetitions = Pool(fits, {"k_stretch", "mu"});
  const Eigen::Vector3d zero = Eigen::Vector3d::Zero();
  const Eigen::Vector3d logs(std::log(60.0), std::log(80.0), std::log(70.0));
  const RandomEffects stretch = PoolRepetitions(logs, Eigen::Vector3d::Constant(0.05), zero);
  const RandomEffects mu = PoolRepetitions(Eigen::Vector3d(0.2, 0.3, 0.25), Eigen::Vector3d::Constant(0.01), zero);
  ASSERT_EQ(repetitions.parameters.size(), 2u);
  const PooledParameter &first = repetitions.parameters[0], &second = repetitions.parameters[1];
  EXPECT_NEAR(first.effects.tau, stretch.tau, 1e-12);
  EXPECT_NEAR(first.mean, std::exp(stretch.mean), 1e-10);
  EXPECT_NEAR(first.lower95, std::exp(stretch.mean - stretch.mean_half_width), 1e-9);
  EXPECT_NEAR(first.next_upper95, std::exp(stretch.mean + stretch.next_half_width), 1e-6);
  EXPECT_EQ(second.mean, mu.mean);
  EXPECT_EQ(second.upper95, mu.mean + mu.mean_half_width);
  EXPECT_EQ(second.next_lower95, mu.mean - mu.next_half_width);
}

TEST(RepetitionsTest, IntervalsEndAtTheBounds) {
  SingleEstimate a = Friction(0.02, 0.01), b = Friction(0.1, 0.01), c = Friction(0.06, 0.01);
  for (SingleEstimate *estimate : {&a, &b, &c}) {
    estimate->lower_bound = 0.0;
    estimate->upper_bound = 2.0;
  }
  b.upper_bound = 0.15;
  const PooledParameter open =
      Pool({Fit("a", {Friction(0.02, 0.01)}), Fit("b", {Friction(0.1, 0.01)}), Fit("c", {Friction(0.06, 0.01)})},
           {"mu"})
          .parameters[0];
  EXPECT_LT(open.lower95, 0.0);
  const PooledParameter cut = Pool({Fit("a", {a}), Fit("b", {b}), Fit("c", {c})}, {"mu"}).parameters[0];
  EXPECT_EQ(cut.lower95, 0.0);
  EXPECT_EQ(cut.next_lower95, 0.0);
  EXPECT_EQ(cut.upper95, open.upper95) << "the widest bounds count";
  EXPECT_EQ(cut.mean, open.mean);
}

TEST(RepetitionsTest, TellsLargeDifferencesInPlainNumbers) {
  EXPECT_EQ(DifferenceText(ParameterScale::kLog, 2.173), "220 %");
  EXPECT_EQ(DifferenceText(ParameterScale::kLog, 0.0217), "2.2 %");
}

TEST(RepetitionsTest, ErrorsOfStepAndMeshAreCommon) {
  SingleEstimate a = Stiffness(60.0, 3.0), b = Stiffness(80.0, 4.0), c = Stiffness(70.0, 3.5);
  const Repetitions without = Pool({Fit("a", {a}), Fit("b", {b}), Fit("c", {c})}, {"k_stretch"});
  a.step_error = 0.03 * 60.0;
  a.mesh_error = 0.04 * 60.0;
  b.step_error = 0.05 * 80.0;
  // That of c is not known: it is that of the others.
  const Repetitions with = Pool({Fit("a", {a}), Fit("b", {b}), Fit("c", {c})}, {"k_stretch"});
  const RandomEffects &plain = without.parameters[0].effects, &wide = with.parameters[0].effects;
  EXPECT_EQ(plain.common_error, 0.0);
  EXPECT_NEAR(wide.common_error, 0.05, 1e-12);
  EXPECT_EQ(wide.tau, plain.tau);
  EXPECT_EQ(wide.mean, plain.mean);
  EXPECT_NEAR(wide.mean_half_width, std::hypot(plain.mean_half_width, kNormal95 * 0.05), 1e-12);
}

TEST(RepetitionsTest, LeavesOutWhatTellsNothing) {
  SingleFit failed = Fit("d", {Stiffness(500.0, 1.0)});
  failed.why_not_used = "do not use: the error is of the size of the cloth";
  SingleEstimate frozen = Stiffness(70.0, 3.0);
  frozen.is_frozen = true;
  const Repetitions repetitions =
      Pool({Fit("a", {Stiffness(60.0, kNaN)}), Fit("b", {Stiffness(80.0, 4.0)}), failed, Fit("e", {frozen}),
            Fit("f", {Friction(0.2, 0.1)}), Fit("g", {Stiffness(75.0, 4.0)}), Fit("h", {Stiffness(75.0, 0.0)})},
           {"k_stretch", "mu"});
  EXPECT_EQ(repetitions.parameters[0].fits, (std::vector<int>{1, 5}));
  EXPECT_TRUE(repetitions.parameters[0].is_pooled());
  EXPECT_EQ(repetitions.parameters[1].fits, std::vector<int>{4});
  EXPECT_FALSE(repetitions.parameters[1].is_pooled());
  EXPECT_TRUE(std::isnan(repetitions.parameters[1].mean));
}

TEST(RepetitionsTest, WhatOptimisersLeaveIsNoScatter) {
  const auto of = [](double relative) {
    return Pool({Fit("a", {Stiffness(60.0, 1e-7)}), Fit("b", {Stiffness(60.0 * (1.0 + relative), 1e-7)}),
                 Fit("c", {Stiffness(60.0 * (1.0 - relative), 1e-7)})},
                {"k_stretch"});
  };
  EXPECT_TRUE(of(1e-4).parameters[0].effects.varies());
  EXPECT_FALSE(of(1e-4).any_varies());
  EXPECT_TRUE(of(1e-2).any_varies());
}

TEST(RepetitionsTest, ARecordingCountsOnce) {
  SingleFit a = Fit("a", {}), b = Fit("b", {}), c = Fit("c", {});
  ExpectDifferentRecordings({a, b, c});  // not known
  a.sha256 = c.sha256 = "12";
  b.sha256 = "34";
  ExpectError(
      [&] {
        ExpectDifferentRecordings({a, b, c});
      },
      ErrorKind::kUsage, {"--repeat: c is the recording of a; expected each once"});
}

TEST(RepetitionsTest, TellsBothNumbers) {
  const Repetitions repetitions =
      Pool({Fit("a", {Stiffness(60.0, 0.6)}), Fit("b", {Stiffness(80.0, 0.8)}), Fit("c", {Stiffness(70.0, 0.7)})},
           {"k_stretch"});
  EXPECT_EQ(MeanText(repetitions.parameters[0]),
            "mean of 3 recordings, 95 % interval 48.62 .. 99.41; they scatter by 14 %");
  EXPECT_EQ(DifferenceText(ParameterScale::kLinear, 0.0341), "0.034");
}

}  // namespace
}  // namespace clothid
