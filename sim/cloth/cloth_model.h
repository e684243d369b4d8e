// The terms that a scene has, built once per simulator: no obstacle, no contact; k_b = 0, no bending; c_d = 0, no drag
// that is the same in every direction; c_n = c_t = 0, none by direction; eta = 0, no internal damping. Constants that
// vary over the cloth (sim/scene/material_field.h, sim/scene/pieces.h) are put into the terms by SetVariation.
#ifndef CLOTHID_SIM_CLOTH_CLOTH_MODEL_H_
#define CLOTHID_SIM_CLOTH_CLOTH_MODEL_H_

#include <Eigen/Core>
#include <memory>
#include <optional>
#include <vector>

#include "sim/cloth/air_drag.h"
#include "sim/cloth/cloth_pieces.h"
#include "sim/cloth/directional_drag.h"
#include "sim/cloth/field_terms.h"
#include "sim/cloth/membrane.h"
#include "sim/cloth/strain_rate_damping.h"
#include "sim/cloth/stretch_energy.h"
#include "sim/matrix/block_matrix.h"
#include "sim/scene/scene.h"
#include "sim/shell/bending_energy.h"
#include "sim/shell/rest_curvature.h"
#include "sim/shell/seam_energy.h"

namespace clothid {

// A bending energy times one constant of a material.
struct BendingTerm {
  ParameterKind kind;
  double Material::*constant;  // of that kind
  BendingEnergy energy;
  std::shared_ptr<const RestCurvature> curvature;  // null: the cloth is flat at rest

  double stiffness(const Material& material) const { return material.*constant; }
  // Of both, as they stand there.
  double AddForce(double stiffness, const Eigen::VectorXd& positions, Eigen::VectorXd* force) const;
  void AddHessian(double stiffness, HessianKind hessian_kind, const Eigen::VectorXd& positions,
                  BlockMatrix* hessian) const;
};

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

  const std::shared_ptr<const BlockPattern>& pattern() const { return pattern_; }
  const Eigen::VectorXd& node_areas() const { return node_areas_; }  // [N] m^2
  // [N] m^2, those times the factors of the density, if it varies. Times density: what has weight.
  const Eigen::VectorXd& mass_areas() const { return has_density_field() ? mass_areas_ : node_areas_; }
  // M of a node, kg: of the cloth and of the air that moves with it.
  double mass(const Material& material, int node) const {
    return material.density * mass_areas()[node] + material.added_mass * node_areas_[node];
  }
  // dM/dtheta of every node [N]; null for a constant that has no part in it.
  const Eigen::VectorXd* MassSlopes(ParameterId id) const;
  // The areas [N] m^2 that c_d `id` multiplies, of a scene with drag.
  const Eigen::VectorXd& DragAreas(ParameterId id) const;
  // Adds factor * (-d2E/(dx dtheta)) to `force` [3N], theta a constant of bending.
  void AddBendingDerivative(ParameterId id, double factor, const Eigen::VectorXd& positions,
                            Eigen::VectorXd* force) const;
  // What eta `id` of a scene with damping multiplies; it takes the metrics of damping().
  StrainRateDamping DampingOf(ParameterId id) const;
  bool has_density_field() const { return mass_areas_.size() > 0; }
  const Eigen::VectorXd& laplacian_diagonal() const { return laplacian_diagonal_; }  // [N] of L, triangle_element.h
  const TriangleElements& triangles() const { return *triangles_; }
  const Membrane& membrane() const { return *membrane_; }
  // The isotropic energy of the triangles, whatever membrane the scene has: priors of shapes take it.
  const StretchEnergy& stretch() const { return *stretch_; }
  // One of k_b, or three along warp, weft and twist; none: the scene has no bending.
  const std::vector<BendingTerm>& bending_terms() const { return bending_terms_; }
  const BendingEnergy* bending() const;                              // that of k_b; null: the scene has none
  const AirDrag* drag() const { return drag_ ? &*drag_ : nullptr; }  // null: the scene has none
  const DirectionalDrag* directional_drag() const {
    return directional_drag_ ? &*directional_drag_ : nullptr;
  }                                                                                     // ditto
  const SeamEnergy* seams() const { return seams_ ? &*seams_ : nullptr; }               // null: the mesh has no link
  const StrainRateDamping* damping() const { return damping_ ? &*damping_ : nullptr; }  // null: the scene has none
  // Of k_b that is a field; else meaningless, or null.
  const WeightedBending* weighted_bending() const {
    return weighted_bending_.empty() ? nullptr : &weighted_bending_.front();
  }
  // Null: the constant is the same in all pieces, or there is but one.
  const ClothPieces* PiecesOf(ParameterKind kind) const {
    return pieces_ != nullptr && scene_->has_of_pieces(kind) ? pieces_.get() : nullptr;
  }
  bool has_contact() const { return !scene_->obstacles.empty(); }
  double touch_gap() const { return touch_gap_; }  // m, velocity mode: the gap that counts as contact

 private:
  ClothModel(const Scene& scene, const Mesh& chosen_on, const ClothModel* like);
  std::vector<BendingMatrix> MakeBending();
  void MakePieces();
  void SetFields(const std::vector<FieldFactors>* fields);
  void SetPieces(const Parameters& parameters);
  void SetBending(std::size_t term, const Eigen::VectorXd& weights);
  // By what they couple beside triangles.
  void NumberFreeNodes(const std::vector<BendingMatrix>& bending, const Eigen::SparseMatrix<double>& seams);
  std::shared_ptr<const RestCurvature> MakeCurvature(std::vector<RestMoment> moments) const;  // null of none

  const Scene* scene_;
  const Mesh* chosen_on_;
  std::vector<int> free_nodes_, free_index_;
  std::shared_ptr<const BlockPattern> pattern_;
  Eigen::VectorXd node_areas_, laplacian_diagonal_;
  Eigen::VectorXd mass_areas_;  // empty where the density does not vary
  double touch_gap_ = 0.0;
  std::shared_ptr<const TriangleElements> triangles_;
  std::optional<Membrane> membrane_;
  std::optional<StretchEnergy> stretch_;
  std::optional<SeamEnergy> seams_;
  std::vector<BendingTerm> bending_terms_;
  std::vector<WeightedBending> weighted_bending_;  // of every term; empty: none varies
  std::unique_ptr<const ClothPieces> pieces_;      // null: one
  // How constants vary in the terms.
  std::shared_ptr<const std::vector<FieldFactors>> fields_;
  Material level_;
  std::vector<Material> piece_materials_;
  std::optional<AirDrag> drag_;
  std::optional<DirectionalDrag> directional_drag_;
  std::optional<StrainRateDamping> damping_;
};

}  // namespace clothid

#endif  // CLOTHID_SIM_CLOTH_CLOTH_MODEL_H_
