// Bending energies that are quadratic in the positions:
//
//   E = k_b/2 x^T (Q kron I3) x,   Q [N x N] constant, 1/m^2; a flat cloth has E = 0.
//
// By edges (Bergou et al. 2006, "A quadratic bending model for inextensible surfaces"):
//   Q = sum over interior edges of 3/(A_1 + A_2) c c^T, c the four cotangent weights of the edge's two triangles.
// k_b belongs to the mesh: an edge holds the curvature across it alone, so a cylinder whose axis runs along one of the
// three edge directions of a right-angled grid has three times the energy k_b/2 area/R^2 of the continuum. Each
// triangle of an edge gives its own cotangents and area, as it is at rest; a fold is no interior edge.
//
// By patches of triangles (bending_patch.h): k_b is the flexural rigidity of the cloth, N m, on any mesh.
#ifndef CLOTHID_SIM_SHELL_BENDING_ENERGY_H_
#define CLOTHID_SIM_SHELL_BENDING_ENERGY_H_

#include <Eigen/Core>
#include <Eigen/SparseCore>
#include <functional>
#include <vector>

#include "sim/matrix/block_matrix.h"
#include "sim/mesh/clamped_edges.h"
#include "sim/mesh/mesh.h"

namespace clothid {

// A part of Q that belongs to some triangles, with k_b = 1.
struct BendingElement {
  std::vector<int> nodes;   // [n]
  std::vector<int> faces;   // an edge lies in two, a patch is that of one
  std::vector<int> slopes;  // [m] clamped edges whose slopes it has
  Eigen::MatrixXd block;    // [(n + m) x (n + m)] of nodes and slopes, 1/m^2 and 1/m
};

// What Q has beside the nodes where the cloth is clamped: with the slopes d [C] (Handles::clamped) the energy is
//   E = k_b/2 (x^T Q x + 2 x^T A d + d^T B d)
struct SlopeBending {
  Eigen::SparseMatrix<double> by_nodes;  // A [N x C], 1/m
  Eigen::SparseMatrix<double> own;       // B [C x C], 1

  bool is_empty() const { return own.cols() == 0; }
  // For slopes [3C] and positions [3N]: adds stiffness * (-A d) to `force` [3N] and returns x^T A d + d^T B d/2.
  double AddForce(double stiffness, const Eigen::VectorXd& positions, const Eigen::VectorXd& slopes,
                  Eigen::VectorXd* force) const;
  // Adds stiffness * (-A^T x - B d) to `moment` [3C].
  void AddSlopeForce(double stiffness, const Eigen::VectorXd& positions, const Eigen::VectorXd& slopes,
                     Eigen::VectorXd* moment) const;
};
// The sum over `elements`, each `weight` times.
SlopeBending SumOfSlopes(const std::vector<BendingElement>& elements, int num_nodes, int num_slopes,
                         const std::function<double(const BendingElement& element)>& weight);

// Of every interior edge, and of the triangles at every clamped one: each has, mirrored at the edge, another that the
// slope holds, 3/A_1 c c^T, as the half within the cloth has the curvature of both. And their sum, Q by edges [N x N],
// 1/m^2, symmetric positive semidefinite, both triangles stored.
std::vector<BendingElement> EdgeBendingElements(const Mesh& mesh, const std::vector<ClampedEdge>& clamped = {});
Eigen::SparseMatrix<double> EdgeBendingMatrix(const Mesh& mesh, const std::vector<ClampedEdge>& clamped = {});

class BendingEnergy {
 public:
  // `matrix` is Q; `pattern`, the pattern of the Hessian over the free nodes, must cover it; `free_index` [N] maps
  // nodes to it (-1: a handle).
  BendingEnergy(Eigen::SparseMatrix<double> matrix, const std::vector<int>& free_index, const BlockPattern& pattern);

  const Eigen::SparseMatrix<double>& matrix() const { return matrix_; }  // Q [N x N]
  const Eigen::VectorXd& diagonal() const { return diagonal_; }          // of Q [N]

  // Adds stiffness * (-Q x) to `force` [3N] and returns E/k_b for positions [3N], 1.
  double AddForce(double stiffness, const Eigen::VectorXd& positions, Eigen::VectorXd* force) const;

  // Adds stiffness * Q kron I3 below the diagonal of `hessian`, for `BlockMatrix::CompleteFromLower`.
  void AddHessian(double stiffness, BlockMatrix* hessian, ThreadTeam* team = nullptr) const;

 private:
  Eigen::SparseMatrix<double> matrix_;
  Eigen::VectorXd diagonal_;
  // Where the entries of Q between free nodes go, below the diagonal; those with handles on it.
  std::vector<BlockPosition> positions_;
  std::vector<double> entries_;  // of Q, in the same order
};

}  // namespace clothid

#endif  // CLOTHID_SIM_SHELL_BENDING_ENERGY_H_
