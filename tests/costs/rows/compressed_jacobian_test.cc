// The running QR keeps cost, gradient and Gauss-Newton matrix.
#include "costs/rows/compressed_jacobian.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace clothid::compressed_jacobian_test {
namespace {

// Compresses [jacobian residuals] handed over in pieces of `piece` rows and compares the small problem with the large
// one.
void ExpectSameProblem(const Eigen::MatrixXd& jacobian, const Eigen::VectorXd& residuals, Eigen::Index piece) {
  const Eigen::Index p = jacobian.cols();
  CompressedJacobian compressed(static_cast<int>(p));
  for (Eigen::Index row = 0; row < residuals.size(); row += piece) {
    const Eigen::Index count = std::min(piece, residuals.size() - row);
    compressed.Add(jacobian.middleRows(row, count), residuals.segment(row, count));
  }
  const Eigen::MatrixXd factor = compressed.Factor();
  ASSERT_EQ(factor.rows(), p + 1);
  const Eigen::MatrixXd small = factor.leftCols(p);
  const Eigen::VectorXd e = factor.col(p);
  const double scale = jacobian.squaredNorm() + residuals.squaredNorm();
  EXPECT_NEAR(e.squaredNorm(), residuals.squaredNorm(), 1e-13 * scale);
  EXPECT_LT((small.transpose() * e - jacobian.transpose() * residuals).norm(), 1e-13 * scale);
  EXPECT_LT((small.transpose() * small - jacobian.transpose() * jacobian).norm(), 1e-13 * scale);
}

TEST(CompressedJacobianTest, KeepsTheProblemForAnyPieces) {
  std::srand(6);
  for (Eigen::Index rows : {1, 3, 511, 512, 2000}) {
    for (Eigen::Index piece : {1, 7, 600, 5000}) {
      ExpectSameProblem(Eigen::MatrixXd::Random(rows, 3), Eigen::VectorXd::Random(rows), piece);
    }
  }
}

TEST(CompressedJacobianTest, AllowsZeroAndDependentColumns) {
  std::srand(7);
  Eigen::MatrixXd jacobian = Eigen::MatrixXd::Random(900, 4);
  jacobian.col(1).setZero();
  jacobian.col(3) = 2.0 * jacobian.col(0);
  ExpectSameProblem(jacobian, Eigen::VectorXd::Random(900), 75);
  CompressedJacobian compressed(4);
  compressed.Add(jacobian, Eigen::VectorXd::Random(900));
  EXPECT_EQ(compressed.Factor().col(1).norm(), 0.0);
}

TEST(CompressedJacobianTest, WithoutParametersKeepsTheCost) {
  const Eigen::VectorXd residuals = Eigen::VectorXd::LinSpaced(10, 0.0, 9.0);
  CompressedJacobian compressed(0);
  compressed.Add(Eigen::MatrixXd(10, 0), residuals);
  EXPECT_NEAR(std::abs(compressed.Factor()(0, 0)), residuals.norm(), 1e-13);
}

}  // namespace
}  // namespace clothid::compressed_jacobian_test
