// Second derivatives of a function of the plane from its values at some points.
#ifndef CLOTHID_SIM_GEOMETRY_QUADRATIC_FIT_H_
#define CLOTHID_SIM_GEOMETRY_QUADRATIC_FIT_H_

#include <Eigen/Core>

#include "sim/matrix/dense.h"

namespace clothid {

// The weighted least-squares fit by a quadratic. Points near the origin count more.
class QuadraticFit {
 public:
  // `points` [2 x n], at least 3 and not on a line.
  explicit QuadraticFit(const Eigen::Matrix2Xd& points);

  // How well the points tell the three second derivatives, the same for meshes that differ by an affine map: about 0.4
  // on regular ones, 0 where a derivative is left open, as by points on a conic.
  double quality() const;

  // Rows w_11, w_22, w_12 [3 x n] of the derivatives h_ab = sum_i w_ab,i x_i: exact for quadratics, 0 for affine
  // functions. What the points do not tell is taken for 0.
  Eigen::Matrix3Xd Weights() const;

 private:
  Eigen::Matrix3d FromUnit() const;

  Eigen::Matrix2d to_unit_;         // B: q = B (p - mean) have the covariance 1
  Eigen::ArrayXd root_weights_;     // [n]
  double scale_ = 0.0;              // by which the squares of the quadratic terms were divided
  Eigen::MatrixX3d beyond_affine_;  // [n x 3] the quadratic terms without what an affine function has of them
  Spectrum3 gram_;
};

}  // namespace clothid

#endif  // CLOTHID_SIM_GEOMETRY_QUADRATIC_FIT_H_
