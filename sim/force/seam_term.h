// Seams that are drawn together and buttons, sim/shell/seam_energy.h, among the forces in a cloth.
#ifndef CLOTHID_SIM_FORCE_SEAM_TERM_H_
#define CLOTHID_SIM_FORCE_SEAM_TERM_H_

#include <Eigen/Core>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "sim/force/force_term.h"
#include "sim/shell/seam_energy.h"

namespace clothid {

class SeamTerm final : public ForceTerm {
 public:
  explicit SeamTerm(SeamEnergy energy) : energy_(std::move(energy)) {}

  const SeamEnergy& energy() const { return energy_; }

  ForceGroup group() const override { return ForceGroup::kElastic; }
  EnergyShare energy_share() const override { return EnergyShare::kSeams; }
  double AddForce(const ForcePoint& point, const HeldForce* held, Eigen::VectorXd* force) const override;
  void AddPositionHessian(double factor, HessianKind kind, const ForcePoint& point, const HeldForce* held,
                          BlockMatrix* hessian) const override;
  std::optional<ConstantPart> SystemPart(const Material& material, double time_step) const override;
  void VisitCoupled(const std::vector<bool>& is_chosen, const NodeVisitor& visit) const override;
  std::unique_ptr<ForceTerm> PartOf(const ForcePart& part) const override;

 private:
  SeamEnergy energy_;
};

}  // namespace clothid

#endif  // CLOTHID_SIM_FORCE_SEAM_TERM_H_
