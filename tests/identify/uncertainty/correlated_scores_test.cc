// Intervals under residuals that are not independent: they contain the truth as often as they say.
#include "identify/uncertainty/correlated_scores.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <random>

#include "identify/uncertainty/uncertainty.h"

namespace clothid::correlated_scores_test {
namespace {

constexpr int kCoordinates = 30, kSeeds = 300;

// A linear problem e = J q - noise with the truth q = 0, J changing in time as those of a moving cloth do.
class LinearProblem {
 public:
  explicit LinearProblem(int num_frames) {
    std::mt19937_64 generator(5);
    std::normal_distribution<double> normal;
    Eigen::MatrixXd patterns(kCoordinates, 3);
    for (double& entry : patterns.reshaped()) entry = 1.0 + normal(generator);
    for (int i = 0; i < num_frames; ++i) {
      const double u = (i + 0.5) / num_frames;
      Eigen::MatrixXd& jacobian = jacobians_.emplace_back(kCoordinates, 2);
      jacobian.col(0) = u * patterns.col(0);
      jacobian.col(1) = std::cos(9.0 * u) * patterns.col(1) + 0.3 * u * patterns.col(2);
    }
  }
  int num_frames() const { return static_cast<int>(jacobians_.size()); }

  // The least-squares estimate for `noise` [coordinates x frames], and the problem there. `q` [2].
  Linearization Solve(const Eigen::MatrixXd& noise, Eigen::Vector2d* q) const {
    Linearization linearization;
    Eigen::Matrix2d normal_matrix = Eigen::Matrix2d::Zero();
    Eigen::Vector2d right = Eigen::Vector2d::Zero();
    linearization.jacobian.resize(kCoordinates * num_frames(), 2);
    for (int i = 0; i < num_frames(); ++i) {
      normal_matrix += jacobians_[i].transpose() * jacobians_[i];
      right += jacobians_[i].transpose() * noise.col(i);
      linearization.jacobian.middleRows(kCoordinates * i, kCoordinates) = jacobians_[i];
    }
    *q = normal_matrix.inverse() * right;
    Eigen::MatrixXd residuals(kCoordinates, num_frames());
    Eigen::MatrixXd& scores = linearization.frame_scores.emplace_back(2, num_frames());
    for (int i = 0; i < num_frames(); ++i) {
      residuals.col(i) = jacobians_[i] * *q - noise.col(i);
      scores.col(i) = jacobians_[i].transpose() * residuals.col(i);
    }
    linearization.gradient = scores.rowwise().sum();
    linearization.squared_residual = residuals.squaredNorm();
    linearization.num_measurements = static_cast<int>(residuals.size());
    linearization.sigma_is_known = false;
    const int pairs = num_frames() - 1;
    const Eigen::MatrixXd from = residuals.leftCols(pairs), to = residuals.rightCols(pairs);
    linearization.autocorrelation = from.cwiseProduct(to).sum() / (0.5 * (from.squaredNorm() + to.squaredNorm()));
    return linearization;
  }

