// The forces that a scene has, built once per simulator: no obstacle, no contact; k_b = 0, no bending; c_d = 0, no drag
// that is the same in every direction; c_n = c_t = 0, none by direction; eta = 0, no internal damping. Constants that
// vary over the cloth (sim/scene/material_field.h, sim/scene/pieces.h) are put into them by SetVariation.
#ifndef CLOTHID_SIM_CLOTH_CLOTH_MODEL_H_
#define CLOTHID_SIM_CLOTH_CLOTH_MODEL_H_

#include <Eigen/Core>
#include <memory>
#include <optional>
#include <vector>

#include "sim/force/bending_term.h"
#include "sim/force/force_set.h"
#include "sim/force/node_forces.h"
#include "sim/matrix/block_matrix.h"
#include "sim/scene/scene.h"
#include "sim/shell/stretch_energy.h"

namespace clothid {

class ClothModel {
 public:
  // `scene` must outlive the model and have passed `ValidateScene`.
  explicit ClothModel(const Scene& scene);
  // Likewise, of a scene whose mesh is `chosen_on` at another size, on which the patches of bending are chosen
  // (bending_patch.h); it must outlive the model.
  ClothModel(const Scene& scene, const Mesh& chosen_on);
  // Likewise, of a scene that differs from that of `like` in its size alone: in its order of the nodes, with its
  // patches and its touch_gap, and with its pattern, unless that is too narrow: entries of bending that cancel on
  // squares are there on rectangles.
  ClothModel(const Scene& scene, const ClothModel& like);

  // Puts in how the constants vary over the cloth: not, as at first, or as the fields and pieces of `parameters` do,
  // which `ValidateParameters` accepts. Whether that changes anything.
  bool SetVariation(const Parameters& parameters);

  const Scene& scene() const { return *scene_; }
  const Mesh& chosen_on() const { return *chosen_on_; }  // for the model of another size
  int num_nodes() const { return scene_->mesh.num_nodes(); }

  // Handles are exact Dirichlet conditions: every equation lives on the free nodes alone. Vectors and matrices over
  // them are "free" [3 Nf], in an order of the nodes in which factors of matrices over them stay sparse; `Gather` and
  // `Scatter` go between a free vector and one over all nodes [3N].
  int num_free() const { return static_cast<int>(free_nodes_.size()); }
  const std::vector<int>& free_nodes() const { return free_nodes_; }  // [Nf] node
  const std::vector<int>& free_index() const { return free_index_; }  // [N] position in free_nodes, -1: a handle
  Eigen::VectorXd Gather(const Eigen::VectorXd& all) const;
  Eigen::MatrixXd GatherColumns(const Eigen::MatrixXd& all) const;
  void Scatter(const Eigen::VectorXd& free, Eigen::VectorXd* all) const;
  Eigen::MatrixXd ScatterColumns(const Eigen::MatrixXd& free) const;  // zero at handles
  // Likewise between columns over the handles [3H x s], in the order of the scene's, and those over all nodes.
  Eigen::MatrixXd GatherHandles(const Eigen::MatrixXd& all) const;
  Eigen::MatrixXd ScatterHandles(const Eigen::MatrixXd& held) const;  // zero at free nodes

  const std::shared_ptr<const BlockPattern>& pattern() const { return pattern_; }
  // All that acts on the cloth but contact: in the cloth and by the air by direction, and on every node by itself.
  const ForceSet& forces() const { return forces_; }
  const NodeForces& nodes() const { return nodes_; }
  const Eigen::VectorXd& node_areas() const { return nodes_.areas(); }                           // [N] m^2
  double mass(const Material& material, int node) const { return nodes_.mass(material, node); }  // kg
  const Eigen::VectorXd& laplacian_diagonal() const { return laplacian_diagonal_; }  // [N] of L, triangle_element.h
  const TriangleElements& triangles() const { return *triangles_; }
  // What priors of shapes take: the isotropic energy of the triangles, whatever membrane the scene has, and that of
  // k_b, null where the scene has none.
  const StretchEnergy& stretch() const { return *stretch_; }
  const BendingEnergy* bending() const;
  bool has_contact() const { return !scene_->obstacles.empty(); }
  double touch_gap() const { return touch_gap_; }  // m, velocity mode: the gap that counts as contact

 private:
  ClothModel(const Scene& scene, const Mesh& chosen_on, const ClothModel* like);
  // By what they couple beside triangles.
  void NumberFreeNodes(const std::vector<BendingMatrix>& bending, const Eigen::SparseMatrix<double>& seams);
  void MakeForces(BendingMatrices bending, Eigen::SparseMatrix<double> seams);
  const Scene* scene_;
  const Mesh* chosen_on_;
  std::vector<int> free_nodes_, free_index_;
  std::shared_ptr<const BlockPattern> pattern_;
  Eigen::VectorXd laplacian_diagonal_;
  double touch_gap_ = 0.0;
  std::shared_ptr<const TriangleElements> triangles_;
  std::optional<StretchEnergy> stretch_;
  NodeForces nodes_;
  ForceSet forces_;
  // How constants vary in them.
  std::shared_ptr<const std::vector<FieldFactors>> fields_;
  Material level_;
  std::vector<Material> piece_materials_;
};

}  // namespace clothid

#endif  // CLOTHID_SIM_CLOTH_CLOTH_MODEL_H_
