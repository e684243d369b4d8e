// The error of a model over time, from residuals that are made.
#include "identify/uncertainty/model_error_estimate.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace clothid::model_error_estimate_test {
namespace {

constexpr int kRows = 240, kFrames = 80;
constexpr double kStep = 0.01, kSigma = 1e-3;

// Residuals over sigma of a frame's rows: noise, and `size`(t) over sigma times patterns that last.
struct Made {
  int num_patterns = 0;      // 0: every row errs by itself
  double correlation = 0.0;  // from frame to frame
  double (*size)(double time) = [](double) { return 0.0; };
  double noise = 1.0;
};

Eigen::MatrixXd Frames(const Made& made, unsigned seed) {
  std::mt19937 generator(seed);
  std::normal_distribution<double> normal;
  const auto random = [&] { return normal(generator); };
  const int num_patterns = made.num_patterns == 0 ? kRows : made.num_patterns;
  Eigen::MatrixXd patterns = Eigen::MatrixXd::Identity(kRows, kRows);
  if (made.num_patterns > 0) {
    patterns = Eigen::MatrixXd::NullaryExpr(kRows, num_patterns, random) / std::sqrt(num_patterns);
  }
  Eigen::VectorXd state = Eigen::VectorXd::NullaryExpr(num_patterns, random);
  Eigen::MatrixXd frames(kRows, kFrames);
  for (int t = 0; t < kFrames; ++t) {
    const double fresh = std::sqrt(1.0 - made.correlation * made.correlation);
    if (t > 0) state = made.correlation * state + fresh * Eigen::VectorXd::NullaryExpr(num_patterns, random);
    frames.col(t) =
        made.noise * Eigen::VectorXd::NullaryExpr(kRows, random) + made.size(kStep * t) * (patterns * state);
  }
  return frames;
}

ErrorRows RowsOf(const Eigen::MatrixXd& frames) {
  ErrorRows rows;
  for (int t = 0; t < kFrames; ++t) {
    for (int i = 0; i < kRows; ++i) rows.Add(kStep * t, kSigma, frames(i, t) * frames(i, t));
  }
  return rows;
}

ErrorCurve CurveOf(const Eigen::MatrixXd& frames) { return EstimateErrorCurve(RowsOf(frames), 0.0, 1.0); }

double Growing(double time) { return 5.0 * time * time; }

TEST(ModelErrorEstimateTest, FindsWhatGrows) {
  for (unsigned seed = 1; seed <= 5; ++seed) {
    const ErrorCurve curve = CurveOf(Frames({0, 0.0, Growing}, seed));
    ASSERT_FALSE(curve.is_zero());
    EXPECT_EQ(curve.DeviationAt(0.0), 0.0) << "where the cloth was seen";
    for (const double time : {0.3, 0.5, 0.75}) {
      EXPECT_NEAR(curve.DeviationAt(time), kSigma * Growing(time), 0.15 * kSigma * Growing(time) + 0.1 * kSigma)
          << time;
    }
  }
}

TEST(ModelErrorEstimateTest, IsZeroWhereThereIsNothingButNoise) {
  for (unsigned seed = 1; seed <= 100; ++seed) EXPECT_TRUE(CurveOf(Frames({}, seed)).is_zero()) << seed;
}

TEST(ModelErrorEstimateTest, CountsWhatWasFittedAway) {
  const ErrorRows rows = RowsOf(Frames({0, 0.0, Growing}, 1));
  const double all = EstimateErrorCurve(rows, 0.0, 1.0).DeviationAt(0.75);
  EXPECT_GT(EstimateErrorCurve(rows, 0.0, 0.9).DeviationAt(0.75), 1.02 * all);
}

TEST(ModelErrorEstimateTest, TooFewTimesTellNothing) {
  ErrorRows rows;
  for (int i = 0; i < 5; ++i) rows.Add(/*time=*/0.0, /*sigma=*/1.0, /*square=*/1e4);
  EXPECT_TRUE(EstimateErrorCurve(rows, 0.0, 1.0).is_zero());
}

// Every sigma a sum of its own, in another order.
TEST(ModelErrorEstimateTest, RowsOfDifferentSigmasGoTogether) {
  const Eigen::MatrixXd frames = Frames({0, 0.0, Growing}, 1);
  ErrorRows rows;
  for (int i = 0; i < kRows; ++i) {
    for (int t = 0; t < kFrames; ++t) rows.Add(kStep * t, kSigma * (1.0 + 1e-9 * i), frames(i, t) * frames(i, t));
  }
  EXPECT_EQ(rows.sums().size(), static_cast<std::size_t>(kRows * kFrames));
  const ErrorCurve own = EstimateErrorCurve(rows, 0.0, 1.0), together = CurveOf(frames);
  ASSERT_EQ(own.variances.size(), together.variances.size());
  EXPECT_LT((own.variances - together.variances).cwiseAbs().maxCoeff(), 1e-6 * together.variances.maxCoeff());
}

double Constant(double) { return 3.0; }

TEST(NumAlikeTest, CountsRowsThatErrAlike) {
  for (unsigned seed = 1; seed <= 5; ++seed) {
    const double alike = NumAlike(Frames({6, 0.0, Constant}, seed), /*is_absorbed=*/false);
    EXPECT_GT(alike, 0.6 * kRows / 6.0);
    EXPECT_LT(alike, 1.6 * kRows / 6.0);
    const double lasting = NumAlike(Frames({6, 0.8, Constant}, seed), false);
    EXPECT_GT(lasting, 0.4 * 9.0 * kRows / 6.0) << "(1 + c)/(1 - c) = 9";
    EXPECT_LT(lasting, 2.5 * 9.0 * kRows / 6.0);
  }
}

TEST(NumAlikeTest, NoiseIsNotAlike) {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    EXPECT_EQ(NumAlike(Frames({}, seed), true), 1.0);
    EXPECT_EQ(NumAlike(Frames({0, 0.0, Constant}, seed), true), 1.0) << "more noise than a recording says";
    EXPECT_EQ(NumAlike(Frames({0, 0.8, Constant}, seed), true), 1.0) << "which lasts";
  }
}

TEST(NumAlikeTest, RowsThatWereNotSeenCountForNothing) {
  Eigen::MatrixXd frames = Frames({6, 0.0, Constant}, 1);
  const double all = NumAlike(frames, false);
  for (Eigen::Index i = 0; i < frames.size(); i += 3) frames.data()[i] = std::nan("");
  EXPECT_NEAR(NumAlike(frames, false), 2.0 / 3.0 * all, 0.15 * all);
}

}  // namespace
}  // namespace clothid::model_error_estimate_test
