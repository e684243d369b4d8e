// Internal damping, sim/shell/strain_rate_damping.h, among the forces in a cloth.
#ifndef CLOTHID_SIM_FORCE_DAMPING_TERM_H_
#define CLOTHID_SIM_FORCE_DAMPING_TERM_H_

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "sim/force/force_term.h"
#include "sim/shell/strain_rate_damping.h"

namespace clothid {

class DampingTerm final : public ForceTerm {
 public:
  // `face_pieces`: the piece of each of the `triangles`; empty where the damping is the same in all.
  DampingTerm(std::shared_ptr<const TriangleElements> triangles, std::vector<int> face_pieces);

  ForceGroup group() const override { return ForceGroup::kViscous; }
  bool needs_origins() const override { return true; }
  void SetVariation(const ForceVariation& variation) override;
  void Hold(const Parameters& parameters, double time, const ForceStart& start,
            std::unique_ptr<HeldForce>* held) const override;
  double AddForce(const ForcePoint& point, const HeldForce* held, Eigen::VectorXd* force) const override;
  void AddPositionHessian(double factor, HessianKind kind, const ForcePoint& point, const HeldForce* held,
                          BlockMatrix* hessian) const override;
  void AddOriginProduct(double factor, const ForcePoint& point, const Eigen::VectorXd& origin,
                        const Eigen::MatrixXd& columns, Eigen::MatrixXd* product) const override;
  void AddOriginProductTransposed(double factor, const ForcePoint& point, const Eigen::VectorXd& origin,
                                  const Eigen::MatrixXd& columns, Eigen::MatrixXd* product) const override;
  void AddDerivative(ParameterId id, double factor, const ForcePoint& point, const HeldForce* held,
                     Eigen::VectorXd* force) const override;
  double LaplacianWeight(const Material& material, double time_step) const override;
  std::unique_ptr<ForceTerm> PartOf(const ForcePart& part) const override;

 private:
  std::shared_ptr<const TriangleElements> triangles_;
  std::vector<int> face_pieces_;  // [F]; empty: one
  Eigen::VectorXd weights_;       // [F] of the pieces to the level; empty: 1
  StrainRateDamping damping_;
};

}  // namespace clothid

#endif  // CLOTHID_SIM_FORCE_DAMPING_TERM_H_
