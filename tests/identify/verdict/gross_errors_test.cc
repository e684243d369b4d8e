// A fit with a robust loss is judged by what the loss judges: gross errors that it has discounted are told, and not
// held against estimates that they have not moved.
#include <algorithm>

#include "identify/result/result_json.h"
#include "identify/run.h"
#include "tests/costs/synthetic_motion.h"

namespace clothid::gross_errors_test {
namespace {

constexpr double kNoise = 1e-3, kTruth = 150.0;

// A swing of which a share of the points was taken for something else, up to a metre away.
RecordedMotion WithGrossErrors(double share) {
  MotionOptions options;
  options.true_values = {{"k_stretch", kTruth}};
  options.noise = options.sigma = kNoise;
  RecordedMotion motion = MakeMotion(SwingScene(), options);
  std::mt19937_64 generator(3);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  for (int frame = 0; frame < motion.num_frames(); ++frame) {
    for (int point = 0; point < motion.num_points(); ++point) {
      if (0.5 + 0.5 * uniform(generator) > share) continue;
      for (double& x : motion.positions.col(frame).segment<3>(3 * point)) x += uniform(generator);
    }
  }
  return motion;
}

RunResult FitOf(const RecordedMotion& motion, const std::string& loss) {
  RunOptions options;
  options.targets = {motion};
  options.check_recordings = false;
  options.fit.parameters = {"k_stretch"};
  options.fit.loss = ParseRobustLoss(loss);
  return Identify(options);
}

bool Says(const RunResult& result, const std::string& words) {
  const std::vector<std::string> lines = result.verdict.Lines();
  return std::any_of(lines.begin(), lines.end(),
                     [&](const std::string& line) { return line.find(words) != std::string::npos; });
}

TEST(GrossErrorsTest, WhatALossDiscountsIsNotHeldAgainstAFit) {
  for (const char* loss : {"cauchy:3", "huber:2"}) {
    SCOPED_TRACE(loss);
    const RunResult result = FitOf(WithGrossErrors(0.05), loss);
    EXPECT_NEAR(result.summary.parameters[0].value, kTruth, 0.01 * kTruth);
    EXPECT_GT(result.summary.error.rmse(), 0.1) << "of the size of the cloth, which is 300 mm";
    EXPECT_NE(result.verdict.overall, Usability::kDoNotUse) << result.table;
    EXPECT_EQ(result.exit_code, kExitSuccess) << result.table;
    ASSERT_TRUE(result.checks.recordings[0].discounted) << result.table;
    const Discounted& discounted = *result.checks.recordings[0].discounted;
    EXPECT_NEAR(discounted.share, 0.05, 0.02);
    EXPECT_LT(discounted.error.rmse(), 2.5 * kNoise);
    EXPECT_TRUE(Says(result, "the loss discounts ") && Says(result, "without them, by which the fit is judged"))
        << result.table;
    EXPECT_FALSE(Says(result, "of the size of the cloth") || Says(result, "times the noise")) << result.table;
    EXPECT_NE(ResultJson(result.summary, result.checks, {WithGrossErrors(0.05)}).find("\"discounted\""),
              std::string::npos);
  }
}

// Errors that a fit without a loss has taken for measurements, and more than are gross errors.
TEST(GrossErrorsTest, OthersAreHeldAgainstIt) {
  const RunResult plain = FitOf(WithGrossErrors(0.05), "none");
  EXPECT_FALSE(plain.checks.recordings[0].discounted);
  EXPECT_EQ(plain.verdict.overall, Usability::kDoNotUse) << plain.table;
  const RunResult many = FitOf(WithGrossErrors(0.5), "cauchy:3");
  EXPECT_EQ(many.verdict.overall, Usability::kDoNotUse) << many.table;
}

// Another cloth: nearly every point is wrong, by more than a loss was made for.
TEST(GrossErrorsTest, ALossHidesNoWrongScene) {
  RecordedMotion motion = WithGrossErrors(0.0);
  for (int point = 0; point < motion.num_points(); ++point) {
    motion.positions.row(3 * point + 1).swap(motion.positions.row(3 * point + 2));
  }
  const RunResult result = FitOf(motion, "cauchy:3");
  EXPECT_EQ(result.verdict.overall, Usability::kDoNotUse) << result.table;
}

TEST(GrossErrorsTest, WithoutAnyNothingIsSaid) {
  for (const char* loss : {"cauchy:3", "cauchy:1", "huber:2"}) {
    const RunResult result = FitOf(WithGrossErrors(0.0), loss);
    EXPECT_FALSE(result.checks.recordings[0].discounted) << loss;
    EXPECT_FALSE(Says(result, "discounts")) << result.table;
  }
}

// What is held out is compared by the loss, too.
TEST(GrossErrorsTest, HeldOutFramesHaveThemAsWell) {
  const RecordedMotion motion = WithGrossErrors(0.05);
  const RobustLoss loss = ParseRobustLoss("cauchy:3");
  FitOptions options;
  options.parameters = {"k_stretch"};
  const FitProblem problem({motion}, options);
  const auto held_out = [&](double value) {
    return EvaluateHoldout({motion}, problem.blocks(), Eigen::VectorXd::Constant(1, value), HeldOut::kRecordings, {},
                           loss);
  };
  EXPECT_FALSE(held_out(kTruth).has_failed());
  EXPECT_TRUE(held_out(20.0).has_failed());
  // Squares are those of the gross errors alone, whatever the prediction.
  EXPECT_GT(held_out(kTruth).rmse, 0.99 * held_out(kTruth).nominal_rmse);
  EXPECT_GT(held_out(kTruth).nominal_cost, 1.5 * held_out(kTruth).cost);
}

}  // namespace
}  // namespace clothid::gross_errors_test
