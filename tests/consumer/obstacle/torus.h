// A ring lying flat: an obstacle as users of clothid would add one, whose own `clothid::Torus` has any axis.
#ifndef CLOTHID_TESTS_CONSUMER_OBSTACLE_TORUS_H_
#define CLOTHID_TESTS_CONSUMER_OBSTACLE_TORUS_H_

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "sim/obstacle/obstacle.h"

//! [torus]
// All points within `tube_radius` of a horizontal circle. With rho the distance to the axis, e_rho away from it, e_phi
// around it and u = rho - ring_radius:
//   d = sqrt(u^2 + z^2),  phi = d - tube_radius,  n = (u e_rho + z e_z)/d
//   dn/dx = (I - n n^T - e_phi e_phi^T)/d + u/(d rho) e_phi e_phi^T
class Torus : public clothid::Obstacle {
 public:
  Torus(const Eigen::Vector3d& center, double ring_radius, double tube_radius)
      : center_(center), ring_radius_(ring_radius), tube_radius_(tube_radius) {}

  clothid::SurfacePoint Closest(const Eigen::Vector3d& position) const override {
    const Eigen::Vector3d x = position - center_;
    // On the axis and on the circle itself, far from the surface, no direction is better than another: keep it finite.
    const double least = 1e-12 * tube_radius_;
    const double rho = std::max(std::hypot(x.x(), x.y()), least);
    const Eigen::Vector3d e_rho = Eigen::Vector3d(x.x(), x.y(), 0.0) / rho;
    const Eigen::Vector3d e_phi = Eigen::Vector3d::UnitZ().cross(e_rho);
    const double u = rho - ring_radius_;
    const double d = std::max(std::hypot(u, x.z()), least);

    clothid::SurfacePoint result;
    result.gap = d - tube_radius_;
    result.normal = (u * e_rho + x.z() * Eigen::Vector3d::UnitZ()) / d;
    const Eigen::Matrix3d around = e_phi * e_phi.transpose();
    result.normal_gradient =
        (Eigen::Matrix3d::Identity() - result.normal * result.normal.transpose() - around) / d + u / (d * rho) * around;
    return result;
  }

 private:
  Eigen::Vector3d center_;
  double ring_radius_, tube_radius_;  // m
};
//! [torus]

#endif  // CLOTHID_TESTS_CONSUMER_OBSTACLE_TORUS_H_
