// Unknowns that are eliminated: against the inverse of the whole.
#include "identify/uncertainty/marginal.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cstdlib>
#include <vector>

namespace clothid::marginal_test {
namespace {

constexpr Eigen::Index kParameters = 2, kUnknowns = 5, kRows = 12;

struct Case {
  Linearization linearization;
  Eigen::VectorXd residuals;
  Eigen::MatrixXd covariance;  // of all
};

Case MakeCase() {
  std::srand(1);
  Case all;
  all.linearization.jacobian = Eigen::MatrixXd::Random(kRows, kParameters + kUnknowns);
  all.residuals = Eigen::VectorXd::Random(kRows);
  all.linearization.gradient = all.linearization.jacobian.transpose() * all.residuals;
  all.linearization.squared_residual = all.residuals.squaredNorm();
  all.linearization.num_measurements = 7;
  all.linearization.frame_scores = {Eigen::MatrixXd::Random(kParameters + kUnknowns, 3)};
  all.covariance = (all.linearization.jacobian.transpose() * all.linearization.jacobian).inverse();
  return all;
}

TEST(MarginalTest, HasTheBlockOfTheWholeCovariance) {
  const Case all = MakeCase();
  const Marginal marginal = Marginalize(all.linearization, kParameters);
  const Eigen::MatrixXd& jacobian = marginal.parameters.jacobian;
  ASSERT_EQ(jacobian.cols(), kParameters);
  const Eigen::MatrixXd covariance = (jacobian.transpose() * jacobian).inverse();
  EXPECT_LE((covariance - all.covariance.topLeftCorner(kParameters, kParameters)).norm(), 1e-10 * covariance.norm());
  // The Gauss-Newton step of the parameters is that of the whole.
  const Eigen::VectorXd whole = -all.covariance * all.linearization.gradient;
  const Eigen::VectorXd own = -covariance * marginal.parameters.gradient;
  EXPECT_LE((own - whole.head(kParameters)).norm(), 1e-9 * whole.norm());
  EXPECT_EQ(marginal.parameters.squared_residual, all.linearization.squared_residual);
}

// Along (db, F db) the cost rises the least that it can for db.
TEST(MarginalTest, UnknownsFollow) {
  const Case all = MakeCase();
  const Marginal marginal = Marginalize(all.linearization, kParameters);
  Eigen::MatrixXd directions(kParameters + kUnknowns, kParameters);
  directions << Eigen::MatrixXd::Identity(kParameters, kParameters), marginal.follow;
  const Eigen::MatrixXd moved = all.linearization.jacobian * directions;
  const Eigen::MatrixXd& jacobian = marginal.parameters.jacobian;
  EXPECT_LE((moved.transpose() * moved - jacobian.transpose() * jacobian).norm(), 1e-10);
  EXPECT_LE((all.linearization.jacobian.rightCols(kUnknowns).transpose() * moved).norm(), 1e-10) << "none is left";
  const Eigen::MatrixXd scores = directions.transpose() * all.linearization.frame_scores[0];
  EXPECT_LE((marginal.parameters.frame_scores[0] - scores).norm(), 1e-12);
}

TEST(MarginalTest, WithoutUnknownsNothingChanges) {
  const Case all = MakeCase();
  const Marginal marginal = Marginalize(all.linearization, kParameters + kUnknowns);
  EXPECT_EQ(marginal.parameters.jacobian, all.linearization.jacobian);
  EXPECT_EQ(marginal.follow.rows(), 0);
}

}  // namespace
}  // namespace clothid::marginal_test
