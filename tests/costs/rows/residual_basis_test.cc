// The identities that make the rows of the block adjoint exact.
#include "costs/rows/residual_basis.h"

#include <gtest/gtest.h>

#include <limits>

#include "tests/costs/synthetic_motion.h"

namespace clothid::residual_basis_test {
namespace {

double OrthonormalityError(const Eigen::MatrixXd& basis) {
  return (basis.transpose() * basis - Eigen::MatrixXd::Identity(basis.cols(), basis.cols())).cwiseAbs().maxCoeff();
}

TEST(ResidualBasisTest, KeepsCostAndGradient) {
  std::srand(3);
  const Eigen::VectorXd e = Eigen::VectorXd::Random(200);
  const Eigen::MatrixXd jacobian = Eigen::MatrixXd::Random(200, 3);
  Eigen::MatrixXd vectors = Eigen::MatrixXd::Random(200, 7);
  vectors.col(0) = 1e6 * e;
  const Eigen::MatrixXd basis = OrthonormalBasis(vectors);
  ASSERT_EQ(basis.cols(), 7);
  EXPECT_LT(OrthonormalityError(basis), 1e-14);
  const Eigen::VectorXd rows = basis.transpose() * e;
  EXPECT_NEAR(rows.norm(), e.norm(), 1e-13 * e.norm());
  EXPECT_LT(rows.tail(6).norm(), 1e-13 * e.norm());
  const Eigen::VectorXd gradient = (basis.transpose() * jacobian).transpose() * rows;
  EXPECT_LT((gradient - jacobian.transpose() * e).norm(), 1e-12 * gradient.norm());
}

TEST(ResidualBasisTest, DropsWhatIsDependentOrUnusable) {
  std::srand(4);
  Eigen::MatrixXd vectors = Eigen::MatrixXd::Random(50, 7);
  vectors.col(1) = -3.0 * vectors.col(0);
  vectors.col(2).setZero();
  vectors.col(3)[7] = std::numeric_limits<double>::quiet_NaN();
  vectors.col(5) = vectors.col(0) + 2.0 * vectors.col(4);
  EXPECT_EQ(OrthonormalBasis(vectors).cols(), 3);
  EXPECT_EQ(OrthonormalBasis(Eigen::MatrixXd::Zero(50, 4)).cols(), 0);
}

TEST(ResidualBasisTest, StaysOrthonormalWhereVectorsNearlyAgree) {
  std::srand(5);
  Eigen::MatrixXd vectors = Eigen::MatrixXd::Random(100, 6);
  for (int j = 1; j < 6; ++j) vectors.col(j) = vectors.col(0) + 1e-7 * vectors.col(j);
  const Eigen::MatrixXd basis = OrthonormalBasis(vectors);
  EXPECT_EQ(basis.cols(), 6);
  EXPECT_LT(OrthonormalityError(basis), 1e-13);
}

TEST(ResidualBasisTest, ModesCoverEveryCoordinateOnce) {
  const RecordedMotion motion = MakeMotion(SwingScene(), {});
  const Observation observation(motion);
  const Eigen::MatrixXd modes = DisplacementModes(observation, ResidualDerivative(&observation, motion.positions));
  ASSERT_EQ(modes.cols(), kNumDisplacementModes);
  // A shift of everything by 1 m along every axis is the sum of all modes.
  const Eigen::MatrixXd shift = Eigen::MatrixXd::Ones(motion.positions.rows(), motion.positions.cols());
  EXPECT_TRUE(modes.rowwise().sum().isApprox(observation.Whiten(shift), 1e-14));
  EXPECT_EQ(OrthonormalBasis(modes).cols(), kNumDisplacementModes);
}

}  // namespace
}  // namespace clothid::residual_basis_test
