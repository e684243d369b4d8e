// The closest point of a surface that is given by its points alone: what closed forms of distances are tested against.
#ifndef CLOTHID_TESTS_SIM_OBSTACLE_CLOSEST_ON_PATCHES_H_
#define CLOTHID_TESTS_SIM_OBSTACLE_CLOSEST_ON_PATCHES_H_

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <vector>

namespace clothid {

struct PatchPoint {
  Eigen::Vector3d position;  // m
  Eigen::Vector3d outward;   // unit normal
};

// A part of a surface over (u, v) in [0, 1]^2.
using Patch = std::function<PatchPoint(double u, double v)>;

// The nearest of a grid of points; then of ones around it, finer where it stays, down to 1e-10 of the patch.
inline PatchPoint ClosestOnPatch(const Patch& patch, const Eigen::Vector3d& x) {
  PatchPoint best;
  double least = std::numeric_limits<double>::infinity(), u = 0.5, v = 0.5;
  int half_cells = 16;
  for (double reach = 0.5; reach > 1e-10;) {
    const double middle_u = u, middle_v = v;
    for (int i = -half_cells; i <= half_cells; ++i) {
      for (int j = -half_cells; j <= half_cells; ++j) {
        const double at_u = std::clamp(middle_u + reach * i / half_cells, 0.0, 1.0);
        const double at_v = std::clamp(middle_v + reach * j / half_cells, 0.0, 1.0);
        const PatchPoint point = patch(at_u, at_v);
        const double distance = (x - point.position).squaredNorm();
        if (distance >= least) continue;
        least = distance;
        best = point;
        u = at_u;
        v = at_v;
      }
    }
    const bool stayed = std::max(std::abs(u - middle_u), std::abs(v - middle_v)) < 0.5 * reach;
    if (half_cells > 2) {
      reach *= 0.1;
      half_cells = 2;
    } else if (stayed) {
      reach *= 0.5;
    }
  }
  return best;
}

struct SignedDistance {
  double gap = 0.0;        // m
  Eigen::Vector3d normal;  // of the surface at its closest point, away from it or into it
};

inline SignedDistance ClosestOnPatches(const std::vector<Patch>& patches, const Eigen::Vector3d& x) {
  SignedDistance result;
  double least = std::numeric_limits<double>::infinity();
  for (const Patch& patch : patches) {
    const PatchPoint point = ClosestOnPatch(patch, x);
    const Eigen::Vector3d offset = x - point.position;
    if (offset.norm() >= least) continue;
    least = offset.norm();
    const double sign = offset.dot(point.outward) < 0.0 ? -1.0 : 1.0;
    result.gap = sign * least;
    result.normal = sign * offset.normalized();
  }
  return result;
}

}  // namespace clothid

#endif  // CLOTHID_TESTS_SIM_OBSTACLE_CLOSEST_ON_PATCHES_H_
