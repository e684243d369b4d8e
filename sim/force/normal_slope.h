// How the drag by direction (directional_drag.h) on one triangle depends on its normal, for both sweeps.
#ifndef CLOTHID_SIM_FORCE_NORMAL_SLOPE_H_
#define CLOTHID_SIM_FORCE_NORMAL_SLOPE_H_

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "sim/air/wind.h"
#include "sim/shell/triangle_element.h"

namespace clothid {

// The entry of a corner in a vector [3N], and the mean of all three.
inline Eigen::Vector3d CornerEntry(const TriangleBatch& batch, int corner, int lane, const double* all) {
  return Eigen::Map<const Eigen::Vector3d>(all + batch.rows[corner][lane]);
}

inline Eigen::Vector3d CornerMean(const TriangleBatch& batch, int lane, const double* all) {
  return (CornerEntry(batch, 0, lane, all) + CornerEntry(batch, 1, lane, all) + CornerEntry(batch, 2, lane, all)) / 3.0;
}

// How the force of one triangle depends on its predicted corners: with m = e_1 x e_2, n = m/|m|,
//   df = G dn,   G = p n u_t^T + q I + r u_t u_t^T,   dn = (I - n n^T) dm/|m|,   dm = de_1 x e_2 + e_1 x de_2
// (u . dn is u_t . dn).
class NormalSlope {
 public:
  // `c_n` and `c_t`: times the rest area. `normal` n and `flow` u of the triangle in a lane of `batch`, `positions` x^.
  NormalSlope(AirLaw law, double c_n, double c_t, const TriangleBatch& batch, int lane, const Eigen::Vector3d& normal,
              const Eigen::Vector3d& flow, const Eigen::VectorXd& positions)
      : batch_(batch), lane_(lane), normal_(normal) {
    const Eigen::Vector3d first = CornerEntry(batch, 0, lane, positions.data());
    edge1_ = CornerEntry(batch, 1, lane, positions.data()) - first;
    edge2_ = CornerEntry(batch, 2, lane, positions.data()) - first;
    inverse_ = 1.0 / std::max(edge1_.cross(edge2_).norm(), std::numeric_limits<double>::min());
    const double s = flow.dot(normal);
    tangential_ = flow - s * normal;
    const double size = tangential_.norm();
    if (law == AirLaw::kQuadratic) {
      along_ = 2.0 * c_n * std::abs(s) - c_t * size;
      all_ = (c_n * std::abs(s) - c_t * size) * s;
      across_ = -c_t * s / std::max(size, std::numeric_limits<double>::min());
    } else {
      along_ = c_n - c_t;
      all_ = (c_n - c_t) * s;
      across_ = 0.0;
    }
  }

  // df for changes of the predicted corners in `all` [3N].
  Eigen::Vector3d Times(const double* all) const {
    const Eigen::Vector3d first = CornerEntry(batch_, 0, lane_, all);
    const Eigen::Vector3d de1 = CornerEntry(batch_, 1, lane_, all) - first,
                          de2 = CornerEntry(batch_, 2, lane_, all) - first;
    const Eigen::Vector3d dm = inverse_ * (de1.cross(edge2_) + edge1_.cross(de2));
    const Eigen::Vector3d dn = dm - normal_.dot(dm) * normal_;
    const double tangential = tangential_.dot(dn);
    return along_ * tangential * normal_ + all_ * dn + across_ * tangential * tangential_;
  }

  // Adds the transpose times `force` to the corners in `all`.
  void AddTransposed(const Eigen::Vector3d& force, double* all) const {
    const Eigen::Vector3d by_normal =
        (along_ * normal_.dot(force) + across_ * tangential_.dot(force)) * tangential_ + all_ * force;
    const Eigen::Vector3d by_m = inverse_ * (by_normal - normal_.dot(by_normal) * normal_);
    const Eigen::Vector3d first = edge2_.cross(by_m), second = by_m.cross(edge1_);
    Add(1, first, all);
    Add(2, second, all);
    Add(0, -first - second, all);
  }

 private:
  void Add(int corner, const Eigen::Vector3d& vector, double* all) const {
    Eigen::Map<Eigen::Vector3d>(all + batch_.rows[corner][lane_]) += vector;
  }

  const TriangleBatch& batch_;
  int lane_;
  Eigen::Vector3d normal_, edge1_, edge2_, tangential_;
  double inverse_, along_, all_, across_;  // 1/|m|, p, q and r
};

}  // namespace clothid

#endif  // CLOTHID_SIM_FORCE_NORMAL_SLOPE_H_
