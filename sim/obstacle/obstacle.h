// Shapes of rigid obstacles: signed distance and its first two derivatives.
//
// An obstacle answers one question: at a point x, what are the signed distance phi (positive outside), its gradient n
// (a unit vector) and dn/dx? Friction and contact distance belong to the scene, not to the shape (see `SceneObstacle`).
#ifndef CLOTHID_SIM_OBSTACLE_OBSTACLE_H_
#define CLOTHID_SIM_OBSTACLE_OBSTACLE_H_

#include <Eigen/Core>

namespace clothid {

struct SurfacePoint {
  double gap = 0.0;                                           // phi, m
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();          // n = dphi/dx
  Eigen::Matrix3d normal_gradient = Eigen::Matrix3d::Zero();  // dn/dx, symmetric, 1/m
};

class Obstacle {
 public:
  virtual ~Obstacle() = default;
  // `position` is in m and world axes. The result must be finite for every finite position.
  virtual SurfacePoint Closest(const Eigen::Vector3d& position) const = 0;
};

// phi = n . (x - point), dn/dx = 0.
class Plane : public Obstacle {
 public:
  // `normal` is normalised; its length must be positive.
  Plane(const Eigen::Vector3d& point, const Eigen::Vector3d& normal);
  SurfacePoint Closest(const Eigen::Vector3d& position) const override;

  const Eigen::Vector3d& point() const { return point_; }
  const Eigen::Vector3d& normal() const { return normal_; }

 private:
  Eigen::Vector3d point_, normal_;
};

// phi = |x - center| - radius, dn/dx = (I - n n^T) / |x - center|.
class Sphere : public Obstacle {
 public:
  Sphere(const Eigen::Vector3d& center, double radius);
  SurfacePoint Closest(const Eigen::Vector3d& position) const override;

  const Eigen::Vector3d& center() const { return center_; }
  double radius() const { return radius_; }

 private:
  Eigen::Vector3d center_;
  double radius_;
};

// All points within `radius` of the segment from `from` to `to`: a sphere at the caps, a cylinder between them, where
// dn/dx = (I - n n^T - a a^T) / distance to the axis a.
class Capsule : public Obstacle {
 public:
  Capsule(const Eigen::Vector3d& from, const Eigen::Vector3d& to, double radius);
  SurfacePoint Closest(const Eigen::Vector3d& position) const override;

  const Eigen::Vector3d& from() const { return from_; }
  Eigen::Vector3d to() const { return from_ + length_ * axis_; }
  double radius() const { return radius_; }

 private:
  Eigen::Vector3d from_, axis_;
  double length_, radius_;
};

}  // namespace clothid

#endif  // CLOTHID_SIM_OBSTACLE_OBSTACLE_H_
