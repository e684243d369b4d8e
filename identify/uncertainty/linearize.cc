#include <ceres/crs_matrix.h>

#include <stdexcept>

#include "identify/uncertainty/uncertainty.h"

namespace clothid {

Linearization Linearize(const std::vector<double*>& coordinates, int num_measurements, bool sigma_is_known,
                        ceres::Problem* problem) {
  ceres::Problem::EvaluateOptions options;
  options.parameter_blocks = coordinates;
  double cost = 0.0;
  std::vector<double> gradient;
  ceres::CRSMatrix sparse;
  if (!problem->Evaluate(options, &cost, nullptr, &gradient, &sparse)) {
    throw std::runtime_error("the problem cannot be evaluated at the solution");
  }
  Linearization linearization;
  linearization.jacobian = Eigen::MatrixXd::Zero(sparse.num_rows, static_cast<Eigen::Index>(coordinates.size()));
  for (int row = 0; row < sparse.num_rows; ++row) {
    for (int k = sparse.rows[row]; k < sparse.rows[row + 1]; ++k) {
      linearization.jacobian(row, sparse.cols[k]) = sparse.values[k];
    }
  }
  linearization.gradient = Eigen::Map<Eigen::VectorXd>(gradient.data(), static_cast<Eigen::Index>(gradient.size()));
  linearization.squared_residual = 2.0 * cost;
  linearization.num_measurements = num_measurements;
  linearization.sigma_is_known = sigma_is_known;
  return linearization;
}

}  // namespace clothid
