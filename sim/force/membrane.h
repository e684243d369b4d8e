// What resists strain in the surface of a cloth: the energy of the law that its scene has, with the constants of a
// material, or, of a cloth of pieces, of a material each.
#ifndef CLOTHID_SIM_FORCE_MEMBRANE_H_
#define CLOTHID_SIM_FORCE_MEMBRANE_H_

#include <Eigen/Core>
#include <memory>
#include <variant>
#include <vector>

#include "sim/force/force_term.h"
#include "sim/scene/parameters.h"
#include "sim/scene/scene.h"
#include "sim/shell/orthotropic_energy.h"
#include "sim/shell/stretch_energy.h"
#include "sim/shell/yarn_energy.h"

namespace clothid {

struct MembranePart;

class Membrane {
 public:
  // Laws along warp and weft want the shape gradients of `triangles` in these axes.
  Membrane(MembraneLaw law, std::shared_ptr<const TriangleElements> triangles);
  // The sum of those of pieces, which have their materials in place of those given below.
  explicit Membrane(std::vector<MembranePart> parts);
  // Other materials for these parts; nothing where there are none.
  void SetMaterials(const std::vector<Material>& materials);

  // Adds -dE/dx to `force` [3N] and returns E for positions [3N], J.
  double AddForce(const Material& material, const Eigen::VectorXd& positions, Eigen::VectorXd* force) const;

  // Adds factor * d2E/dx2 below the diagonal of `hessian`, for `BlockMatrix::CompleteFromLower`.
  void AddHessian(double factor, const Material& material, HessianKind kind, const Eigen::VectorXd& positions,
                  BlockMatrix* hessian, ThreadTeam* team) const;

  // Adds factor * (-d2E/(dx dtheta)) to `force` [3N], theta the constant `id`: E is linear in every one but a
  // stiffening. Nothing for one that the law does not have.
  void AddForceDerivative(ParameterId id, double factor, const Material& material, const Eigen::VectorXd& positions,
                          Eigen::VectorXd* force) const;

  // k of the constant matrix of projective dynamics, P = .. + h^2 k L, N/m: of a law along warp and weft
  // the largest eigenvalue of its constants.
  double SystemStiffness(const Material& material) const;

  // Of yarns; else 1.
  double StiffnessGrowth(const Material& material, const Eigen::VectorXd& positions) const;

  // Adds factor * -dE_f/dx . y of every triangle f to `products` [F x s], for columns y [3N x s]; not of pieces.
  void AddForceProducts(double factor, const Material& material, const Eigen::VectorXd& positions,
                        const Eigen::MatrixXd& columns, Eigen::Ref<Eigen::MatrixXd> products) const;

 private:
  std::variant<StretchEnergy, OrthotropicEnergy, YarnEnergy, std::shared_ptr<const std::vector<MembranePart>>> energy_;
};

// A piece, or what belongs to none.
struct MembranePart {
  Membrane membrane;
  Material material;
};

// The membrane of every piece, with its material. `face_pieces`: of each of the `triangles`, an index of `materials`.
std::vector<MembranePart> MembraneParts(MembraneLaw law, const TriangleElements& triangles,
                                        const std::vector<int>& face_pieces, const std::vector<Material>& materials);

class MembraneTerm final : public ForceTerm {
 public:
  // `materials`: of the pieces of `face_pieces`, as above; empty where the cloth is one.
  MembraneTerm(MembraneLaw law, std::shared_ptr<const TriangleElements> triangles, std::vector<int> face_pieces,
               std::vector<Material> materials);

  const Membrane& membrane() const { return membrane_; }

  ForceGroup group() const override { return ForceGroup::kElastic; }
  void SetVariation(const ForceVariation& variation) override;
  double AddForce(const ForcePoint& point, const HeldForce* held, Eigen::VectorXd* force) const override;
  void AddPositionHessian(double factor, HessianKind kind, const ForcePoint& point, const HeldForce* held,
                          BlockMatrix* hessian) const override;
  void AddDerivative(ParameterId id, double factor, const ForcePoint& point, const HeldForce* held,
                     Eigen::VectorXd* force) const override;
  void AddFieldProducts(const FieldFactors& field, double factor, const ForcePoint& point,
                        const Eigen::MatrixXd& columns, Eigen::Ref<Eigen::MatrixXd> products) const override;
  FieldDirection AlongField(ParameterKind kind, const Eigen::VectorXd& weights) const override;
  double LaplacianWeight(const Material& material, double time_step) const override;
  bool stiffens() const override { return law_ == MembraneLaw::kYarn; }
  double StiffnessGrowth(const ForcePoint& point) const override;
  std::unique_ptr<ForceTerm> PartOf(const ForcePart& part) const override;

 private:
  // A constant along warp, weft or of shear that is a field: E is linear in it, and this is its part.
  struct ConstantPart {
    ParameterKind kind;
    Eigen::VectorXd weights;  // [F]
    Membrane membrane;        // of triangles that count by them

    // That has the constant alone, the other way of law and stiffening as they are.
    Material Own(const Material& material) const;
  };

  void SetWeights(Eigen::VectorXd weights);
  void SetConstantPart(ParameterKind kind, Eigen::VectorXd weights);
  const ConstantPart* FindPart(ParameterKind kind) const;
  // `material` without the constants of the parts.
  Material Others(const Material& material) const;

  MembraneLaw law_;
  std::shared_ptr<const TriangleElements> triangles_;
  std::vector<int> face_pieces_;     // [F]
  std::vector<Material> materials_;  // [P + 1]; empty: one
  Eigen::VectorXd weights_;          // [F] of a field of k_stretch; empty: none
  std::vector<ConstantPart> parts_;  // of laws along warp and weft; empty: no constant is a field
  std::vector<int> faces_;           // [F] of a part: which triangles of the mesh; empty: all
  Membrane membrane_;
};

}  // namespace clothid

#endif  // CLOTHID_SIM_FORCE_MEMBRANE_H_
