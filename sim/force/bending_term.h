// The bending of a cloth by one constant of its material: an energy that is quadratic in the positions
// (sim/shell/bending_energy.h) and of the slopes at clamps, which the time tells, and what a curved rest shape adds to
// it (sim/shell/rest_curvature.h).
#ifndef CLOTHID_SIM_FORCE_BENDING_TERM_H_
#define CLOTHID_SIM_FORCE_BENDING_TERM_H_

#include <Eigen/Core>
#include <cstddef>
#include <memory>
#include <optional>
#include <vector>

#include "sim/force/field_terms.h"
#include "sim/force/force_term.h"
#include "sim/path/handle_path.h"
#include "sim/scene/scene.h"
#include "sim/shell/bending_energy.h"
#include "sim/shell/rest_curvature.h"

namespace clothid {

// What the bending of a scene is made of, before a pattern is there that covers it.
struct BendingMatrices {
  std::vector<BendingMatrix> matrices;    // of k_b, or three along warp, weft and twist; none without bending
  std::vector<WeightedBending> weighted;  // likewise, where constants vary over the cloth; else empty
};
// `chosen_on`: of patches, as `BendingPatches` has it.
BendingMatrices MakeBendingMatrices(const Scene& scene, const Mesh& chosen_on);

class BendingTerm;
// The term of `parts->matrices[place]`, which it takes.
std::unique_ptr<BendingTerm> MakeBendingTerm(BendingMatrices* parts, std::size_t place, const Scene& scene,
                                             const std::vector<int>& free_index, const BlockPattern& pattern);

class BendingTerm final : public ForceTerm {
 public:
  // `pattern`, the pattern of the Hessian over the free nodes, must cover `matrix`; `free_index` [N] maps nodes to it
  // (-1: a handle). `weighted` (may be null): of a constant that varies. `pieces`: what each piece of the cloth, and
  // last the whole, has per unit of the constant; empty where it is the same in all. `slopes`: at clamps, over time.
  BendingTerm(BendingMatrix matrix, std::shared_ptr<const WeightedBending> weighted, std::vector<BendingMatrix> pieces,
              HandlePath slopes, const std::vector<int>& free_index, const BlockPattern& pattern);

  ParameterKind kind() const { return kind_; }
  double stiffness(const Material& material) const { return material.*RowOf(kind_).constant; }
  const BendingEnergy& energy() const { return energy_; }
  const RestCurvature* curvature() const { return curvature_.get(); }  // null: the cloth is flat at rest

  ForceGroup group() const override { return ForceGroup::kElastic; }
  EnergyShare energy_share() const override { return EnergyShare::kBending; }
  void SetVariation(const ForceVariation& variation) override;
  double AddForce(const ForcePoint& point, const HeldForce* held, Eigen::VectorXd* force) const override;
  void AddPositionHessian(double factor, HessianKind hessian_kind, const ForcePoint& point, const HeldForce* held,
                          BlockMatrix* hessian) const override;
  void AddSlopeForce(const ForcePoint& point, Eigen::VectorXd* force) const override;
  void AddDerivative(ParameterId id, double factor, const ForcePoint& point, const HeldForce* held,
                     Eigen::VectorXd* force) const override;
  void AddFieldProducts(const FieldFactors& field, double factor, const ForcePoint& point,
                        const Eigen::MatrixXd& columns, Eigen::Ref<Eigen::MatrixXd> products) const override;
  FieldDirection AlongField(ParameterKind kind, const Eigen::VectorXd& weights) const override;
  std::optional<ConstantPart> SystemPart(const Material& material, double time_step) const override;
  void VisitCoupled(const std::vector<bool>& is_chosen, const NodeVisitor& visit) const override;
  std::unique_ptr<ForceTerm> PartOf(const ForcePart& part) const override;

 private:
  // Of energy, curvature and clamps: adds stiffness times their force per unit of the constant, and returns the energy.
  double AddForceTimes(double stiffness, const ForcePoint& point, Eigen::VectorXd* force) const;
  Eigen::VectorXd SlopesAt(double time) const { return HasClamps() ? slope_path_.At(time) : Eigen::VectorXd(); }
  bool HasClamps() const { return !slopes_.is_empty(); }

  ParameterKind kind_;
  BendingEnergy energy_;
  std::shared_ptr<const RestCurvature> curvature_;  // null: of none
  SlopeBending slopes_;
  HandlePath slope_path_;
  std::shared_ptr<const WeightedBending> weighted_;
  std::vector<BendingMatrix> pieces_;
};

}  // namespace clothid

#endif  // CLOTHID_SIM_FORCE_BENDING_TERM_H_
