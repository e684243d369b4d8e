// Errors by frame and point, histograms, and what is said to limit a fit.
#include "identify/report/fit_quality.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numeric>

#include "tests/costs/synthetic_motion.h"

namespace clothid::fit_quality_test {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

RecordedMotion NoisyMotion() {
  MotionOptions options;
  options.noise = 1e-3;
  RecordedMotion motion = MakeMotion(SwingScene(), options);
  motion.positions.block<3, 1>(3 * 7, 3).setConstant(kNaN);
  motion.positions(3 * 8 + 1, 4) = kNaN;
  return motion;
}

TEST(FitQualityTest, ErrorsOfPointsAndFrames) {
  const RecordedMotion motion = NoisyMotion();
  const Observation observation(motion);
  Eigen::MatrixXd predicted = motion.positions;
  predicted.colwise() += Eigen::VectorXd(Eigen::Vector3d(0.001, 0.002, 0.002).replicate(25, 1));
  const Eigen::MatrixXd errors = PointErrors(observation, motion, predicted);
  ASSERT_EQ(errors.rows(), 25);
  ASSERT_EQ(errors.cols(), motion.num_frames());
  EXPECT_NEAR(errors(12, 5), 0.003, 1e-12);
  EXPECT_TRUE(std::isnan(errors(7, 3))) << "not seen";
  EXPECT_TRUE(std::isnan(errors(0, 5))) << "a handle";
  EXPECT_NEAR(errors(8, 4), std::sqrt(3.0 * (1e-6 + 4e-6) / 2.0), 1e-12) << "by its seen coordinates";
  const Eigen::VectorXd frames = FrameErrors(errors);
  EXPECT_NEAR(frames[5], 0.003, 1e-12);
  EXPECT_NEAR(frames[3], 0.003, 1e-12);

  Eigen::MatrixXd none = errors;
  none.col(2).setConstant(kNaN);
  EXPECT_TRUE(std::isnan(FrameErrors(none)[2]));
}

TEST(FitQualityTest, FrameErrorsAddUpToTheRmse) {
  MotionOptions options;
  options.noise = 1e-3;
  const RecordedMotion motion = MakeMotion(SwingScene(), options);
  const Observation observation(motion);
  const Eigen::MatrixXd predicted = motion.positions.array() + 1e-3 * motion.positions.array().sin();
  const Eigen::VectorXd frames = FrameErrors(PointErrors(observation, motion, predicted));
  EXPECT_NEAR(std::sqrt(frames.squaredNorm() / static_cast<double>(frames.size())),
              observation.Compare(predicted).rmse(), 1e-15);
}

TEST(FitQualityTest, HistogramsCountEveryCoordinate) {
  const RecordedMotion motion = NoisyMotion();
  const Observation observation(motion);
  Eigen::MatrixXd predicted = motion.positions;
  predicted.colwise() += Eigen::VectorXd(Eigen::Vector3d(0.001, -0.0012, 0.009).replicate(25, 1));
  const std::vector<ResidualHistogram> axes = ResidualHistograms(observation, motion, predicted, 0.005, 10);
  ASSERT_EQ(axes.size(), 3u);
  int total = 0;
  for (const ResidualHistogram& axis : axes) {
    total += std::accumulate(axis.counts.begin(), axis.counts.end(), axis.num_beyond);
  }
  EXPECT_EQ(total, observation.num_residuals());
  EXPECT_GT(axes[1].counts[3], 400);
  EXPECT_EQ(axes[1].num_beyond, 0);
  EXPECT_GT(axes[2].num_beyond, 400);
  EXPECT_NEAR(axes[2].mean, 0.009, 1e-12);
  EXPECT_NEAR(axes[2].deviation, 0.0, 1e-9);
}

// Where the first frame is the start of the simulation, it leaves no residual.
TEST(FitQualityTest, HistogramsAreWithoutTheStart) {
  RecordedMotion motion = NoisyMotion();
  const Observation observation(motion);
  Eigen::MatrixXd predicted = motion.positions;
  predicted.rightCols(motion.num_frames() - 1).array() += 0.001;
  const auto count_all = [&] {
    int total = 0;
    for (const ResidualHistogram& axis : ResidualHistograms(observation, motion, predicted, 0.005, 11)) {
      total += std::accumulate(axis.counts.begin(), axis.counts.end(), axis.num_beyond);
    }
    return total;
  };
  motion.start_source = StartSource::kScene;
  EXPECT_FALSE(StartsAtFirstFrame(motion));
  EXPECT_EQ(count_all(), observation.num_residuals());
  for (const StartSource source : {StartSource::kFirstFrame, StartSource::kSmoothed}) {
    motion.start_source = source;
    EXPECT_TRUE(StartsAtFirstFrame(motion));
    EXPECT_EQ(count_all(), observation.num_residuals() - observation.first_row(1));
    const std::vector<ResidualHistogram> axes = ResidualHistograms(observation, motion, predicted, 0.005, 11);
    EXPECT_EQ(axes[0].counts[5], 0) << "no zeros";
    EXPECT_NEAR(axes[0].mean, 0.001, 1e-12);
  }
}

std::vector<std::string> Limits(double sigma, double residual_scale, double correlation, int substeps,
                                SigmaSource source = SigmaSource::kRecorded) {
  MotionOptions options;
  options.noise = 1e-3;
  options.sigma = sigma;
  std::vector<RecordedMotion> motions = {MakeMotion(SwingScene(), options)};
  motions.front().sigma_source = source;
  FitSummary summary;
  summary.uncertainty.emplace();
  summary.uncertainty->residual_scale = residual_scale;
  summary.error.squared_error = 3e-6;
  summary.error.num_coordinates = 9.0;
  summary.error.successive_products = correlation;
  summary.error.successive_squares = 1.0;
  summary.counts.substeps = substeps;
  return FitLimits(summary, motions, {Observation(motions[0])});
}

std::string Joined(const std::vector<std::string>& lines) {
  return std::accumulate(lines.begin(), lines.end(), std::string());
}

TEST(FitQualityTest, LimitsInWords) {
  EXPECT_NE(Joined(Limits(1e-3, 1.02, 0.0, 0)).find("explains the error: residuals are 1.02 times"), std::string::npos);
  EXPECT_NE(Joined(Limits(1e-3, 1.02, 0.0, 0)).find("like the noise of a sensor"), std::string::npos);
  EXPECT_NE(Joined(Limits(1e-3, 3.5, 0.64, 0)).find("3.5 times the noise that the recording states"),
            std::string::npos);
  EXPECT_NE(Joined(Limits(1e-3, 3.5, 0.64, 0, SigmaSource::kGiven)).find("3.5 times the noise that --sigma states"),
            std::string::npos);
  EXPECT_NE(Joined(Limits(1e-3, 1.0, 0.0, 0, SigmaSource::kEstimated))
                .find("The noise that was estimated from the scatter of the points explains"),
            std::string::npos);
  EXPECT_NE(Joined(Limits(1e-3, 3.5, 0.64, 0)).find("Of 1 mm rmse about 0.8 mm last"), std::string::npos);
  EXPECT_NE(Joined(Limits(0.0, 1.1, 0.0, 0)).find("does not state its noise"), std::string::npos);
  EXPECT_EQ(Limits(1e-3, 1e-6, 0.9, 0).size(), 1u) << "rounding has no correlation to speak of";
  EXPECT_NE(Joined(Limits(1e-3, 1.0, 0.0, 1)).find("1 substep was taken"), std::string::npos);
  EXPECT_NE(Joined(Limits(1e-3, 1.0, 0.0, 3)).find("3 substeps were taken"), std::string::npos);
}

}  // namespace
}  // namespace clothid::fit_quality_test
