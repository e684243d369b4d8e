// What a cost function answers Ceres.
#ifndef CLOTHID_TESTS_COSTS_COST_ROWS_H_
#define CLOTHID_TESTS_COSTS_COST_ROWS_H_

#include <ceres/cost_function.h>
#include <gtest/gtest.h>

#include <Eigen/Core>
#include <cmath>
#include <limits>
#include <vector>

#include "costs/rollout_cost.h"
#include "tests/costs/synthetic_motion.h"

namespace clothid {

// What Ceres gets from one call.
struct CeresRows {
  bool ok = false;
  Eigen::VectorXd residuals;
  Eigen::MatrixXd jacobian;  // a column stays NaN where it was not asked for

  double cost() const { return 0.5 * residuals.squaredNorm(); }
  Eigen::VectorXd gradient() const { return jacobian.transpose() * residuals; }
};

inline CeresRows Evaluate(const ceres::CostFunction& cost, const Eigen::VectorXd& coordinates,
                          const std::vector<bool>& wanted) {
  CeresRows rows;
  rows.residuals.resize(cost.num_residuals());
  rows.jacobian.setConstant(cost.num_residuals(), coordinates.size(), std::numeric_limits<double>::quiet_NaN());
  std::vector<const double*> parameters;
  std::vector<double*> jacobians;
  for (Eigen::Index i = 0; i < coordinates.size(); ++i) {
    parameters.push_back(coordinates.data() + i);
    jacobians.push_back(wanted[static_cast<std::size_t>(i)] ? rows.jacobian.col(i).data() : nullptr);
  }
  rows.ok = cost.Evaluate(parameters.data(), rows.residuals.data(), jacobians.data());
  return rows;
}

inline CeresRows EvaluateAll(const ceres::CostFunction& cost, const Eigen::VectorXd& coordinates) {
  return Evaluate(cost, coordinates, std::vector<bool>(static_cast<std::size_t>(coordinates.size()), true));
}

inline double CostAt(const ceres::CostFunction& cost, const Eigen::VectorXd& coordinates) {
  const CeresRows rows =
      Evaluate(cost, coordinates, std::vector<bool>(static_cast<std::size_t>(coordinates.size()), false));
  EXPECT_TRUE(rows.ok);
  return rows.cost();
}

// Expects every component to agree relative to its own size.
inline void ExpectNear(const Eigen::VectorXd& a, const Eigen::VectorXd& b, double tolerance) {
  ASSERT_EQ(a.size(), b.size());
  for (Eigen::Index i = 0; i < a.size(); ++i) EXPECT_NEAR(a[i], b[i], tolerance * std::abs(b[i])) << "component " << i;
}

inline RolloutCostOptions WithJacobian(JacobianMethod method) {
  RolloutCostOptions options;
  options.jacobian = method;
  return options;
}

// Of SwingScene(), with 1 mm of noise, in frames between the steps.
inline RecordedMotion SwingMotion() {
  MotionOptions options;
  options.true_values = {{"k_stretch", 90.0}, {"k_bend", 3e-3}};
  options.frame_interval = 0.0125;
  options.noise = 1e-3;
  return MakeMotion(SwingScene(), options);
}

}  // namespace clothid

#endif  // CLOTHID_TESTS_COSTS_COST_ROWS_H_
