// The forces that a scene has in its cloth: a list of terms, one that it lacks is not there. Over the whole cloth, or a
// part of it.
#ifndef CLOTHID_SIM_FORCE_FORCE_SET_H_
#define CLOTHID_SIM_FORCE_FORCE_SET_H_

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <memory>
#include <utility>
#include <vector>

#include "sim/force/force_term.h"
#include "sim/scene/parameters.h"

namespace clothid {

// What a solve holds of its start.
struct HeldForces {
  ForceStart start;
  std::vector<std::unique_ptr<HeldForce>> terms;  // null: the term holds nothing
};

class ForceSet {
 public:
  // Sums are taken in the order in which terms come.
  void Add(std::unique_ptr<ForceTerm> term);

  const std::vector<std::unique_ptr<ForceTerm>>& terms() const { return terms_; }
  bool has(ForceGroup group) const { return has_group_[static_cast<std::size_t>(group)]; }
  bool needs_velocities() const { return needs_velocities_; }
  bool needs_origins() const { return needs_origins_; }
  bool needs_prediction() const { return needs_prediction_; }
  bool needs_start() const { return needs_origins_ || needs_prediction_; }
  bool stiffens() const { return stiffens_; }
  // The first term of a type; null: there is none.
  template <typename Term>
  const Term* Find() const {
    for (const auto& term : terms_) {
      if (const auto* found = dynamic_cast<const Term*>(term.get())) return found;
    }
    return nullptr;
  }

  void SetVariation(const ForceVariation& variation);
  // Takes `held->start` in, for the solve that ends at `time`. Memory of other solves of these forces is used again.
  void Hold(const Parameters& parameters, double time, HeldForces* held) const;

  // Adds the forces of a group to `force` [3N] and returns their potential, J.
  double AddForce(ForceGroup group, const ForcePoint& point, const HeldForces& held, Eigen::VectorXd* force) const;

  // position_factor * -df/dx + velocity_factor * -df/dv over the free nodes overwrites `hessian`: of what K has of
  // forces, h^2 and h (sim/step/step_problem.h).
  void SetHessian(HessianKind kind, const ForcePoint& point, const HeldForces& held, double position_factor,
                  double velocity_factor, BlockMatrix* hessian) const;
  // Of all terms what `ForceTerm` says.
  void AddVelocityProduct(double factor, const ForcePoint& point, const HeldForces& held,
                          const Eigen::MatrixXd& columns, Eigen::MatrixXd* product) const;
  void AddOriginProduct(double factor, const ForcePoint& point, const Eigen::VectorXd& origin,
                        const Eigen::MatrixXd& columns, Eigen::MatrixXd* product) const;
  void AddOriginProductTransposed(double factor, const ForcePoint& point, const Eigen::VectorXd& origin,
                                  const Eigen::MatrixXd& columns, Eigen::MatrixXd* product) const;
  void AddPredictionProduct(double factor, const ForcePoint& point, const HeldForces& held,
                            const Eigen::MatrixXd& columns, Eigen::MatrixXd* product) const;
  void AddPredictionProductTransposed(double factor, const ForcePoint& point, const HeldForces& held,
                                      const Eigen::MatrixXd& columns, Eigen::MatrixXd* product) const;
  void AddSlopeForce(const ForcePoint& point, Eigen::VectorXd* force) const;
  void AddDerivative(ParameterId id, double factor, const ForcePoint& point, const HeldForces& held,
                     Eigen::VectorXd* force) const;
  void AddFieldProducts(const FieldFactors& field, double factor, const ForcePoint& point,
                        const Eigen::MatrixXd& columns, Eigen::Ref<Eigen::MatrixXd> products) const;

  // The sum of what terms add to the constant matrix of projective dynamics times L, kg.
  double LaplacianWeight(const Material& material, double time_step) const;

  // Of the term that has stiffened most.
  double StiffnessGrowth(const ForcePoint& point) const;

  // Sets of nodes that terms couple beside triangles, each with one of `chosen`, for `MakeForcePart`.
  std::vector<std::vector<int>> CoupledWith(const std::vector<int>& chosen, int num_nodes) const;
  ForceSet PartOf(const ForcePart& part) const;

 private:
  std::vector<std::unique_ptr<ForceTerm>> terms_;
  // Of any of them.
  std::array<bool, 3> has_group_ = {false, false, false};
  bool needs_velocities_ = false, needs_origins_ = false, needs_prediction_ = false, stiffens_ = false;
};

}  // namespace clothid

#endif  // CLOTHID_SIM_FORCE_FORCE_SET_H_
