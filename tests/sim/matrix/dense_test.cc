// Decompositions of dense matrices by what defines them.
#include "sim/matrix/dense.h"

#include <gtest/gtest.h>

#include <cmath>

namespace clothid::dense_test {
namespace {

// Its entries are of the size of 1, the same in every run.
Eigen::MatrixXd Entries(Eigen::Index rows, Eigen::Index columns) {
  return Eigen::MatrixXd::NullaryExpr(rows, columns, [](Eigen::Index i, Eigen::Index j) {
    return std::sin(1.3 * static_cast<double>(i + 1) * (static_cast<double>(i) + 2.5 * static_cast<double>(j + 1)));
  });
}

Eigen::MatrixXd Positive(Eigen::Index size) {
  const Eigen::MatrixXd a = Entries(size + 2, size);
  return a.transpose() * a + Eigen::MatrixXd::Identity(size, size);
}

Eigen::MatrixXd WithDependentColumns() {
  Eigen::MatrixXd a = Entries(6, 4);
  a.col(3) = 2.0 * a.col(0) - a.col(1);
  return a;
}

TEST(DenseTest, SpectraGiveTheMatrixBack) {
  const Eigen::MatrixXd a = Positive(5);
  const Spectrum spectrum = SymmetricSpectrum(a);
  EXPECT_TRUE((spectrum.vectors * spectrum.values.asDiagonal() * spectrum.vectors.transpose()).isApprox(a, 1e-13));
  EXPECT_TRUE(spectrum.values.isApprox(SymmetricEigenvalues(a), 1e-13));
  EXPECT_LT(spectrum.values[0], spectrum.values[4]);
  const Eigen::Matrix3d small = a.topLeftCorner<3, 3>();
  const Spectrum3 of_small = SymmetricSpectrum(small);
  EXPECT_TRUE((of_small.vectors * of_small.values.asDiagonal() * of_small.vectors.transpose()).isApprox(small, 1e-13));
}

TEST(DenseTest, TheInverseSquareRootSquaredIsTheInverse) {
  const Eigen::Matrix2d a = Positive(2), root = InverseSquareRoot(a);
  EXPECT_TRUE((root * root * a).isIdentity(1e-13));
  EXPECT_TRUE(root.isApprox(root.transpose(), 1e-15));
}

TEST(DenseTest, FactorsSolve) {
  const Eigen::MatrixXd a = Positive(5), right = Entries(5, 3);
  const SymmetricFactor factor(a);
  EXPECT_TRUE((a * factor.Solve(right)).isApprox(right, 1e-12));
  EXPECT_TRUE((a * factor.SolveOne(right.col(1))).isApprox(right.col(1), 1e-12));
  EXPECT_TRUE((a * factor.Inverse()).isIdentity(1e-12));
}

TEST(DenseTest, RootsAndUpperFactorsHaveTheGramMatrix) {
  const Eigen::MatrixXd a = Entries(7, 4), gram = a.transpose() * a, factor = UpperFactor(a);
  EXPECT_TRUE((factor.transpose() * factor).isApprox(gram, 1e-13));
  EXPECT_TRUE(factor.isUpperTriangular(0.0));
  const Eigen::MatrixXd root = TransposedRoot(gram);
  EXPECT_TRUE((root.transpose() * root).isApprox(gram, 1e-12));
}

// A G A^T A = A, G = (A^T A)^+, whatever the rank.
TEST(DenseTest, PseudoInversesOfGramMatrices) {
  for (const Eigen::MatrixXd& a : {Entries(7, 4), WithDependentColumns(), Entries(3, 5)}) {
    const Eigen::MatrixXd inverse = GramPseudoInverse(a);
    EXPECT_TRUE((a * inverse * a.transpose() * a).isApprox(a, 1e-11)) << a;
    EXPECT_TRUE((inverse * a.transpose() * a * inverse).isApprox(inverse, 1e-11)) << a;
  }
}

TEST(DenseTest, ResidualsOfLeastSquaresAreNormalToTheColumns) {
  const Eigen::MatrixXd a = Entries(7, 3);
  const Eigen::VectorXd inside = a * Eigen::Vector3d(1.0, -2.0, 0.5), values = Entries(7, 5).col(4);
  const auto residuals = LeastSquaresResiduals(a, values);
  ASSERT_TRUE(residuals.has_value());
  EXPECT_LT((a.transpose() * *residuals).norm(), 1e-12);
  EXPECT_LT((*LeastSquaresResiduals(a, inside)).norm(), 1e-12);
  EXPECT_FALSE(LeastSquaresResiduals(WithDependentColumns(), Entries(6, 1).col(0)).has_value());
  EXPECT_FALSE(LeastSquaresResiduals(Entries(2, 3), Entries(2, 1).col(0)).has_value());
}

// The residuals are normal to the columns, and x to what the columns do not see.
TEST(DenseTest, SolutionsOfLeastSquaresAreTheShortest) {
  for (const Eigen::MatrixXd& a : {Entries(7, 4), WithDependentColumns(), Entries(3, 5)}) {
    const Eigen::MatrixXd right = Entries(a.rows(), 2), x = LeastSquaresSolution(a, right);
    EXPECT_LT((a.transpose() * (a * x - right)).norm(), 1e-11) << a;
    EXPECT_LT((x - GramPseudoInverse(a) * (a.transpose() * a) * x).norm(), 1e-11 * x.norm()) << a;
  }
  EXPECT_EQ(LeastSquaresSolution(Eigen::MatrixXd(0, 3), Eigen::MatrixXd(0, 2)), Eigen::MatrixXd::Zero(3, 2));
}

TEST(DenseTest, TheShortestTurnIsAboutTheAxisAcross) {
  const Eigen::Vector3d from(0.3, -2.0, 0.5), to(1.0, 0.4, 0.2);
  const Eigen::Matrix3d turn = ShortestTurn(from, to);
  EXPECT_TRUE((turn * from.normalized()).isApprox(to.normalized(), 1e-14));
  EXPECT_TRUE((turn * from.cross(to)).isApprox(from.cross(to), 1e-14));
  EXPECT_TRUE(ShortestTurn(from, 2.0 * from).isIdentity(1e-14));
  const Eigen::Matrix3d back = ShortestTurn(from, -from);
  EXPECT_TRUE((back * from).isApprox(-from, 1e-14));
  EXPECT_NEAR(back.determinant(), 1.0, 1e-14);
}

TEST(DenseTest, RigidMotionsAreFound) {
  Eigen::Isometry3d motion = Eigen::Isometry3d::Identity();
  motion.rotate(Eigen::AngleAxisd(0.7, Eigen::Vector3d(1.0, 2.0, -0.5).normalized()));
  motion.translation() = Eigen::Vector3d(0.3, -1.0, 2.0);
  const Eigen::Matrix3Xd points = Entries(3, 6), moved = motion * points;
  EXPECT_TRUE(RigidMotion(points, moved).isApprox(motion, 1e-12));
  EXPECT_TRUE(NearestRotation(1.01 * motion.linear()).isApprox(motion.linear(), 1e-12));
}

TEST(DenseTest, PointsOnALineAreCollinear) {
  Eigen::Matrix3Xd points = Eigen::Vector3d(1.0, 2.0, 3.0) * Eigen::RowVectorXd::LinSpaced(5, 0.0, 1.0);
  EXPECT_TRUE(IsCollinear(points, 1e-3));
  points(0, 2) += 0.1;
  EXPECT_FALSE(IsCollinear(points, 1e-3));
}

}  // namespace
}  // namespace clothid::dense_test
