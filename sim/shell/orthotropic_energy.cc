#include "sim/shell/orthotropic_energy.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

namespace clothid {
namespace {

CLOTHID_ALWAYS_INLINE Symmetric2 GreenStrain(const Gradient& f) {
  const Symmetric2 c = Metric(f);
  return {0.5 * (c.m00 - 1.0), 0.5 * c.m01, 0.5 * (c.m11 - 1.0)};
}

CLOTHID_ALWAYS_INLINE Symmetric2 Stress(const OrthotropicConstants& c, const Symmetric2& e) {
  return {c.c11 * e.m00 + c.c12 * e.m11, 2.0 * c.c66 * e.m01, c.c12 * e.m00 + c.c22 * e.m11};
}

// Adds E to `energies` [kLanes].
CLOTHID_VECTOR_CLONES void OrthotropicForces(const TriangleBatch& __restrict__ batch,
                                             const CornerVectors& __restrict__ x, const OrthotropicConstants& constants,
                                             CornerVectors* __restrict__ forces, double* __restrict__ energies) {
  for (int lane = 0; lane < kLanes; ++lane) {
    const Gradient f = DeformationGradient(batch, x, lane);
    const Symmetric2 e = GreenStrain(f), s = Stress(constants, e);
    energies[lane] += 0.5 * batch.area[lane] * (s.m00 * e.m00 + 2.0 * s.m01 * e.m01 + s.m11 * e.m11);
    SetCornerForces(batch, -batch.area[lane], Times(f, s), lane, forces);
  }
}

// With the columns f_1, f_2 of F:  B_ij = a ((g_i . S g_j) I + sum_kl w_kl f_k f_l^T),
//   w_11 = C_11 g_i1 g_j1 + C_66 g_i2 g_j2,   w_12 = C_12 g_i1 g_j2 + C_66 g_i2 g_j1,
//   w_22 = C_22 g_i2 g_j2 + C_66 g_i1 g_j1,   w_21 = C_12 g_i2 g_j1 + C_66 g_i1 g_j2.
template <HessianKind kind>
CLOTHID_ALWAYS_INLINE void SetOrthotropicBlocks(const TriangleBatch& batch, const CornerVectors& x,
                                                const OrthotropicConstants& c, int lane, CornerBlocks* blocks) {
  const Gradient f = DeformationGradient(batch, x, lane);
  Symmetric2 s = Stress(c, GreenStrain(f));
  if (kind == HessianKind::kClamped) s = ClampEigenvalues(s, 0.0, std::numeric_limits<double>::infinity());
  const double(&f1)[3] = f.column[0];
  const double(&f2)[3] = f.column[1];
  const double area = batch.area[lane];
  const ShapeGradients g = AllShapeGradients(batch, lane);
  for (int pair = 0; pair < 3; ++pair) {
    const double(&gi)[2] = g.corner[kCornerPairs[pair][0]];
    const double(&gj)[2] = g.corner[kCornerPairs[pair][1]];
    const double g11 = area * (gi[0] * gj[0]), g12 = area * (gi[0] * gj[1]);
    const double g21 = area * (gi[1] * gj[0]), g22 = area * (gi[1] * gj[1]);
    const double w11 = c.c11 * g11 + c.c66 * g22, w12 = c.c12 * g12 + c.c66 * g21;
    const double w22 = c.c22 * g22 + c.c66 * g11, w21 = c.c12 * g21 + c.c66 * g12;
    const double stress = area * Product(gi, s, gj);
    for (int column = 0; column < 3; ++column) {
      const double by_f1 = w11 * f1[column] + w12 * f2[column], by_f2 = w21 * f1[column] + w22 * f2[column];
      for (int row = 0; row < 3; ++row) {
        blocks->values[pair][3 * column + row][lane] =
            (row == column ? stress : 0.0) + f1[row] * by_f1 + f2[row] * by_f2;
      }
    }
  }
}

CLOTHID_VECTOR_CLONES void OrthotropicBlocks(const TriangleBatch& __restrict__ batch,
                                             const CornerVectors& __restrict__ x, const OrthotropicConstants& constants,
                                             CornerBlocks* __restrict__ blocks) {
  for (int lane = 0; lane < kLanes; ++lane) {
    SetOrthotropicBlocks<HessianKind::kExact>(batch, x, constants, lane, blocks);
  }
}

CLOTHID_VECTOR_CLONES void ClampedOrthotropicBlocks(const TriangleBatch& __restrict__ batch,
                                                    const CornerVectors& __restrict__ x,
                                                    const OrthotropicConstants& constants,
                                                    CornerBlocks* __restrict__ blocks) {
  for (int lane = 0; lane < kLanes; ++lane) {
    SetOrthotropicBlocks<HessianKind::kClamped>(batch, x, constants, lane, blocks);
  }
}

}  // namespace

double OrthotropicConstants::Largest() const {
  const double mean = 0.5 * (c11 + c22), half = 0.5 * (c11 - c22);
  return std::max(mean + std::sqrt(half * half + c12 * c12), 2.0 * c66);
}

double OrthotropicEnergy::AddForce(const OrthotropicConstants& constants, const Eigen::VectorXd& positions,
                                   Eigen::VectorXd* force) const {
  CornerVectors x, forces;
  double energies[kLanes] = {};
  for (const TriangleBatch& batch : *triangles_) {
    GatherCorners(batch, positions.data(), &x);
    OrthotropicForces(batch, x, constants, &forces, energies);
    AddCorners(batch, forces, force->data());
  }
  return std::accumulate(energies, energies + kLanes, 0.0);
}

void OrthotropicEnergy::AddHessian(const OrthotropicConstants& constants, HessianKind kind,
                                   const Eigen::VectorXd& positions, BlockMatrix* hessian, ThreadTeam* team) const {
  const auto fill = [&](std::size_t b, CornerBlocks* blocks) {
    const TriangleBatch& batch = (*triangles_)[b];
    CornerVectors x;
    GatherCorners(batch, positions.data(), &x);
    if (kind == HessianKind::kExact) {
      OrthotropicBlocks(batch, x, constants, blocks);
    } else {
      ClampedOrthotropicBlocks(batch, x, constants, blocks);
    }
  };
  AddAllBlocks(*triangles_, team, fill, hessian);
}

void OrthotropicEnergy::AddForceProducts(const OrthotropicConstants& constants, const Eigen::VectorXd& positions,
                                         const Eigen::MatrixXd& columns, Eigen::Ref<Eigen::MatrixXd> products) const {
  CornerVectors x, forces;
  double energies[kLanes] = {};
  for (std::size_t b = 0; b < triangles_->size(); ++b) {
    const TriangleBatch& batch = (*triangles_)[b];
    GatherCorners(batch, positions.data(), &x);
    OrthotropicForces(batch, x, constants, &forces, energies);
    AddCornerProducts(batch, forces, columns, static_cast<Eigen::Index>(b) * kLanes, products);
  }
}

}  // namespace clothid
