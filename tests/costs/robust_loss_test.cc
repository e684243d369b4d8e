// The robust loss acts per point, and its weights give its gradient.
#include "costs/robust_loss.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "tests/costs/synthetic_motion.h"
#include "tests/expect_error.h"

namespace clothid {
namespace {

RobustLoss Huber(double scale) { return ParseRobustLoss("huber:" + std::to_string(scale)); }

TEST(RobustLossTest, ParsesItsNames) {
  EXPECT_FALSE(ParseRobustLoss("none").is_robust());
  EXPECT_EQ(ParseRobustLoss("huber:2.5").scale, 2.5);
  for (const char* text : {"", "huber", "huber:", "huber:0", "huber:-1", "huber:nan", "huber:2x", "cauchy:1"}) {
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

TEST(RobustLossTest, WeightsGiveTheGradient) {
  const Observation observation(MakeMotion(SwingScene(), {}));
  std::srand(8);
  const Eigen::VectorXd e = 3.0 * Eigen::VectorXd::Random(30), direction = Eigen::VectorXd::Random(30);
  const RobustLoss loss = Huber(2.0);
  Eigen::VectorXd weights, unused;
  LossWeights(loss, observation, 0, e, &weights);
  const double step = 1e-6;
  const double difference = (LossWeights(loss, observation, 0, e + step * direction, &unused) -
                             LossWeights(loss, observation, 0, e - step * direction, &unused)) /
                            (2.0 * step);
  EXPECT_NEAR(weights.cwiseAbs2().cwiseProduct(e).dot(direction), difference, 1e-7 * std::abs(difference));
}

TEST(RobustLossTest, WithoutLossIsLeastSquares) {
  const Observation observation(MakeMotion(SwingScene(), {}));
  const Eigen::VectorXd e = Eigen::VectorXd::Constant(30, 4.0);
  Eigen::VectorXd weights;
  EXPECT_EQ(LossWeights(RobustLoss(), observation, 0, e, &weights), 0.5 * e.squaredNorm());
  EXPECT_TRUE(weights.isOnes());
}

}  // namespace
}  // namespace clothid