 private:
  std::vector<Eigen::MatrixXd> jacobians_;
};

// AR(1) in time with the correlation `in_time`, of variance 1; a share `common` of the variance is that of all
// coordinates of a frame alike.
Eigen::MatrixXd MakeNoise(int num_frames, double in_time, double common, std::mt19937_64* generator) {
  std::normal_distribution<double> normal;
  Eigen::MatrixXd noise(kCoordinates, num_frames);
  const auto draw = [&] {
    const double shared = std::sqrt(common) * normal(*generator);
    Eigen::VectorXd values(kCoordinates);
    for (double& value : values) value = shared + std::sqrt(1.0 - common) * normal(*generator);
    return values;
  };
  noise.col(0) = draw();
  for (int i = 1; i < num_frames; ++i) {
    noise.col(i) = in_time * noise.col(i - 1) + std::sqrt(1.0 - in_time * in_time) * draw();
  }
  return noise;
}

ParameterBlock Linear(const std::string& name) {
  ParameterBlock block;
  block.name = name;
  block.lower_bound = -100.0;
  block.upper_bound = 100.0;
  return block;
}

struct Coverage {
  double widened = 0.0, independent = 0.0;  // shares of intervals that contain the truth, over parameters and seeds
  double ratio = 0.0;                       // mean of widened over independent width
  int num_widened = 0;
};

Coverage MeasureCoverage(int num_frames, double in_time, double common) {
  const std::vector<ParameterBlock> blocks = {Linear("a"), Linear("b")};
  const LinearProblem problem(num_frames);
  std::mt19937_64 generator(11);
  Coverage coverage;
  for (int seed = 0; seed < kSeeds; ++seed) {
    Eigen::Vector2d q;
    const Linearization linearization = problem.Solve(MakeNoise(num_frames, in_time, common, &generator), &q);
    const Uncertainty result = EstimateUncertainty(blocks, q, linearization);
    coverage.num_widened += result.is_widened;
    for (int i = 0; i < 2; ++i) {
      const ParameterUncertainty& parameter = result.parameters[i];
      const double share = 0.5 / kSeeds;
      if (parameter.lower95 < 0.0 && parameter.upper95 > 0.0) coverage.widened += share;
      if (std::abs(q[i]) < kNormal95 * parameter.independent_std) coverage.independent += share;
      coverage.ratio += share * parameter.widening;
    }
  }
  return coverage;
}

TEST(CorrelatedScoresTest, IntervalsCoverTheTruthUnderNoiseThatLasts) {
  for (const auto& [frames, in_time] : {std::pair(60, 0.5), std::pair(80, 0.7), std::pair(130, 0.85)}) {
    const Coverage coverage = MeasureCoverage(frames, in_time, 0.0);
    EXPECT_EQ(coverage.num_widened, kSeeds) << in_time;
    EXPECT_GE(coverage.widened, 0.9) << in_time;
    EXPECT_LT(coverage.independent, 0.8) << in_time;
    EXPECT_LT(coverage.ratio, 2.0 * std::sqrt((1.0 + in_time) / (1.0 - in_time))) << "no wider than they need be";
  }
}

TEST(CorrelatedScoresTest, IntervalsCoverTheTruthWhereWholeFramesAreOff) {
  for (const double in_time : {0.0, 0.6}) {
    const Coverage coverage = MeasureCoverage(100, in_time, 0.5);
    EXPECT_GE(coverage.widened, 0.9) << in_time;
    EXPECT_LT(coverage.independent, 0.8) << in_time;
  }
}

TEST(CorrelatedScoresTest, IndependentNoiseKeepsItsIntervals) {
  const Coverage coverage = MeasureCoverage(60, 0.0, 0.0);
  EXPECT_LE(coverage.num_widened, kSeeds / 100);
  EXPECT_NEAR(coverage.ratio, 1.0, 0.01);
  EXPECT_NEAR(coverage.widened, 0.95, 0.025);
  EXPECT_NEAR(coverage.widened, coverage.independent, 0.01);
}

// And would hardly change them if it were taken for correlated.
TEST(CorrelatedScoresTest, UnderIndependentNoiseTheSandwichIsTheInverseOfTheNormalMatrix) {
  const LinearProblem problem(200);
  std::mt19937_64 generator(13);
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  constexpr int kRepeats = 40;
  for (int repeat = 0; repeat < kRepeats; ++repeat) {
    Eigen::Vector2d q;
    const Linearization linearization = problem.Solve(MakeNoise(200, 0.0, 0.0, &generator), &q);
    const Eigen::Matrix2d inverse = (linearization.jacobian.transpose() * linearization.jacobian).inverse();
    const Eigen::Matrix2d covariance = CovarianceOfSum({inverse * linearization.frame_scores[0]}, 0.0);
    const double variance = linearization.squared_residual / (linearization.num_measurements - 2);
    sum += (covariance.diagonal().array() / (variance * inverse.diagonal().array())).sqrt().matrix();
  }
  for (const double ratio : sum / kRepeats) EXPECT_NEAR(ratio, 1.0, 0.1);
}

// Two recordings are two pieces: the last frame of one and the first of the other are no neighbours.
TEST(CorrelatedScoresTest, RecordingsAndEmptyFramesStandApart) {
  Eigen::MatrixXd first(1, 3), second(1, 3);
  first << 1.0, 0.0, 2.0;
  second << 0.0, 3.0, 4.0;
  const FrameSeries series = WithoutEmptyFrames({first, second});
  ASSERT_EQ(series.size(), 2u);
  EXPECT_EQ(series[0], (Eigen::MatrixXd(1, 2) << 1.0, 2.0).finished());
  // c = 1/2: z = 1.5 and 2.5; four frames, two recordings, one parameter.
  EXPECT_NEAR(CovarianceOfSum(series, 0.5)(0, 0), (1.5 * 1.5 + 2.5 * 2.5) * 4.0 * (4.0 / 2.0) * (4.0 / 3.0), 1e-12);
  EXPECT_EQ(CovarianceOfSum({first.leftCols(1)}, 0.5)(0, 0), 0.0);
  EXPECT_EQ(ScoreDegreesOfFreedom(series, 0.5), 2.0);
}

TEST(CorrelatedScoresTest, HasTheQuantilesOfStudent) {
  const std::pair<double, double> table[] = {{2.0, 4.302653},  {3.0, 3.182446},  {5.0, 2.570582},
                                             {10.0, 2.228139}, {30.0, 2.042272}, {1e6, 1.959966}};
  for (const auto& [degrees, quantile] : table) EXPECT_NEAR(Student95(degrees), quantile, 1e-4) << degrees;
}

}  // namespace
}  // namespace clothid::correlated_scores_test
