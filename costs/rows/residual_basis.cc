#include "costs/rows/residual_basis.h"

#include <cmath>

namespace clothid {
namespace {

// A vector of which less than this share is left after projection is dependent. Well above rounding, so that the second
// projection restores orthogonality.
constexpr double kDependent = 1e-10;

int TimeWindow(int index, int count) { return index * kNumTimeWindows / count; }

}  // namespace

Eigen::MatrixXd DisplacementModes(const Observation& observation, const ResidualDerivative& derivative) {
  Eigen::MatrixXd modes = Eigen::MatrixXd::Zero(observation.num_residuals(), kNumDisplacementModes);
  for (int r = 0; r < observation.first_force_row(); ++r) {
    const int window = TimeWindow(observation.coordinates()[r].frame, observation.num_frames());
    modes.block<1, 3>(r, 3 * window) = derivative.OfShift(r);
  }
  const ForceObservation& forces = observation.forces();
  for (int r = 0; r < forces.num_residuals(); ++r) {
    const SeenForce& seen = forces.seen()[r];
    const int window = TimeWindow(seen.reading, forces.num_readings());
    modes(observation.first_force_row() + r, 3 * window + seen.row % 3) = 1.0 / forces.sigma(seen.row / 3);
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
