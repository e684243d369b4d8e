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

// What a solve holds of a batch of triangles: n, and w at their centres, m/s.
struct alignas(64) AirBatch {
  double normal[3][kLanes];
  double wind[3][kLanes];
};

struct DragConstants {
  double normal = 0.0, tangential = 0.0;  // c_n and c_t: kg/(m^2 s), or kg/m^3 where the law is quadratic
};

class DirectionalDrag {
 public:
  // `triangles`, `free_index` and `pattern` as of `MakeTriangleElements`, `places` those of the nodes at rest [N].
  DirectionalDrag(AirLaw law, const std::vector<RestPlace>& places, std::shared_ptr<const TriangleElements> triangles,
                  const std::vector<int>& free_index, const BlockPattern& pattern);

  // Normals at `positions` x^ [3N], the wind at `time`.
  void SetAir(const Eigen::VectorXd& positions, const Wind& wind, double time, std::vector<AirBatch>* air) const;

  // Adds F [3N] at `velocities` [3N] to `force` and returns D, W.
  double AddForce(const DragConstants& constants, const Eigen::VectorXd& velocities, const std::vector<AirBatch>& air,
                  Eigen::VectorXd* force) const;
  // Adds factor * d2D/dv2, to a matrix that is whole on either side of its diagonal.
  void AddHessian(double factor, const DragConstants& constants, const Eigen::VectorXd& velocities,
                  const std::vector<AirBatch>& air, BlockMatrix* hessian) const;
  // Adds factor * d2D/dv2 y to `product`, for columns y [3N x s].
  void AddVelocityProduct(double factor, const DragConstants& constants, const Eigen::VectorXd& velocities,
                          const std::vector<AirBatch>& air, const Eigen::MatrixXd& columns,
                          Eigen::MatrixXd* product) const;
  // Adds factor * dF/dx^ y, and its transpose times y. `positions`: x^.
  void AddNormalProduct(double factor, const DragConstants& constants, const Eigen::VectorXd& velocities,
                        const std::vector<AirBatch>& air, const Eigen::VectorXd& positions,
                        const Eigen::MatrixXd& columns, Eigen::MatrixXd* product) const;
  void AddNormalProductTransposed(double factor, const DragConstants& constants, const Eigen::VectorXd& velocities,
                                  const std::vector<AirBatch>& air, const Eigen::VectorXd& positions,
                                  const Eigen::MatrixXd& columns, Eigen::MatrixXd* product) const;
  // Adds factor * dF/dtheta to `force` [3N], theta the parameter `id` of `wind`.
  void AddWindDerivative(double factor, const DragConstants& constants, const Eigen::VectorXd& velocities,
                         const std::vector<AirBatch>& air, const Wind& wind, double time, ParameterId id,
                         Eigen::VectorXd* force) const;

 private:
  // Of a batch: where d2D/dv2 has its blocks, invalid for handles, and the centres at rest.
  struct Places {
    BlockPosition blocks[3][3][kLanes];
    RestPlace centers[kLanes];
  };

  AirLaw law_;
  std::shared_ptr<const TriangleElements> triangles_;
  std::vector<Places> places_;
};

// Among the forces in a cloth.
class DirectionalDragTerm final : public ForceTerm {
 public:
  DirectionalDragTerm(AirLaw law, std::vector<RestPlace> places, std::shared_ptr<const TriangleElements> triangles,
                      const std::vector<int>& free_index, const BlockPattern& pattern)
      : law_(law), places_(std::move(places)), drag_(law, places_, std::move(triangles), free_index, pattern) {}

  const DirectionalDrag& drag() const { return drag_; }

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
  AirLaw law_;
  std::vector<RestPlace> places_;  // [N]
  DirectionalDrag drag_;
};

}  // namespace clothid

#endif  // CLOTHID_SIM_FORCE_DIRECTIONAL_DRAG_H_
