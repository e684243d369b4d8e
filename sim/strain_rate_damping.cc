#include "sim/strain_rate_damping.h"

#include <Eigen/Eigenvalues>

namespace clothid {
namespace {

using Gradient = Eigen::Matrix<double, 3, 2>;  // F

Eigen::Matrix2d WithoutNegativeEigenvalues(const Eigen::Matrix2d& matrix) {
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> solver;
  solver.computeDirect(matrix);
  const Eigen::Vector2d clamped = solver.eigenvalues().cwiseMax(0.0);
  return solver.eigenvectors() * clamped.asDiagonal() * solver.eigenvectors().transpose();
}

// Edot over a step of size `time_step` that starts with the metric `start_metric`.
Eigen::Matrix2d StrainRate(const Gradient& gradient, const Eigen::Matrix2d& start_metric, double time_step) {
  return (gradient.transpose() * gradient - start_metric) / (2.0 * time_step);
}

}  // namespace

std::vector<Eigen::Matrix2d> StrainRateDamping::Metrics(const Eigen::VectorXd& positions) const {
  std::vector<Eigen::Matrix2d> metrics;
  metrics.reserve(triangles_->size());
  for (const TriangleElement& triangle : *triangles_) {
    const Gradient gradient = DeformationGradient(triangle, positions);
    metrics.push_back(gradient.transpose() * gradient);
  }
  return metrics;
}

double StrainRateDamping::AddForce(double damping, double time_step, const std::vector<Eigen::Matrix2d>& start_metrics,
                                   const Eigen::VectorXd& positions, Eigen::VectorXd* force) const {
  double potential = 0.0;
  for (size_t t = 0; t < triangles_->size(); ++t) {
    const TriangleElement& triangle = (*triangles_)[t];
    const Gradient gradient = DeformationGradient(triangle, positions);
    const Eigen::Matrix2d rate = StrainRate(gradient, start_metrics[t], time_step);
    potential += 0.5 * time_step * triangle.area * rate.squaredNorm();
    AddNodeForces(triangle, -damping * triangle.area * (gradient * rate), force);
  }
  return potential;
}

// d2(W/eta)/(dx_i dx_j) = a [(g_i . Edot g_j) I + ((g_i . g_j) F F^T + (F g_j) (F g_i)^T)/(2 h)].
void StrainRateDamping::AddHessian(double damping, double time_step, HessianKind kind,
                                   const std::vector<Eigen::Matrix2d>& start_metrics, const Eigen::VectorXd& positions,
                                   BlockMatrix* hessian) const {
  for (size_t t = 0; t < triangles_->size(); ++t) {
    const TriangleElement& triangle = (*triangles_)[t];
    const Gradient gradient = DeformationGradient(triangle, positions);
    Eigen::Matrix2d rate = StrainRate(gradient, start_metrics[t], time_step);
    if (kind == HessianKind::kClamped) rate = WithoutNegativeEigenvalues(rate);
    const double weight = damping * triangle.area;
    const Eigen::Matrix<double, 2, 3>& g = triangle.shape_gradients;
    const Eigen::Matrix3d stress = weight * (g.transpose() * rate * g);
    const Eigen::Matrix3d products = weight / (2.0 * time_step) * (g.transpose() * g);
    const Eigen::Matrix3d square = gradient * gradient.transpose();
    const Eigen::Matrix3d turned = gradient * g;  // column i: F g_i
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) {
        if (!triangle.blocks[i][j].valid()) continue;
        Eigen::Matrix3d block = products(i, j) * square;
        block.noalias() += (weight / (2.0 * time_step)) * turned.col(j) * turned.col(i).transpose();
        block.diagonal().array() += stress(i, j);
        hessian->block(triangle.blocks[i][j]) += block;
      }
    }
  }
}

// d2(W/eta)/(dx_i dx_n,j) = -a/(2 h) [(g_i . g_j) F F_n^T + (F g_j) (F_n g_i)^T]: with dF = sum y_j g_j^T, the rows of
// node i in its product with y are -a/(2 h) F (dF^T F_n + F_n^T dF) g_i.
void StrainRateDamping::AddMixedProduct(double damping, double time_step, const Eigen::VectorXd& positions,
                                        const Eigen::VectorXd& start_positions, const Eigen::MatrixXd& columns,
                                        Eigen::MatrixXd* product) const {
  for (const TriangleElement& triangle : *triangles_) {
    const Gradient weighted = -damping * triangle.area / (2.0 * time_step) * DeformationGradient(triangle, positions);
    const Gradient start = DeformationGradient(triangle, start_positions);
    for (Eigen::Index c = 0; c < columns.cols(); ++c) {
      const Eigen::Matrix2d half_change = start.transpose() * DeformationGradient(triangle, columns.col(c));
      auto column = product->col(c);
      AddNodeForces(triangle, weighted * (half_change + half_change.transpose()), &column);
    }
  }
}

}  // namespace clothid
