// What the answer of every obstacle has to be, whatever its shape.
#ifndef CLOTHID_TESTS_SIM_OBSTACLE_SURFACE_CHECKS_H_
#define CLOTHID_TESTS_SIM_OBSTACLE_SURFACE_CHECKS_H_

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <random>

#include "sim/obstacle/obstacle.h"

namespace clothid {

inline constexpr double kDifferenceStep = 1e-5;  // m, of central differences

struct SurfaceDifferences {
  Eigen::Vector3d normal;
  Eigen::Matrix3d normal_gradient;
};

inline SurfaceDifferences CentralDifferences(const Obstacle& obstacle, const Eigen::Vector3d& x) {
  SurfaceDifferences result;
  for (int k = 0; k < 3; ++k) {
    const Eigen::Vector3d offset = kDifferenceStep * Eigen::Vector3d::Unit(k);
    const SurfacePoint ahead = obstacle.Closest(x + offset), behind = obstacle.Closest(x - offset);
    result.normal[k] = (ahead.gap - behind.gap) / (2.0 * kDifferenceStep);
    result.normal_gradient.col(k) = (ahead.normal - behind.normal) / (2.0 * kDifferenceStep);
  }
  return result;
}

// n against differences of phi, and dn/dx against differences of n.
inline void ExpectDerivatives(const Obstacle& obstacle, const Eigen::Vector3d& x) {
  const SurfacePoint point = obstacle.Closest(x);
  const SurfaceDifferences differences = CentralDifferences(obstacle, x);
  EXPECT_NEAR(point.normal.norm(), 1.0, 1e-15);
  EXPECT_LT((point.normal - differences.normal).norm(), 1e-8) << x.transpose();
  EXPECT_LT((point.normal_gradient - differences.normal_gradient).norm(), 1e-7) << x.transpose();
  EXPECT_LT((point.normal_gradient - point.normal_gradient.transpose()).norm(), 1e-14);
  EXPECT_LT((point.normal_gradient * point.normal).norm(), 1e-13);
}

inline void ExpectFinite(const SurfacePoint& point) {
  EXPECT_TRUE(std::isfinite(point.gap));
  EXPECT_NEAR(point.normal.norm(), 1.0, 1e-15);
  EXPECT_TRUE(point.normal_gradient.allFinite());
}

class RandomPoints {
 public:
  Eigen::Vector3d Next() { return {uniform_(generator_), uniform_(generator_), uniform_(generator_)}; }

 private:
  std::mt19937 generator_{7};
  std::uniform_real_distribution<double> uniform_{-1.0, 1.0};
};

}  // namespace clothid

#endif  // CLOTHID_TESTS_SIM_OBSTACLE_SURFACE_CHECKS_H_
