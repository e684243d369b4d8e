// Dry frictional contact of one node (Eq. (8) of the DiffCloth paper) in closed form, and its derivatives.
//
// With an isotropic d > 0, the gradient g of the momentum balance and the velocity V of the obstacle's material point,
// put  F = d (v - V) - g + (d gap_speed) n  in world axes, where gap_speed is phi/h in gap mode and 0 in velocity mode;
// f_N = n . F, f_T = F - f_N n. Then the impulse on the node is
//   take-off  f_N >= 0:          r = 0
//   stick     |f_T| <= -mu f_N:  r = -F
//   slip      otherwise:         r = -f_N n + mu f_N t,   t = f_T / |f_T|
// It is continuous across the branches. mu = 0 is always slip: "stick by 0 <= 0" would give the right impulse and a
// wrong derivative.
#ifndef CLOTHID_SIM_CONTACT_CONTACT_LAW_H_
#define CLOTHID_SIM_CONTACT_CONTACT_LAW_H_

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace clothid {

enum class ContactBranch { kTakeOff, kStick, kSlip };

// The law evaluated at F; everything in world axes.
struct ContactResponse {
  ContactBranch branch = ContactBranch::kTakeOff;
  Eigen::Vector3d impulse = Eigen::Vector3d::Zero();         // J^T r, N s
  double normal_force = 0.0;                                 // f_N, N s; negative in contact
  double tangential_force = 0.0;                             // |f_T|, N s
  Eigen::Vector3d slip_direction = Eigen::Vector3d::Zero();  // t; any tangent where f_T = 0; zero unless slipping
};

// At every node in every evaluation of a step: inline.
inline ContactResponse EvaluateContactLaw(const Eigen::Vector3d& force, const Eigen::Vector3d& normal,
                                          double friction_coefficient) {
  ContactResponse response;
  response.normal_force = normal.dot(force);
  if (response.normal_force >= 0.0) return response;
  const Eigen::Vector3d tangential = force - response.normal_force * normal;
  response.tangential_force = tangential.norm();
  const double friction_limit = -friction_coefficient * response.normal_force;
  if (friction_coefficient > 0.0 && response.tangential_force <= friction_limit) {
    response.branch = ContactBranch::kStick;
    response.impulse = -force;
    return response;
  }
  response.branch = ContactBranch::kSlip;
  if (response.tangential_force > 0.0) {
    response.slip_direction = tangential / response.tangential_force;
  } else {
    response.slip_direction = normal.unitOrthogonal();
  }
  response.impulse = -response.normal_force * normal - friction_limit * response.slip_direction;
  return response;
}

// S = d(J^T r)/dF: 0 for take-off, -I for stick, -n n^T + mu t n^T + c b b^T for slip, with c = mu f_N/|f_T|, b = n x
// t.
Eigen::Matrix3d ImpulseForceJacobian(const ContactResponse& response, const Eigen::Vector3d& normal,
                                     double friction_coefficient);

// D = d(J^T r)/dx_n through the normal alone, at fixed F, with N' = dn/dx. Zero unless slipping:
//   B = -n F^T - f_N I,   D = B N' + mu t F^T N' + c (I - t t^T) B N'
Eigen::Matrix3d ImpulsePositionJacobian(const ContactResponse& response, const Eigen::Vector3d& force,
                                        const Eigen::Vector3d& normal, const Eigen::Matrix3d& normal_gradient,
                                        double friction_coefficient);

// c = mu f_N/|f_T| of a slipping node, in (-1, 0].
double SlipRatio(const ContactResponse& response, double friction_coefficient);

}  // namespace clothid

#endif  // CLOTHID_SIM_CONTACT_CONTACT_LAW_H_
