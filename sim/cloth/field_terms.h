// What a constant of the material that varies over the cloth does to the terms of its model: every energy is a sum over
// triangles, and so is the mass, so a field is a weight for each triangle.
#ifndef CLOTHID_SIM_CLOTH_FIELD_TERMS_H_
#define CLOTHID_SIM_CLOTH_FIELD_TERMS_H_

#include <Eigen/Core>
#include <Eigen/SparseCore>
#include <memory>
#include <vector>

#include "sim/cloth/bending_energy.h"
#include "sim/cloth/rest_curvature.h"
#include "sim/cloth/triangle_element.h"
#include "sim/scene/scene.h"

namespace clothid {

// `triangles` with their areas times the `weights` [F]: those of an energy whose constant is a field.
std::shared_ptr<const TriangleElements> WeightedTriangles(const TriangleElements& triangles,
                                                          const Eigen::VectorXd& weights);

// A third of the rest area of the triangles at every node times their `weights` [F]: [N] m^2.
Eigen::VectorXd WeightedNodeAreas(const Mesh& mesh, const Eigen::VectorXd& weights);

// Bending whose k_b is a field: an edge has the mean weight of its two triangles.
class WeightedBending {
 public:
  // `chosen_on`: of patches, as `BendingPatches` has it.
  WeightedBending(const Scene& scene, const Mesh& chosen_on);

  // Q with its elements times the `weights` [F]: [N x N]. Its pattern is the same for all weights, those of zero too.
  Eigen::SparseMatrix<double> Matrix(const Eigen::VectorXd& weights) const;

  // What a curved rest shape adds, with the `weights` [F]; none where it is flat.
  std::vector<RestMoment> Moments(const Eigen::VectorXd& weights) const;

  // Adds stiffness * (-Q_f x) . y of every triangle f to `products` [F x s], for columns y [3N x s]. The Q_f, one per
  // unit of weight, times the weights are the sum Q. With
  // a curved rest shape it is the force of the triangle about that.
  void AddForceProducts(double stiffness, const Eigen::VectorXd& positions, const Eigen::MatrixXd& columns,
                        Eigen::Ref<Eigen::MatrixXd> products) const;

 private:
  int num_nodes_;
  std::vector<BendingElement> elements_;
  std::vector<RestMoment> moments_;
};

}  // namespace clothid

#endif  // CLOTHID_SIM_CLOTH_FIELD_TERMS_H_
