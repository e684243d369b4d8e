// GMRES on blocks of right-hand sides, and conjugate gradients.
#include "sim/matrix/krylov.h"

#include <gtest/gtest.h>

#include "sim/matrix/cholesky.h"
#include "tests/sim/matrix/grid_matrix.h"

namespace clothid::krylov_test {
namespace {

using KrylovTest = GridMatrixTest;

TEST_F(KrylovTest, GmresSolvesColumnsOfDifferentDifficulty) {
  const BlockMatrix matrix = Matrix(0.5), symmetric = Matrix(0.0);
  CholeskySolver solver(pattern_);
  const auto factor = solver.Factor(symmetric.values);
  ASSERT_NE(factor, nullptr);
  Eigen::MatrixXd right = Eigen::MatrixXd::Random(pattern_->size(), 4), solution;
  right.col(1).setZero();
  right.col(2) *= 1e-9;
  const auto precondition = [&](const Eigen::MatrixXd& v) {
    Eigen::MatrixXd result;
    factor->Solve(v, &result);
    return result;
  };
  const auto multiply = [&](const Eigen::MatrixXd& v) -> Eigen::MatrixXd { return matrix.view() * v; };
  const GmresResult result = Gmres(multiply, precondition, right, 1e-11, {60}, &solution);
  EXPECT_TRUE(result.converged);
  EXPECT_GT(result.iterations, 2);
  EXPECT_EQ(solution.col(1).norm(), 0.0);
  for (const int c : {0, 2, 3}) {
    EXPECT_LT((matrix.view() * solution.col(c) - right.col(c)).norm(), 1e-10 * right.col(c).norm()) << c;
  }
  EXPECT_FALSE(Gmres(multiply, precondition, right, 1e-11, {2}, &solution).converged);
}

// The eigenvalues 1 .. 100 without a preconditioner take 62 iterations for ten digits.
TEST_F(KrylovTest, GmresGivesUpWhereItIsTooSlow) {
  const Eigen::VectorXd eigenvalues = Eigen::VectorXd::LinSpaced(100, 1.0, 100.0);
  const auto multiply = [&](const Eigen::MatrixXd& v) -> Eigen::MatrixXd { return eigenvalues.asDiagonal() * v; };
  const auto precondition = [](const Eigen::MatrixXd& v) { return v; };
  const Eigen::MatrixXd right = Eigen::VectorXd::Ones(100);
  Eigen::MatrixXd solution;
  const GmresResult patient = Gmres(multiply, precondition, right, 1e-10, {100}, &solution);
  EXPECT_TRUE(patient.converged);
  EXPECT_GT(patient.iterations, 30);
  const GmresResult impatient = Gmres(multiply, precondition, right, 1e-10, {24, true}, &solution);
  EXPECT_FALSE(impatient.converged);
  EXPECT_EQ(impatient.iterations, 6);
  const GmresResult quick = Gmres(multiply, precondition, right, 0.1, {24, true}, &solution);
  EXPECT_TRUE(quick.converged);
  EXPECT_GT(quick.iterations, 6);
}

TEST_F(KrylovTest, ConjugateGradientsSolveAndMeetNegativeCurvature) {
  BlockMatrix matrix = Matrix(0.0);
  CholeskySolver solver(pattern_);
  const auto factor = solver.Factor(matrix.values);
  ASSERT_NE(factor, nullptr);
  const auto precondition = [&](const Eigen::VectorXd& v) -> Eigen::VectorXd {
    Eigen::MatrixXd result;
    factor->Solve(v, &result);
    return result;
  };
  const auto multiply = [&](const Eigen::VectorXd& v) -> Eigen::VectorXd { return matrix.view() * v; };
  const Eigen::VectorXd right = Eigen::VectorXd::Random(pattern_->size());
  Eigen::VectorXd solution;
  matrix.values *= 1.5;
  matrix.block(pattern_->Find(7, 7)) *= 2.0;  // so that the factor is one of another matrix
  ConjugateGradientResult result = ConjugateGradients(multiply, precondition, right, 1e-12, 20, &solution);
  EXPECT_TRUE(result.converged);
  EXPECT_GT(result.iterations, 1);
  EXPECT_LT((matrix.view() * solution - right).norm(), 1.1e-12 * right.norm());
  EXPECT_FALSE(ConjugateGradients(multiply, precondition, right, 1e-12, 1, &solution).converged);
  matrix.block(pattern_->Find(7, 7)) *= -1.0;
  result = ConjugateGradients(multiply, precondition, right, 1e-12, 20, &solution);
  EXPECT_TRUE(result.indefinite);
  EXPECT_FALSE(result.converged);
  result = ConjugateGradients(multiply, precondition, Eigen::VectorXd::Zero(right.size()), 1e-12, 20, &solution);
  EXPECT_TRUE(result.converged);
  EXPECT_EQ(solution.norm(), 0.0);
}

// The residual is that of the matrix, whatever the preconditioner is, so single precision reaches any tolerance. It
// takes as many iterations, or a few more where the matrix is nearly singular.
TEST_F(KrylovTest, APreconditionerInSinglePrecisionIsNearlyAsGood) {
  const auto iterations = [](const BlockMatrix& matrix, const auto& preconditioner, double tolerance) {
    const auto precondition = [&](const Eigen::VectorXd& v) -> Eigen::VectorXd {
      Eigen::MatrixXd result;
      preconditioner.Solve(v, &result);
      return result;
    };
    const auto multiply = [&](const Eigen::VectorXd& v) -> Eigen::VectorXd { return matrix.view() * v; };
    const Eigen::VectorXd right = Eigen::VectorXd::LinSpaced(matrix.pattern().size(), -1.0, 1.0);
    Eigen::VectorXd solution;
    const ConjugateGradientResult result = ConjugateGradients(multiply, precondition, right, tolerance, 60, &solution);
    EXPECT_TRUE(result.converged);
    EXPECT_LT((multiply(solution) - right).norm(), 1.1 * tolerance * right.norm());
    return result.iterations;
  };
  for (const double shift : {14.0, 14.6}) {
    BlockMatrix matrix = Matrix(0.0);
    for (int i = 0; i < pattern_->num_blocks(); ++i) matrix.block(pattern_->Find(i, i)).diagonal().array() -= shift;
    CholeskySolver solver(pattern_);
    const auto factor = solver.Factor(matrix.values);
    ASSERT_NE(factor, nullptr);
    SinglePrecisionFactor single;
    single.Set(factor);
    for (int i = 0; i < pattern_->num_blocks(); i += 3) matrix.block(pattern_->Find(i, i)) *= 1.2;
    for (const double tolerance : {1e-4, 1e-8, 1e-12}) {
      const int in_double = iterations(matrix, *factor, tolerance);
      EXPECT_GT(in_double, 3);
      EXPECT_LE(iterations(matrix, single, tolerance), shift == 14.0 ? in_double : 5 * in_double / 4) << tolerance;
    }
  }
}

}  // namespace
}  // namespace clothid::krylov_test
