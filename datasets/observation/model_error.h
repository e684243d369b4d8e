// How far a model errs beside the noise of what was measured: a variance that changes over time.
//
// A simulation that starts where the cloth was seen is right there and errs more the longer it runs. A residual of
// noise sigma at the time t then has the variance
//   sigma^2 + tau(t)^2,
// tau the error of the model. But the model errs alike at neighbouring points and times: the mean over n residuals that
// err alike has the variance (sigma^2 + n tau^2)/n, as if they were independent with
//   v = sigma^2 + n tau(t)^2,
// and a row counts by sigma/sqrt(v) of what it would count by without.
#ifndef CLOTHID_DATASETS_OBSERVATION_MODEL_ERROR_H_
#define CLOTHID_DATASETS_OBSERVATION_MODEL_ERROR_H_

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cstddef>

namespace clothid {

// tau^2 over time, linear between knots and constant beyond them.
struct ErrorCurve {
  Eigen::VectorXd times;      // [K] s, increasing; empty: zero
  Eigen::VectorXd variances;  // [K] m^2, of forces N^2, >= 0
  double alike = 1.0;         // n

  // The shares [K] that the knots have in the variance at `time`; they add up to 1.
  Eigen::VectorXd SharesAt(double time) const;
  double DeviationAt(double time) const;  // tau, m or N
  bool is_zero() const { return variances.size() == 0 || variances.isZero(0.0); }
};

// What is predicted: tracked points, distances to the surface of the cloth, forces at handles.
enum class PredictedKind { kPoints, kClouds, kForces };

inline constexpr int kNumPredictedKinds = 3;

// Of one recording.
struct ModelError {
  std::array<ErrorCurve, kNumPredictedKinds> curves;

  const ErrorCurve& CurveOf(PredictedKind kind) const { return curves[static_cast<std::size_t>(kind)]; }
  ErrorCurve& CurveOf(PredictedKind kind) { return curves[static_cast<std::size_t>(kind)]; }
  bool is_zero() const {
    return std::all_of(curves.begin(), curves.end(), [](const ErrorCurve& curve) { return curve.is_zero(); });
  }
};

}  // namespace clothid

#endif  // CLOTHID_DATASETS_OBSERVATION_MODEL_ERROR_H_
