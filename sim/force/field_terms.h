// What a constant of the material that varies over the cloth, as a field or from piece to piece, does to the forces in
// it: every energy is a sum over triangles, and so is the mass, so it is a weight for each triangle.
#ifndef CLOTHID_SIM_FORCE_FIELD_TERMS_H_
#define CLOTHID_SIM_FORCE_FIELD_TERMS_H_

#include <Eigen/Core>
#include <Eigen/SparseCore>
#include <memory>
#include <vector>

#include "sim/force/force_part.h"
#include "sim/scene/scene.h"
#include "sim/shell/bending_energy.h"
#include "sim/shell/rest_curvature.h"
#include "sim/shell/triangle_element.h"

namespace clothid {

// `triangles` with their areas times the `weights` [F]: those of an energy whose constant is a field.
std::shared_ptr<const TriangleElements> WeightedTriangles(const TriangleElements& triangles,
                                                          const Eigen::VectorXd& weights);

// Those of `triangles` that are `faces` of the mesh.
TriangleElements SelectTriangles(const TriangleElements& triangles, const std::vector<int>& faces);

// Of each of the triangles [F] with these pieces: 1 in `piece`, else 0; kWhole: 1 in all.
Eigen::VectorXd PieceMask(int piece, const std::vector<int>& face_pieces);

// A third of the rest area of the triangles at every node times their `weights` [F]: [N] m^2.
Eigen::VectorXd WeightedNodeAreas(const Mesh& mesh, const Eigen::VectorXd& weights);

// Q [N x N] of a term of bending, and what a curved rest shape and clamps add to it.
struct BendingMatrix {
  ParameterKind kind;
  Eigen::SparseMatrix<double> matrix;
  std::vector<RestMoment> moments;
  SlopeBending slopes;

  // Adds stiffness * (-Q x), and the force of the moments and of the slopes at clamps [3C], to `force` [3N].
  void AddForce(double stiffness, const Eigen::VectorXd& positions, const Eigen::VectorXd& slopes_now,
                Eigen::VectorXd* force) const;
  // Of a part, the triangles counted as in the mesh.
  BendingMatrix PartOf(const ForcePart& part) const;
};

// Bending by a constant that varies: an edge has the mean weight of its two triangles.
class WeightedBending {
 public:
  // `kind`: k_b, or one of those along warp, weft and twist. `chosen_on`: of patches, as `BendingPatches` has it.
  WeightedBending(const Scene& scene, ParameterKind kind, const Mesh& chosen_on);

  ParameterKind kind() const { return kind_; }
  WeightedBending PartOf(const ForcePart& part) const;  // likewise
  BendingMatrix Of(const Eigen::VectorXd& weights) const {
    return {kind_, Matrix(weights), Moments(weights), Slopes(weights)};
  }

  // Q with its elements times the `weights` [F]: [N x N]. Its pattern is the same for all weights, those of zero too.
  Eigen::SparseMatrix<double> Matrix(const Eigen::VectorXd& weights) const;

  // What a curved rest shape adds, with the `weights` [F]; none where it is flat.
  std::vector<RestMoment> Moments(const Eigen::VectorXd& weights) const;

  // What clamps add, likewise.
  SlopeBending Slopes(const Eigen::VectorXd& weights) const;

  // Adds stiffness * (-Q_f x) . y of every triangle f to `products` [F x s], for columns y [3N x s]. The Q_f, one per
  // unit of weight, times the weights are the sum Q. With
  // a curved rest shape it is the force of the triangle about that, with clamps the force of their slopes is in it.
  void AddForceProducts(double stiffness, const Eigen::VectorXd& positions, const Eigen::VectorXd& slopes,
                        const Eigen::MatrixXd& columns, Eigen::Ref<Eigen::MatrixXd> products) const;

 private:
  int num_nodes_, num_slopes_;
  ParameterKind kind_;
  std::vector<BendingElement> elements_;
  std::vector<RestMoment> moments_;
};

}  // namespace clothid

#endif  // CLOTHID_SIM_FORCE_FIELD_TERMS_H_
