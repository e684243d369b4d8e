// Checks of a shape in each of the regions in which another part of it is nearest.
#ifndef CLOTHID_TESTS_SIM_OBSTACLE_REGION_CHECKS_H_
#define CLOTHID_TESTS_SIM_OBSTACLE_REGION_CHECKS_H_

#include <gtest/gtest.h>

#include <functional>
#include <map>
#include <string>
#include <vector>

#include "tests/sim/obstacle/closest_on_patches.h"
#include "tests/sim/obstacle/surface_checks.h"

namespace clothid {

// The name of the region of a point; empty within 1e-3 m of another region or nearer than 0.15 m to where there is no
// derivative.
using RegionOf = std::function<std::string(const Eigen::Vector3d&)>;

// Random points, at least `count` in each of `regions`; none lies in another.
inline std::vector<Eigen::Vector3d> PointsInRegions(const RegionOf& region_of, const std::vector<std::string>& regions,
                                                    int count) {
  std::map<std::string, int> found;
  for (const std::string& region : regions) found[region] = 0;
  std::vector<Eigen::Vector3d> result;
  RandomPoints points;
  for (int i = 0; i < 20000; ++i) {
    const Eigen::Vector3d x = points.Next();
    const std::string region = region_of(x);
    if (region.empty()) continue;
    EXPECT_EQ(found.count(region), 1u) << region;
    if (found[region]++ < count) result.push_back(x);
  }
  for (const auto& [region, number] : found) EXPECT_GE(number, count) << region;
  return result;
}

// n and dn/dx against differences, phi and n against the points of the surface.
inline void ExpectExactInRegions(const Obstacle& obstacle, const std::vector<Patch>& surface, const RegionOf& region_of,
                                 const std::vector<std::string>& regions) {
  for (const Eigen::Vector3d& x : PointsInRegions(region_of, regions, 20)) {
    SCOPED_TRACE(region_of(x));
    ExpectDerivatives(obstacle, x);
    const SurfacePoint point = obstacle.Closest(x);
    const SignedDistance expected = ClosestOnPatches(surface, x);
    EXPECT_NEAR(point.gap, expected.gap, 1e-9) << x.transpose();
    // Where the distance is least it is flat: its point is known to the square root of rounding.
    EXPECT_LT((point.normal - expected.normal).norm(), 1e-5) << x.transpose();
  }
}

// Both answer alike where `moved` is `original`, turned about the origin and then shifted.
inline void ExpectMoved(const Obstacle& original, const Obstacle& moved, const Eigen::Matrix3d& rotation,
                        const Eigen::Vector3d& shift) {
  RandomPoints points;
  for (int i = 0; i < 200; ++i) {
    const Eigen::Vector3d x = points.Next();
    const SurfacePoint before = original.Closest(x), after = moved.Closest(rotation * x + shift);
    const double size = 1.0 + before.normal_gradient.norm();  // near an edge or axis rounding counts as often
    EXPECT_NEAR(after.gap, before.gap, 1e-14) << x.transpose();
    EXPECT_LT((after.normal - rotation * before.normal).norm(), 1e-14 * size) << x.transpose();
    EXPECT_LT((after.normal_gradient - rotation * before.normal_gradient * rotation.transpose()).norm(),
              1e-13 * size * size)
        << x.transpose();
  }
}

}  // namespace clothid

#endif  // CLOTHID_TESTS_SIM_OBSTACLE_REGION_CHECKS_H_
