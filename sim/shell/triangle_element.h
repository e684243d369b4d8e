// The triangles of a cloth as linear finite elements: the geometry that the energies of its surface share.
//
// Per triangle with rest area a and shape gradients g_i (in its rest plane): F = sum x_i g_i^T [3 x 2], the deformation
// gradient, and from a stress P = dE/dF the forces -P g_i on its nodes. Triangles are kept and computed in batches of
// kLanes, one in each lane: a quantity is an array over the lanes, and a formula a loop over them that the compiler
// turns into vector instructions. What fills the last batch has area 0 and no place in any matrix.
#ifndef CLOTHID_SIM_SHELL_TRIANGLE_ELEMENT_H_
#define CLOTHID_SIM_SHELL_TRIANGLE_ELEMENT_H_

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "sim/base/vector_clones.h"
#include "sim/matrix/block_matrix.h"
#include "sim/mesh/mesh.h"

namespace clothid {

enum class HessianKind {
  kExact,    // the second derivative; indefinite in compression
  kClamped,  // what makes it indefinite is clamped: positive semidefinite, for directions only
};

inline constexpr int kLanes = 8;

// The pairs of corners (i, j) of a triangle whose blocks B_ij of its Hessian are assembled. An energy of F does not see
// translations, so the rest follows: B_ji = B_ij^T and B_ii = -sum_{j != i} B_ij (`BlockMatrix::CompleteFromLower`).
inline constexpr int kCornerPairs[3][2] = {{1, 0}, {2, 0}, {2, 1}};

struct alignas(64) TriangleBatch {
  int rows[3][kLanes];                   // of the corners in a vector [3N], free nodes first and in their order
  double area[kLanes];                   // a, m^2
  double shape_gradients[2][2][kLanes];  // [i - 1][component]: g_1 and g_2, 1/m; g_0 = -g_1 - g_2
  // Of kCornerPairs: below the diagonal; with a handle i on the diagonal, of j; with two handles invalid.
  BlockPosition blocks[3][kLanes];
};
using TriangleElements = std::vector<TriangleBatch>;

// A vector per corner, such as its position or force: [corner][axis].
struct alignas(64) CornerVectors {
  double values[3][3][kLanes];
};

// Whether one of its blocks is in these columns.
bool HasBlocksIn(const TriangleBatch& batch, const BlockColumns& columns);

// B_ij for kCornerPairs, each by columns.
struct alignas(64) CornerBlocks {
  double values[3][9][kLanes];
};

// In the order of the mesh's faces. `pattern` is the pattern of the Hessian over the free nodes, `free_index` [N] maps
// nodes to it (-1: a handle). `first_axes` (may be null): the first axis of the shape gradients of every triangle, unit
// vectors in their planes [3 x F], the second is at a right angle to it. Null: axes that belong to the mesh, for
// energies that are the same in all.
TriangleElements MakeTriangleElements(const Mesh& mesh, const std::vector<int>& free_index, const BlockPattern& pattern,
                                      const Eigen::Matrix3Xd* first_axes = nullptr);

// The constant PD matrix L, L_ij = sum a g_i . g_j [N x N], 1, both triangles stored; and its diagonal [N].
Eigen::SparseMatrix<double> LaplacianMatrix(const TriangleElements& triangles, int num_nodes);
Eigen::VectorXd LaplacianDiagonal(const TriangleElements& triangles, int num_nodes);

// The corners' entries of a vector [3N].
void GatherCorners(const TriangleBatch& batch, const double* all, CornerVectors* corners);
// Adds the corners' vectors to the entries of their nodes in a vector [3N].
void AddCorners(const TriangleBatch& batch, const CornerVectors& corners, double* all);
// Adds the products of the corners' vectors with those of the columns [3N x c] to `products` [F x c], a row per
// triangle: those of `batch` begin at `first`.
void AddCornerProducts(const TriangleBatch& batch, const CornerVectors& corners, const Eigen::MatrixXd& columns,
                       Eigen::Index first, Eigen::Ref<Eigen::MatrixXd> products);
// Adds the blocks where `batch` places them within `columns`.
void AddBlocks(const TriangleBatch& batch, const CornerBlocks& blocks, const BlockColumns& columns,
               BlockMatrix* hessian);
// Adds the blocks of every batch, which fill(b, &blocks) computes for the b-th. The threads of `team` (may be null)
// have columns of their own, in which sums are taken in the same order whoever has them.
template <typename Fill>
void AddAllBlocks(const TriangleElements& triangles, ThreadTeam* team, const Fill& fill, BlockMatrix* hessian) {
  ForColumns(hessian->pattern(), team, [&](const BlockColumns& columns) {
    CornerBlocks blocks;
    for (std::size_t b = 0; b < triangles.size(); ++b) {
      if (!columns.are_all && !HasBlocksIn(triangles[b], columns)) continue;
      fill(b, &blocks);
      AddBlocks(triangles[b], blocks, columns, hessian);
    }
  });
}

// The columns of F, a vector of three each, in one lane.
struct Gradient {
  double column[2][3];
};

CLOTHID_ALWAYS_INLINE Gradient DeformationGradient(const TriangleBatch& batch, const CornerVectors& x, int lane) {
  Gradient f;
  for (int c = 0; c < 3; ++c) {
    const double e1 = x.values[1][c][lane] - x.values[0][c][lane], e2 = x.values[2][c][lane] - x.values[0][c][lane];
    for (int k = 0; k < 2; ++k) {
      f.column[k][c] = e1 * batch.shape_gradients[0][k][lane] + e2 * batch.shape_gradients[1][k][lane];
    }
  }
  return f;
}

// [m00 m01; m01 m11].
struct Symmetric2 {
  double m00, m01, m11;
};

// f m.
CLOTHID_ALWAYS_INLINE Gradient Times(const Gradient& f, const Symmetric2& m) {
  Gradient product;
  for (int c = 0; c < 3; ++c) {
    product.column[0][c] = f.column[0][c] * m.m00 + f.column[1][c] * m.m01;
    product.column[1][c] = f.column[0][c] * m.m01 + f.column[1][c] * m.m11;
  }
  return product;
}

// weight P g_i for every corner i.
CLOTHID_ALWAYS_INLINE void SetCornerForces(const TriangleBatch& batch, double weight, const Gradient& stress, int lane,
                                           CornerVectors* forces) {
  for (int c = 0; c < 3; ++c) {
    double f[2];
    for (int i = 0; i < 2; ++i) {
      f[i] = weight * (stress.column[0][c] * batch.shape_gradients[i][0][lane] +
                       stress.column[1][c] * batch.shape_gradients[i][1][lane]);
      forces->values[i + 1][c][lane] = f[i];
    }
    forces->values[0][c][lane] = -(f[0] + f[1]);
  }
}

// g_i of every corner, in one lane.
struct ShapeGradients {
  double corner[3][2];
};

CLOTHID_ALWAYS_INLINE ShapeGradients AllShapeGradients(const TriangleBatch& batch, int lane) {
  ShapeGradients g;
  for (int k = 0; k < 2; ++k) {
    g.corner[1][k] = batch.shape_gradients[0][k][lane];
    g.corner[2][k] = batch.shape_gradients[1][k][lane];
    g.corner[0][k] = -(g.corner[1][k] + g.corner[2][k]);
  }
  return g;
}

// F^T F.
CLOTHID_ALWAYS_INLINE Symmetric2 Metric(const Gradient& f) {
  Symmetric2 c = {0.0, 0.0, 0.0};
  for (int i = 0; i < 3; ++i) {
    c.m00 += f.column[0][i] * f.column[0][i];
    c.m01 += f.column[0][i] * f.column[1][i];
    c.m11 += f.column[1][i] * f.column[1][i];
  }
  return c;
}

// a . m b.
CLOTHID_ALWAYS_INLINE double Product(const double (&a)[2], const Symmetric2& m, const double (&b)[2]) {
  return a[0] * (m.m00 * b[0] + m.m01 * b[1]) + a[1] * (m.m01 * b[0] + m.m11 * b[1]);
}

// `m` with its eigenvalues clamped to [lower, upper].
CLOTHID_ALWAYS_INLINE Symmetric2 ClampEigenvalues(const Symmetric2& m, double lower, double upper) {
  const double mean = 0.5 * (m.m00 + m.m11), half = 0.5 * (m.m00 - m.m11);
  const double radius = std::sqrt(half * half + m.m01 * m.m01);
  const double high = std::min(std::max(mean + radius, lower), upper);
  const double low = std::min(std::max(mean - radius, lower), upper);
  const double scale = 0.5 * (high - low) / std::max(radius, std::numeric_limits<double>::min());
  return {0.5 * (high + low) + scale * half, scale * m.m01, 0.5 * (high + low) - scale * half};
}

}  // namespace clothid

#endif  // CLOTHID_SIM_SHELL_TRIANGLE_ELEMENT_H_
