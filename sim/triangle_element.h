// The triangles of a cloth as linear finite elements: the geometry that the energies of its surface share.
//
// Per triangle with rest area a and shape gradients g_i (in its rest plane): F = sum x_i g_i^T [3 x 2], the deformation
// gradient, and from a stress P = dE/dF the forces -P g_i on its nodes.
#ifndef CLOTHID_SIM_TRIANGLE_ELEMENT_H_
#define CLOTHID_SIM_TRIANGLE_ELEMENT_H_

#include <Eigen/Core>
#include <vector>

#include "sim/block_matrix.h"
#include "sim/mesh.h"

namespace clothid {

enum class HessianKind {
  kExact,    // the second derivative; indefinite in compression
  kClamped,  // what makes it indefinite is clamped: positive semidefinite, for directions only
};

struct TriangleElement {
  int nodes[3];
  double area;                                  // a, m^2
  Eigen::Matrix<double, 2, 3> shape_gradients;  // column i: g_i, 1/m
  BlockPosition blocks[3][3];                   // of (i, j), invalid where one of them is a handle
};
using TriangleElements = std::vector<TriangleElement>;

// In the order of the mesh's faces. `pattern` is the pattern of the Hessian over the free nodes, `free_index` [N] maps
// nodes to it (-1: a handle).
TriangleElements MakeTriangleElements(const Mesh& mesh, const std::vector<int>& free_index,
                                      const BlockPattern& pattern);

// Diagonal of the constant PD matrix L, L_ij = sum a g_i . g_j [N], 1.
Eigen::VectorXd LaplacianDiagonal(const TriangleElements& triangles, int num_nodes);

// F of `triangle` for positions [3N].
template <typename Positions>
Eigen::Matrix<double, 3, 2> DeformationGradient(const TriangleElement& triangle, const Positions& positions) {
  const Eigen::Vector3d x0 = positions.template segment<3>(3 * triangle.nodes[0]);
  return (positions.template segment<3>(3 * triangle.nodes[1]) - x0) * triangle.shape_gradients.col(1).transpose() +
         (positions.template segment<3>(3 * triangle.nodes[2]) - x0) * triangle.shape_gradients.col(2).transpose();
}

// Adds `stress` g_i to the entries of every node i of `triangle` in `force` [3N].
template <typename Force>
void AddNodeForces(const TriangleElement& triangle, const Eigen::Matrix<double, 3, 2>& stress, Force* force) {
  const Eigen::Vector3d f1 = stress * triangle.shape_gradients.col(1);
  const Eigen::Vector3d f2 = stress * triangle.shape_gradients.col(2);
  force->template segment<3>(3 * triangle.nodes[1]) += f1;
  force->template segment<3>(3 * triangle.nodes[2]) += f2;
  force->template segment<3>(3 * triangle.nodes[0]) -= f1 + f2;
}

}  // namespace clothid

#endif  // CLOTHID_SIM_TRIANGLE_ELEMENT_H_
