// Air drag that depends on how the wind meets the cloth. Per triangle with rest area a and unit normal n, u = w - v the
// wind relative to the cloth at its centre (v the mean of its corners' velocities), s = u . n, u_t = u - s n:
//
//   linear      f = a (c_n s n + c_t u_t),             D = a/2 (c_n s^2 + c_t |u_t|^2)
//   quadratic   f = a (c_n |s| s n + c_t |u_t| u_t),   D = a/3 (c_n |s|^3 + c_t |u_t|^3)
// a third of f on each corner. D is the potential of the force for a fixed normal: the force on corner i is -dD/dv_i,
// and d2D/dv2 is symmetric and positive semidefinite. The sign of n does not matter.
//
// During a solve normals and wind are held: n is the normal at the positions x^ that its start predicts
// (sim/step/second_start.h), so that the force depends on them as well: dF/dx^ below.
#ifndef CLOTHID_SIM_FORCE_DIRECTIONAL_DRAG_H_
#define CLOTHID_SIM_FORCE_DIRECTIONAL_DRAG_H_

#include <Eigen/Core>
#include <memory>
#include <utility>
#include <vector>

#include "sim/air/wind.h"
#include "sim/force/force_term.h"
#include "sim/matrix/block_matrix.h"
#include "sim/scene/scene.h"
#include "sim/shell/triangle_element.h"

namespace clothid {

struct AirBatch;
struct DragConstants;

class DirectionalDrag final : public ForceTerm {
 public:
  // `triangles`, `free_index` and `pattern` as of `MakeTriangleElements`, `places` those of the nodes at rest [N].
  DirectionalDrag(AirLaw law, std::vector<RestPlace> places, std::shared_ptr<const TriangleElements> triangles,
                  const std::vector<int>& free_index, const BlockPattern& pattern);

  ForceGroup group() const override { return ForceGroup::kAir; }
  bool needs_velocities() const override { return true; }
  bool needs_prediction() const override { return true; }
  void Hold(const Parameters& parameters, double time, const ForceStart& start,
            std::unique_ptr<HeldForce>* held) const override;
  double AddForce(const ForcePoint& point, const HeldForce* held, Eigen::VectorXd* force) const override;
  void AddVelocityHessian(double factor, const ForcePoint& point, const HeldForce* held,
                          BlockMatrix* hessian) const override;
  void AddVelocityProduct(double factor, const ForcePoint& point, const HeldForce* held, const Eigen::MatrixXd& columns,
                          Eigen::MatrixXd* product) const override;
  void AddPredictionProduct(double factor, const ForcePoint& point, const HeldForce* held,
                            const Eigen::VectorXd& predicted, const Eigen::MatrixXd& columns,
                            Eigen::MatrixXd* product) const override;
  void AddPredictionProductTransposed(double factor, const ForcePoint& point, const HeldForce* held,
                                      const Eigen::VectorXd& predicted, const Eigen::MatrixXd& columns,
                                      Eigen::MatrixXd* product) const override;
  void AddDerivative(ParameterId id, double factor, const ForcePoint& point, const HeldForce* held,
                     Eigen::VectorXd* force) const override;
  std::unique_ptr<ForceTerm> PartOf(const ForcePart& part) const override;

 private:
  double AddForceOf(const DragConstants& constants, const Eigen::VectorXd& velocities, const std::vector<AirBatch>& air,
                    Eigen::VectorXd* force) const;  // F; returns D, W
  void AddWindDerivative(ParameterId id, double factor, const ForcePoint& point, const std::vector<AirBatch>& air,
                         Eigen::VectorXd* force) const;

  // Of a batch: where d2D/dv2 has its blocks, invalid for handles, and the centres at rest.
  struct Places {
    BlockPosition blocks[3][3][kLanes];
    RestPlace centers[kLanes];
  };

  AirLaw law_;
  std::vector<RestPlace> nodes_;  // [N]
  std::shared_ptr<const TriangleElements> triangles_;
  std::vector<Places> places_;
};

}  // namespace clothid

#endif  // CLOTHID_SIM_FORCE_DIRECTIONAL_DRAG_H_
