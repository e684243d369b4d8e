#include "sim/shell/stretch_energy.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace clothid {
namespace {

// Below this share of tr C the area ratio s of a collapsing triangle is held, so that S stays invertible.
constexpr double kSmallestAreaRatio = 1e-12;

struct PolarFactors {
  Gradient rotation;           // R
  Symmetric2 inverse_stretch;  // S^-1
  double tau;                  // tr S
};

CLOTHID_ALWAYS_INLINE PolarFactors Polar(const Gradient& f) {
  const Symmetric2 c = Metric(f);
  const double trace = c.m00 + c.m11, determinant = c.m00 * c.m11 - c.m01 * c.m01;
  const double s = std::max(std::sqrt(std::max(determinant, 0.0)), kSmallestAreaRatio * trace);
  PolarFactors polar;
  polar.tau = std::sqrt(trace + 2.0 * s);
  // S^-1 = tau (C + s I)^-1 by the adjugate; det(C + s I) = s tau^2.
  const double a = c.m00 + s, d = c.m11 + s;
  const double scale = polar.tau / (a * d - c.m01 * c.m01);
  polar.inverse_stretch = {scale * d, -scale * c.m01, scale * a};
  for (int i = 0; i < 3; ++i) {
    polar.rotation.column[0][i] =
        f.column[0][i] * polar.inverse_stretch.m00 + f.column[1][i] * polar.inverse_stretch.m01;
    polar.rotation.column[1][i] =
        f.column[0][i] * polar.inverse_stretch.m01 + f.column[1][i] * polar.inverse_stretch.m11;
  }
  return polar;
}

// Adds E/k = a/2 |F - R|^2 to `energies` [kLanes]; the forces are -k a (F - R) g_i.
CLOTHID_VECTOR_CLONES void StretchForces(const TriangleBatch& __restrict__ batch, const CornerVectors& __restrict__ x,
                                         double stiffness, CornerVectors* __restrict__ forces,
                                         double* __restrict__ energies) {
  for (int lane = 0; lane < kLanes; ++lane) {
    const Gradient f = DeformationGradient(batch, x, lane);
    const PolarFactors polar = Polar(f);
    Gradient strain;
    double square = 0.0;
    for (int k = 0; k < 2; ++k) {
      for (int c = 0; c < 3; ++c) {
        strain.column[k][c] = f.column[k][c] - polar.rotation.column[k][c];
        square += strain.column[k][c] * strain.column[k][c];
      }
    }
    energies[lane] += 0.5 * batch.area[lane] * square;
    SetCornerForces(batch, -stiffness * batch.area[lane], strain, lane, forces);
  }
}

// With w = k a:  B_ij = w (g_i . g_j) I - (w/tau) q_i q_j^T - w (g_i . S^-1 g_j) n n^T,
//   q_i = R eps g_i, eps = [0 -1; 1 0], n = R_0 x R_1.
template <HessianKind kind>
CLOTHID_ALWAYS_INLINE void SetStretchBlocks(const TriangleBatch& batch, const CornerVectors& x, double stiffness,
                                            int lane, CornerBlocks* blocks) {
  const PolarFactors polar = Polar(DeformationGradient(batch, x, lane));
  const double(&r0)[3] = polar.rotation.column[0];
  const double(&r1)[3] = polar.rotation.column[1];
  Symmetric2 inverse_stretch = polar.inverse_stretch;
  double inverse_tau = 1.0 / polar.tau;
  if (kind == HessianKind::kClamped) {
    inverse_stretch = ClampEigenvalues(inverse_stretch, 0.0, 1.0);
    inverse_tau = std::min(inverse_tau, 0.5);
  }
  const double weight = stiffness * batch.area[lane];
  const ShapeGradients g = AllShapeGradients(batch, lane);
  double n[3], q[3][3];
  for (int c = 0; c < 3; ++c) {
    n[c] = r0[(c + 1) % 3] * r1[(c + 2) % 3] - r0[(c + 2) % 3] * r1[(c + 1) % 3];
    for (int i = 0; i < 3; ++i) q[i][c] = r1[c] * g.corner[i][0] - r0[c] * g.corner[i][1];
  }
  for (int pair = 0; pair < 3; ++pair) {
    const int i = kCornerPairs[pair][0], j = kCornerPairs[pair][1];
    const double in_plane = weight * (g.corner[i][0] * g.corner[j][0] + g.corner[i][1] * g.corner[j][1]);
    const double out_of_plane = weight * Product(g.corner[i], inverse_stretch, g.corner[j]);
    for (int column = 0; column < 3; ++column) {
      for (int row = 0; row < 3; ++row) {
        blocks->values[pair][3 * column + row][lane] = (row == column ? in_plane : 0.0) -
                                                       weight * inverse_tau * q[i][row] * q[j][column] -
                                                       out_of_plane * (n[row] * n[column]);
      }
    }
  }
}

CLOTHID_VECTOR_CLONES void StretchBlocks(const TriangleBatch& __restrict__ batch, const CornerVectors& __restrict__ x,
                                         double stiffness, CornerBlocks* __restrict__ blocks) {
  for (int lane = 0; lane < kLanes; ++lane) {
    SetStretchBlocks<HessianKind::kExact>(batch, x, stiffness, lane, blocks);
  }
}

CLOTHID_VECTOR_CLONES void ClampedStretchBlocks(const TriangleBatch& __restrict__ batch,
                                                const CornerVectors& __restrict__ x, double stiffness,
                                                CornerBlocks* __restrict__ blocks) {
  for (int lane = 0; lane < kLanes; ++lane) {
    SetStretchBlocks<HessianKind::kClamped>(batch, x, stiffness, lane, blocks);
  }
}

}  // namespace

double StretchEnergy::AddForce(double stiffness, const Eigen::VectorXd& positions, Eigen::VectorXd* force) const {
  CornerVectors x, forces;
  double energies[kLanes] = {};
  for (const TriangleBatch& batch : *triangles_) {
    GatherCorners(batch, positions.data(), &x);
    StretchForces(batch, x, stiffness, &forces, energies);
    AddCorners(batch, forces, force->data());
  }
  return std::accumulate(energies, energies + kLanes, 0.0);
}

void StretchEnergy::AddHessian(double stiffness, HessianKind kind, const Eigen::VectorXd& positions,
                               BlockMatrix* hessian, ThreadTeam* team) const {
  const auto fill = [&](std::size_t b, CornerBlocks* blocks) {
    const TriangleBatch& batch = (*triangles_)[b];
    CornerVectors x;
    GatherCorners(batch, positions.data(), &x);
    if (kind == HessianKind::kExact) {
      StretchBlocks(batch, x, stiffness, blocks);
    } else {
      ClampedStretchBlocks(batch, x, stiffness, blocks);
    }
  };
  AddAllBlocks(*triangles_, team, fill, hessian);
}

void StretchEnergy::AddForceProducts(double stiffness, const Eigen::VectorXd& positions, const Eigen::MatrixXd& columns,
                                     Eigen::Ref<Eigen::MatrixXd> products) const {
  CornerVectors x, forces;
  double energies[kLanes] = {};
  for (std::size_t b = 0; b < triangles_->size(); ++b) {
    const TriangleBatch& batch = (*triangles_)[b];
    GatherCorners(batch, positions.data(), &x);
    StretchForces(batch, x, stiffness, &forces, energies);
    AddCornerProducts(batch, forces, columns, static_cast<Eigen::Index>(b) * kLanes, products);
  }
}

}  // namespace clothid
