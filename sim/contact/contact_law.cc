#include "sim/contact/contact_law.h"

namespace clothid {

double SlipRatio(const ContactResponse& response, double friction_coefficient) {
  if (friction_coefficient == 0.0) return 0.0;
  return friction_coefficient * response.normal_force / response.tangential_force;
}

Eigen::Matrix3d ImpulseForceJacobian(const ContactResponse& response, const Eigen::Vector3d& normal,
                                     double friction_coefficient) {
  switch (response.branch) {
    case ContactBranch::kTakeOff:
      return Eigen::Matrix3d::Zero();
    case ContactBranch::kStick:
      return -Eigen::Matrix3d::Identity();
    case ContactBranch::kSlip:
      break;
  }
  const Eigen::Vector3d& t = response.slip_direction;
  const Eigen::Vector3d b = normal.cross(t);
  return (friction_coefficient * t - normal) * normal.transpose() +
         SlipRatio(response, friction_coefficient) * b * b.transpose();
}

Eigen::Matrix3d ImpulsePositionJacobian(const ContactResponse& response, const Eigen::Vector3d& force,
                                        const Eigen::Vector3d& normal, const Eigen::Matrix3d& normal_gradient,
                                        double friction_coefficient) {
  if (response.branch != ContactBranch::kSlip) return Eigen::Matrix3d::Zero();
  const Eigen::Vector3d& t = response.slip_direction;
  const Eigen::RowVector3d force_gradient = force.transpose() * normal_gradient;  // F^T N', that of f_N at fixed F
  const Eigen::Matrix3d tangential_gradient =
      -normal * force_gradient - response.normal_force * normal_gradient;  // B N'
  return tangential_gradient + friction_coefficient * t * force_gradient +
         SlipRatio(response, friction_coefficient) * (tangential_gradient - t * (t.transpose() * tangential_gradient));
}

}  // namespace clothid
