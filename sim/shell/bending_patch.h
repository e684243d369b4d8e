// Bending by patches of triangles: the energy of a thin plate, on any mesh.
//
//   E = 1/2 sum over triangles of a (D11 |h11|^2 + D22 |h22|^2 + 2 D12 h11 . h22 + 4 D66 |h12|^2)
//     = 1/2 x^T (Q kron I3) x,   Q constant, linear in every D
//
// a: rest area, m^2; h_ab [3], 1/m: mean second derivatives of the positions x over the triangle, in its rest plane,
// axis 1 along the warp. A cloth bent to a cylinder of radius R about axis 2 has E = D11/2 area/R^2.
//
// By the divergence theorem h is a sum over the edges of a triangle, of length l, unit tangent t and normal n outwards:
//   a h = sum l sym(n (dx/dt t + dx/dn n)^T),   dx/dt = (x_end - x_start)/l,   dx/dn = sum_i g_i x_i
// with slopes g at the middle of an edge that
//   - are exact for quadratics: so is h, and the energy of constant second derivatives is that of the plate;
//   - are the same for both triangles of an edge: so sum a h is a sum over the border alone, a state of constant
//   moments
//     is in equilibrium, and only affine maps have E = 0.
// Either alone is not enough: with an h that each triangle fits for itself (the six nodes of it and its neighbours, as
// in rotation-free shells) a strip of alternating triangles sags 1.4 times too far, however fine they are.
//
// A slope is that of the two triangles of the edge, weighted by the height of the other, less what it misses of a
// quadratic: nothing where the two are a parallelogram. Else the second derivatives to subtract are a least-squares fit
// (quadratic_fit.h) to the four nodes and those across the other edges of one triangle, that nearer to the middle of
// the cloth: six, or eight where both are as near. Where these leave a derivative open, as at a border, they are joined
// by those nodes of the triangles that touch them that tell most. So the patch of a triangle has 6 to some 12 nodes,
// and a row of Q has 13 entries on grids, 18 on equilateral triangles and 29 on irregular ones.
//
// At a clamped edge (sim/mesh/clamped_edges.h) the slope is the one that is given, d: of cloth that keeps its lengths
// there. So the cloth is clamped at the edge itself, and one row of nodes holds it.
//
// Across a seam the triangles beyond it are unfolded as others are, each with its own shape at rest; a fold counts as a
// border.
//
// It is the triangle of L. S. D. Morley (The triangular equilibrium element in the solution of plate bending problems,
// 1968), with the slopes taken from nodes as in the shells of E. Onate and F. Zarate (Rotation-free triangular plate
// and shell elements, 2000).
#ifndef CLOTHID_SIM_SHELL_BENDING_PATCH_H_
#define CLOTHID_SIM_SHELL_BENDING_PATCH_H_

#include <Eigen/Core>
#include <Eigen/SparseCore>
#include <vector>

#include "sim/mesh/clamped_edges.h"
#include "sim/mesh/mesh.h"
#include "sim/scene/scene.h"
#include "sim/shell/bending_energy.h"
#include "sim/shell/rest_curvature.h"

namespace clothid {

// N m. The energy is positive where D11, D22, D66 > 0 and D12^2 < D11 D22.
struct FlexuralRigidity {
  double d11 = 0.0, d22 = 0.0;  // along warp and weft
  double d12 = 0.0;             // couples the two
  double d66 = 0.0;             // of twist
};

// D11 = D22 = D, D12 = nu D, D66 = (1 - nu)/2 D, the same in all axes; nu in (-1, 1).
FlexuralRigidity IsotropicRigidity(double rigidity, double poisson);

// Orthotropic rigidities as a sum, warp D_warp + weft D_weft + twist D_twist: D11 = D_warp, D22 = D_weft, D66 = D_twist
// and D12 = nu (D_warp + D_weft)/2, which is nu D where both are D. (nu sqrt(D_warp D_weft), the usual one, is not
// linear.) Away from its borders, a cloth that keeps its lengths has the same energy with D12 and D66 as with 0 and D66
// + D12/2: no motion of it tells the two apart, and so D12 is none of the parameters.
struct OrthotropicShares {
  FlexuralRigidity warp, weft, twist;
};
OrthotropicShares SharesOfRigidity(double poisson);

struct BendingPatch {
  double area = 0.0;                                    // a
  std::vector<int> nodes;                               // [n], those of the triangle first
  Eigen::Matrix3Xd weights;                             // [3 x n] rows w_11, w_22, w_12, 1/m^2: h_ab = sum_i w_ab,i x_i
  std::vector<int> slopes;                              // [m] clamped edges of the triangle
  Eigen::Matrix3Xd slope_weights;                       // [3 x m] likewise, 1/m: h_ab also has sum_k w_ab,k d_k
  Eigen::Vector3d curvature = Eigen::Vector3d::Zero();  // kappa_11, kappa_22, kappa_12 at rest, 1/m
};

// What a mesh that is curved at rest is bent to.
enum class BendingRest {
  kFlat,  // it counts as flat: what is around a triangle is unfolded into its plane
  kMesh,  // its own shape, rest_curvature.h. There h_ab is taken less F t_ab, t the part of h_ab at rest along the
          // triangle and F its deformation gradient, so that h_ab = kappa_ab n at rest.
};

class BendingPatches {
 public:
  // `mesh` as `ValidateMesh` wants it. `warp` [3 x F]: the direction of axis 1 in every triangle, projected onto its
  // plane, to which it must not be perpendicular; axis 2 follows counter-clockwise.
  BendingPatches(const Mesh& mesh, const Eigen::Matrix3Xd& warp, BendingRest rest = BendingRest::kFlat);
  // Likewise, of a mesh that is `chosen_on` at another size (sim/rollout/sized_scene.h): which nodes are in a patch,
  // and how they share in a slope, is what it is there, and the second derivatives are taken along, as the affine map
  // of every triangle tells. So Q is a smooth function of the size, though the choice of nodes is none, and its entries
  // stay where they are. All that is said above holds.
  BendingPatches(const Mesh& mesh, const Eigen::Matrix3Xd& warp, BendingRest rest, const Mesh& chosen_on,
                 const std::vector<ClampedEdge>& clamped = {});

  const std::vector<BendingPatch>& patches() const { return patches_; }  // [F], in the order of the mesh

  // Q [N x N], N/m, symmetric, positive semidefinite, both triangles stored. Entries that cancel, as on grids, are left
  // out.
  Eigen::SparseMatrix<double> Matrix(const FlexuralRigidity& rigidity) const;

  // What Q has beside the nodes, with the same rigidity.
  SlopeBending Slopes(const FlexuralRigidity& rigidity) const;

  // The parts of both, one per triangle.
  std::vector<BendingElement> Elements(const FlexuralRigidity& rigidity) const;

  // Of every triangle, with kMesh; else none.
  std::vector<RestMoment> Moments(const FlexuralRigidity& rigidity) const;

 private:
  int num_nodes_, num_slopes_;
  BendingRest rest_;
  std::vector<BendingPatch> patches_;
};

// Of the scene's cloth.
BendingRest RestOf(const Scene& scene);

// The first edge of every triangle [3 x F], m: axes for a law that is the same in all of them.
Eigen::Matrix3Xd FirstEdges(const Mesh& mesh);

}  // namespace clothid

#endif  // CLOTHID_SIM_SHELL_BENDING_PATCH_H_
