// A pressure of the air on one side of a cloth: pillows, parachutes, a sheet that is blown against something.
//
//   f = p A n,   a third of it on each corner
// for a triangle of area A and unit normal n where it is, A n = (x_1 - x_0) x (x_2 - x_0)/2, about which its corners
// run counter-clockwise: p > 0 pushes it that way. The total force on a closed cloth is zero.
//
// The force turns with the cloth, so that it has no energy where the cloth has a border. During a solve it is held,
// with A n at the positions x^ that its start predicts, as the normals of drag by direction are. It is of second order
// in h.
#ifndef CLOTHID_SIM_FORCE_PRESSURE_TERM_H_
#define CLOTHID_SIM_FORCE_PRESSURE_TERM_H_

#include <Eigen/Core>
#include <memory>
#include <utility>

#include "sim/force/force_term.h"

namespace clothid {

class PressureTerm final : public ForceTerm {
 public:
  // `faces` [3 x F] of the mesh.
  explicit PressureTerm(Eigen::Matrix3Xi faces) : faces_(std::move(faces)) {}

  ForceGroup group() const override { return ForceGroup::kAir; }
  bool needs_prediction() const override { return true; }
  void Hold(const Parameters& parameters, double time, const ForceStart& start,
            std::unique_ptr<HeldForce>* held) const override;
  double AddForce(const ForcePoint& point, const HeldForce* held, Eigen::VectorXd* force) const override;
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
  Eigen::Matrix3Xi faces_;
};

}  // namespace clothid

#endif  // CLOTHID_SIM_FORCE_PRESSURE_TERM_H_
