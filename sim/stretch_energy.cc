#include "sim/stretch_energy.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

namespace clothid {
namespace {

// Below this share of tr C the area ratio s of a collapsing triangle is held, so that S stays invertible.
constexpr double kSmallestAreaRatio = 1e-12;

using Gradient = Eigen::Matrix<double, 3, 2>;  // F

struct PolarFactors {
  Gradient rotation;                // R
  Eigen::Matrix2d inverse_stretch;  // S^-1
  double tau;                       // tr S
};

PolarFactors Polar(const Gradient& gradient) {
  const Eigen::Matrix2d c = gradient.transpose() * gradient;
  const double trace = c.trace();
  const double s = std::max(std::sqrt(std::max(c.determinant(), 0.0)), kSmallestAreaRatio * trace);
  PolarFactors polar;
  polar.tau = std::sqrt(trace + 2.0 * s);
  // (C + s I)^-1 by its adjugate; det(C + s I) = s tau^2.
  Eigen::Matrix2d adjugate;
  adjugate << c(1, 1) + s, -c(0, 1), -c(1, 0), c(0, 0) + s;
  polar.inverse_stretch = adjugate * (polar.tau / ((c(0, 0) + s) * (c(1, 1) + s) - c(0, 1) * c(1, 0)));
  polar.rotation = gradient * polar.inverse_stretch;
  return polar;
}

// S^-1 with its eigenvalues clamped to at most 1.
Eigen::Matrix2d ClampToIdentity(const Eigen::Matrix2d& inverse_stretch) {
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> solver;
  solver.computeDirect(inverse_stretch);
  const Eigen::Vector2d clamped = solver.eigenvalues().cwiseMin(1.0);
  return solver.eigenvectors() * clamped.asDiagonal() * solver.eigenvectors().transpose();
}

}  // namespace

double StretchEnergy::Energy(const Eigen::VectorXd& positions) const {
  double energy = 0.0;
  for (const TriangleElement& triangle : *triangles_) {
    const Gradient gradient = DeformationGradient(triangle, positions);
    energy += 0.5 * triangle.area * (gradient - Polar(gradient).rotation).squaredNorm();
  }
  return energy;
}

double StretchEnergy::AddForce(double stiffness, const Eigen::VectorXd& positions, Eigen::VectorXd* force) const {
  double energy = 0.0;
  for (const TriangleElement& triangle : *triangles_) {
    const Gradient gradient = DeformationGradient(triangle, positions);
    const Gradient strain = gradient - Polar(gradient).rotation;
    energy += 0.5 * triangle.area * strain.squaredNorm();
    AddNodeForces(triangle, -stiffness * triangle.area * strain, force);
  }
  return energy;
}

// B_ij = (g_i . g_j) I - q_i q_j^T/tau - (g_i . S^-1 g_j) n n^T,   q_i = R eps g_i, eps = [0 -1; 1 0], n = R_0 x R_1.
void StretchEnergy::AddHessian(double stiffness, HessianKind kind, const Eigen::VectorXd& positions,
                               BlockMatrix* hessian) const {
  for (const TriangleElement& triangle : *triangles_) {
    const PolarFactors polar = Polar(DeformationGradient(triangle, positions));
    const bool clamp = kind == HessianKind::kClamped;
    const Eigen::Matrix2d inverse_stretch = clamp ? ClampToIdentity(polar.inverse_stretch) : polar.inverse_stretch;
    const double inverse_tau = clamp ? std::min(1.0 / polar.tau, 0.5) : 1.0 / polar.tau;
    const double weight = stiffness * triangle.area;
    const Eigen::Vector3d normal = polar.rotation.col(0).cross(polar.rotation.col(1));
    const Eigen::Matrix3d normal_square = normal * normal.transpose();

    const Eigen::Matrix<double, 2, 3>& g = triangle.shape_gradients;
    Eigen::Matrix<double, 2, 3> turned;
    turned.row(0) = -g.row(1);
    turned.row(1) = g.row(0);
    const Eigen::Matrix3d q = polar.rotation * turned;
    const Eigen::Matrix3d in_plane = weight * (g.transpose() * g);
    const Eigen::Matrix3d out_of_plane = weight * (g.transpose() * inverse_stretch * g);
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) {
        if (!triangle.blocks[i][j].valid()) continue;
        Eigen::Matrix3d block = -out_of_plane(i, j) * normal_square;
        block.noalias() -= (weight * inverse_tau) * q.col(i) * q.col(j).transpose();
        block.diagonal().array() += in_plane(i, j);
        hessian->block(triangle.blocks[i][j]) += block;
      }
    }
  }
}

}  // namespace clothid
