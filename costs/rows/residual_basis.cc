#include "costs/rows/residual_basis.h"

#include <cmath>

namespace clothid {
namespace {

// A vector of which less than this share is left after projection is dependent. Well above rounding, so that the second
// projection restores orthogonality.
constexpr double kDependent = 1e-10;

int TimeWindow(const Observation& observation, int row) {
  return observation.coordinates()[row].frame * kNumTimeWindows / observation.num_frames();
}

}  // namespace

Eigen::MatrixXd DisplacementModes(const Observation& observation, const ResidualDerivative& derivative) {
  Eigen::MatrixXd modes = Eigen::MatrixXd::Zero(observation.num_residuals(), kNumDisplacementModes);
  for (int r = 0; r < observation.num_residuals(); ++r) {
    modes.block<1, 3>(r, 3 * TimeWindow(observation, r)) = derivative.OfShift(r);
  }
  return modes;
}

Eigen::MatrixXd OrthonormalBasis(Eigen::MatrixXd vectors) {
  Eigen::MatrixXd& basis = vectors;  // its columns so far are those before the next vector, or fewer
  Eigen::Index rank = 0;
  for (Eigen::Index j = 0; j < vectors.cols(); ++j) {
    Eigen::VectorXd rest = vectors.col(j);
    const double norm = rest.norm();
    if (!(norm > 0.0) || !std::isfinite(norm)) continue;
    rest /= norm;
    for (int pass = 0; pass < 2; ++pass) {
      const Eigen::VectorXd projection = basis.leftCols(rank).transpose() * rest;
      rest -= basis.leftCols(rank) * projection;
    }
    const double left = rest.norm();
    if (left <= kDependent) continue;
    basis.col(rank++) = rest / left;
  }
  basis.conservativeResize(Eigen::NoChange, rank);
  return vectors;
}

}  // namespace clothid
