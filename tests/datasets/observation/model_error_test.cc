// How far a model errs over time, and what rows count by.
#include "datasets/observation/model_error.h"

#include <gtest/gtest.h>

#include <cmath>

#include "datasets/observation/observation.h"
#include "tests/costs/synthetic_forces.h"
#include "tests/costs/synthetic_motion.h"

namespace clothid::model_error_test {
namespace {

const ErrorCurve kCurve = {Eigen::Vector3d(0.0, 0.1, 0.3), Eigen::Vector3d(0.0, 4e-6, 16e-6), 1.0};

TEST(ErrorCurveTest, IsLinearInItsSquareAndConstantBeyondItsKnots) {
  EXPECT_EQ(kCurve.DeviationAt(-1.0), 0.0);
  EXPECT_DOUBLE_EQ(kCurve.DeviationAt(0.05), std::sqrt(2e-6));
  EXPECT_DOUBLE_EQ(kCurve.DeviationAt(0.1), 2e-3);
  EXPECT_DOUBLE_EQ(kCurve.DeviationAt(0.2), std::sqrt(10e-6));
  EXPECT_DOUBLE_EQ(kCurve.DeviationAt(9.0), 4e-3);
  EXPECT_TRUE(kCurve.SharesAt(0.15).isApprox(Eigen::Vector3d(0.0, 0.75, 0.25), 1e-14));
  EXPECT_EQ(ErrorCurve().DeviationAt(0.1), 0.0);
  EXPECT_TRUE(ErrorCurve().is_zero());
  EXPECT_FALSE(kCurve.is_zero());
}

TEST(ModelErrorTest, RowsCountByTheirShareOfTheVariance) {
  constexpr double kSigma = 1e-3, kForceSigma = 0.02;
  MotionOptions options;
  options.noise = options.sigma = kSigma;
  RecordedMotion motion = MakeMotion(SwingScene(), options);
  ForceOptions forces;
  forces.noise = forces.sigma = kForceSigma;
  AddForces(forces, &motion);
  Observation observation(motion);
  EXPECT_EQ(observation.error_weights().size(), 0);
  ModelError error;
  error.CurveOf(PredictedKind::kPoints) = kCurve;
  error.CurveOf(PredictedKind::kPoints).alike = 9.0;
  observation.SetModelError(error);
  const Eigen::VectorXd& weights = observation.error_weights();
  ASSERT_EQ(weights.size(), observation.num_residuals());
  for (int row = 0; row < observation.num_residuals(); ++row) {
    const bool is_force = row >= observation.first_force_row();
    EXPECT_EQ(observation.KindOf(row), is_force ? PredictedKind::kForces : PredictedKind::kPoints);
    EXPECT_EQ(observation.SigmaOf(row), is_force ? kForceSigma : kSigma);
    if (is_force) {
      EXPECT_EQ(weights[row], 1.0);
      continue;
    }
    const double time = motion.times[observation.coordinates()[row].frame];
    EXPECT_EQ(observation.RowTimes()[row], time);
    const double variance = kSigma * kSigma + 9.0 * std::pow(kCurve.DeviationAt(time), 2);
    EXPECT_NEAR(weights[row], kSigma / std::sqrt(variance), 1e-14);
  }
  observation.SetModelError({});
  EXPECT_EQ(observation.error_weights().size(), 0);
}

}  // namespace
}  // namespace clothid::model_error_test
