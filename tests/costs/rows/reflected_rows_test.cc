// A reflection changes neither lengths nor products, and nothing that is in order already.
#include "costs/rows/reflected_rows.h"

#include <gtest/gtest.h>

namespace clothid::reflected_rows_test {
namespace {

Eigen::VectorXd LastEntry(double value) {
  Eigen::VectorXd residuals = Eigen::VectorXd::Zero(6);
  residuals[5] = value;
  return residuals;
}

TEST(ReflectedRowsTest, KeepsGradientAndGaussNewtonMatrix) {
  std::srand(3);
  for (int i = 0; i < 20; ++i) {
    const Eigen::MatrixXd jacobian = Eigen::MatrixXd::Random(6, 3);
    Eigen::VectorXd residuals = Eigen::VectorXd::Random(6);
    if (i % 4 == 0) residuals.head(5) *= 1e-9;  // nearly in order, or nearly its opposite
    const Eigen::MatrixXd reflected = ReflectedJacobian(residuals, jacobian);
    EXPECT_LT((reflected.transpose() * reflected - jacobian.transpose() * jacobian).norm(), 1e-14);
    const Eigen::VectorXd gradient = reflected.transpose() * LastEntry(residuals.norm());
    EXPECT_LT((gradient - jacobian.transpose() * residuals).norm(), 1e-14) << residuals.transpose();
  }
}

TEST(ReflectedRowsTest, LeavesWhatIsInOrderBitByBit) {
  std::srand(4);
  const Eigen::MatrixXd jacobian = Eigen::MatrixXd::Random(6, 3);
  EXPECT_EQ(ReflectedJacobian(LastEntry(0.3), jacobian), jacobian);
  EXPECT_EQ(ReflectedJacobian(LastEntry(0.0), jacobian), jacobian);
  EXPECT_TRUE(ReflectedJacobian(LastEntry(-0.3), jacobian).bottomRows(1).isApprox(-jacobian.bottomRows(1), 1e-15));
}

}  // namespace
}  // namespace clothid::reflected_rows_test
