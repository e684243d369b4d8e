// The robust loss acts per point, and its weights give its gradient.
#include "costs/prediction/robust_loss.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "tests/costs/synthetic_motion.h"
#include "tests/expect_error.h"

namespace clothid::robust_loss_test {
namespace {

RobustLoss Huber(double scale) { return ParseRobustLoss("huber:" + std::to_string(scale)); }

TEST(RobustLossTest, ParsesItsNames) {
  EXPECT_FALSE(ParseRobustLoss("none").is_robust());
  EXPECT_EQ(ParseRobustLoss("huber:2.5").scale, 2.5);
  EXPECT_EQ(ParseRobustLoss("huber:2.5").kind, RobustLoss::Kind::kHuber);
  EXPECT_EQ(ParseRobustLoss("cauchy:3").scale, 3.0);
  EXPECT_EQ(ParseRobustLoss("cauchy:3").kind, RobustLoss::Kind::kCauchy);
  for (const char* text : {"", "huber", "huber:", "huber:0", "huber:-1", "huber:nan", "huber:2x", "cauchy:0",
                           "cauchy:", "cauchy", "cauchy:1e-200", "tukey:1"}) {
    ExpectError([&] { ParseRobustLoss(text); }, ErrorKind::kUsage, {"loss", text});
  }
}

TEST(RobustLossTest, WeighsWholePoints) {
  RecordedMotion motion = MakeMotion(SwingScene(), {});
  motion.positions(3, 0) = std::numeric_limits<double>::quiet_NaN();  // node 1, x of frame 0: two coordinates are left
  const Observation observation(motion);
  Eigen::VectorXd e = Eigen::VectorXd::Zero(observation.num_residuals());
  e.head(5) << 0.3, 0.4, 6.0, 8.0, 0.0;  // node 1: |e| = 0.5; node 2: |e| = 10
  Eigen::VectorXd weights;
  const double cost = LossWeights(Huber(2.0), observation, 0, e, &weights);
  EXPECT_NEAR(cost, 0.5 * (0.25 + 2.0 * 2.0 * 10.0 - 4.0), 1e-12);
  EXPECT_TRUE(weights.head(2).isOnes());
  EXPECT_TRUE(weights.segment(2, 3).isApproxToConstant(std::sqrt(0.2), 1e-14));
  EXPECT_TRUE(weights.tail(weights.size() - 5).isOnes());
}

TEST(RobustLossTest, CauchyForgetsWhatIsFarAway) {
  const Observation observation(MakeMotion(SwingScene(), {}));
  Eigen::VectorXd e = Eigen::VectorXd::Zero(observation.num_residuals());
  e.head(6) << 0.3, 0.4, 0.0, 3e3, 0.0, 4e3;  // |e| = 0.5 and 5000
  Eigen::VectorXd weights;
  const double cost = LossWeights(ParseRobustLoss("cauchy:2"), observation, 0, e, &weights);
  EXPECT_NEAR(cost, 0.5 * 4.0 * (std::log(1.0 + 0.25 / 4.0) + std::log(1.0 + 25e6 / 4.0)), 1e-12);
  EXPECT_TRUE(weights.head(3).isApproxToConstant(std::sqrt(1.0 / (1.0 + 0.25 / 4.0)), 1e-14));
  EXPECT_LT(weights[3] * weights[3] * 5e3, 1e-3) << "its pull";
}

class RobustLossGradientTest : public testing::TestWithParam<const char*> {};
INSTANTIATE_TEST_SUITE_P(Losses, RobustLossGradientTest, testing::Values("huber:2", "cauchy:2", "cauchy:0.1"));

TEST_P(RobustLossGradientTest, WeightsGiveTheGradient) {
  const Observation observation(MakeMotion(SwingScene(), {}));
  std::srand(8);
  const Eigen::VectorXd e = 3.0 * Eigen::VectorXd::Random(30), direction = Eigen::VectorXd::Random(30);
  const RobustLoss loss = ParseRobustLoss(GetParam());
  Eigen::VectorXd weights, unused;
  LossWeights(loss, observation, 0, e, &weights);
  const double step = 1e-6;
  const double difference = (LossWeights(loss, observation, 0, e + step * direction, &unused) -
                             LossWeights(loss, observation, 0, e - step * direction, &unused)) /
                            (2.0 * step);
  EXPECT_NEAR(weights.cwiseAbs2().cwiseProduct(e).dot(direction), difference, 1e-7 * std::abs(difference));
}

// 2 L - |w e|^2 is what the row of the loss is the root of.
TEST_P(RobustLossGradientTest, TheWeightedRowsNeverExceedTheLoss) {
  const Observation observation(MakeMotion(SwingScene(), {}));
  Eigen::VectorXd weights;
  for (const double size : {1e-12, 1e-6, 1e-3, 1.0, 1e3, 1e9}) {
    const Eigen::VectorXd e = Eigen::VectorXd::Constant(30, size);
    const double cost = LossWeights(ParseRobustLoss(GetParam()), observation, 0, e, &weights);
    EXPECT_GE(2.0 * cost, (1.0 - 1e-15) * weights.cwiseProduct(e).squaredNorm()) << size;
  }
}

TEST(RobustLossTest, WithoutLossIsLeastSquares) {
  const Observation observation(MakeMotion(SwingScene(), {}));
  const Eigen::VectorXd e = Eigen::VectorXd::Constant(30, 4.0);
  Eigen::VectorXd weights;
  EXPECT_EQ(LossWeights(RobustLoss(), observation, 0, e, &weights), 0.5 * e.squaredNorm());
  EXPECT_TRUE(weights.isOnes());
}

}  // namespace
}  // namespace clothid::robust_loss_test
