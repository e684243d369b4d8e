// Bending about a rest shape that is curved. Beside the quadratic energy of bending_patch.h, with the weights that it
// has there, a triangle then has
//
//   E = 1/2 sum_ab,cd a D_ab,cd (h_ab - kappa_ab n) . (h_cd - kappa_cd n) = 1/2 x^T Q x - p . n + e/2,   p = sum_i c_i
//   x_i
//
// kappa_ab, 1/m: the curvature of the mesh at rest, h_ab . n there; n: the unit normal of the triangle where it is now.
// c_i = a sum D_ab,cd kappa_cd w_ab,i, and e = a sum D_ab,cd kappa_ab kappa_cd. E is 0 at rest, wherever the cloth is
// and however it is turned, and never negative. Along the normal it is the energy of the change of curvature of Onate
// and Zarate, 2000, and of Flores and Onate (Improvements in the membrane behaviour of the three node rotation-free BST
// shell triangle, 2005).
//
// With the shape gradients g_k of the triangle where it is now, dn = -sum_k g_k n . dx_k, and so
//   force:    c_i n on every node of the patch, -(p . g_k) n on the corners
//   Hessian:  c_i g_k n^T between a node and a corner, and its transpose;
//             (p . n) g_k . g_l n n^T - (p . g_l) n g_k^T - (p . g_k) g_l n^T between two corners,
//   clamped:  e g_k . g_l n n^T instead, which with Q is the square of the change of h - kappa n.
// All per unit of k_b. Rows of the Hessian have the sum zero. Slopes d of clamped edges (bending_patch.h) are in p,
// too, with c likewise; by them the energy changes by -c n.
#ifndef CLOTHID_SIM_SHELL_REST_CURVATURE_H_
#define CLOTHID_SIM_SHELL_REST_CURVATURE_H_

#include <Eigen/Core>
#include <array>
#include <vector>

#include "sim/matrix/block_matrix.h"
#include "sim/mesh/mesh.h"
#include "sim/shell/triangle_element.h"

namespace clothid {

// Of a triangle, with k_b = 1.
struct RestMoment {
  int face = 0;
  std::vector<int> nodes;              // [n] of its patch, its corners first
  Eigen::VectorXd weights;             // c [n], 1/m
  double square = 0.0;                 // e, 1
  std::vector<int> slopes = {};        // [m] clamped edges
  Eigen::VectorXd slope_weights = {};  // c [m], 1

  RestMoment Times(double factor) const {
    return {face, nodes, factor * weights, factor * square, slopes, factor * slope_weights};
  }
};

// Adds factor * (-d(e/2 - p . n)/dx) to `force` [3N] and returns e/2 - p . n for positions [3N] and the slopes of all
// clamped edges [3C].
double AddMomentForce(const RestMoment& moment, double factor, const Eigen::VectorXd& positions,
                      const Eigen::VectorXd& slopes, Eigen::VectorXd* force);
// Adds factor * c n to `force` [3C], what is upon the slopes.
void AddMomentSlopeForce(const RestMoment& moment, double factor, const Eigen::VectorXd& positions,
                         Eigen::VectorXd* force);

// Whether the nodes of a mesh lie in a plane but for 1e-5 of its size, which is more than the rounding of a file.
bool IsFlat(const Mesh& mesh);

class RestCurvature {
 public:
  // `pattern`, the pattern of the Hessian over the free nodes, must have the nodes of a moment beside its corners;
  // `free_index` [N] maps nodes to it (-1: a handle).
  RestCurvature(std::vector<RestMoment> moments, const std::vector<int>& free_index, const BlockPattern& pattern);

  const std::vector<RestMoment>& moments() const { return moments_; }

  // Of all triangles, stiffness times.
  double AddForce(double stiffness, const Eigen::VectorXd& positions, const Eigen::VectorXd& slopes,
                  Eigen::VectorXd* force) const;

  // Adds stiffness * the Hessian below the diagonal of `hessian`, for `BlockMatrix::CompleteFromLower`. Clamped, it is
  // positive semidefinite together with stiffness * Q.
  void AddHessian(double stiffness, HessianKind kind, const Eigen::VectorXd& positions, const Eigen::VectorXd& slopes,
                  BlockMatrix* hessian) const;

 private:
  // Between node i of a patch and corner k.
  struct Place {
    BlockPosition position;
    bool transposed = false;  // of corner and node
  };

  std::vector<RestMoment> moments_;
  std::vector<std::vector<std::array<Place, 3>>> places_;  // [moments][n][k]; invalid: none, or found by symmetry
};

}  // namespace clothid

#endif  // CLOTHID_SIM_SHELL_REST_CURVATURE_H_
