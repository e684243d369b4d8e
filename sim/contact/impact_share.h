// The part of a contact's impulse that stops an impact, in closed form, and its derivatives.
//
// A solve took a node of mass m from v_n to v_1, with the impulse r of a contact of normal n, r_N = n . r > 0, and the
// impulse p = m (v_1 - v_n) - r of all other forces. Of r_N the share s = -n . p/r_N balances what presses the node on;
// what is left has changed its normal velocity. With c = v_1 - v_n, less what the velocity of its obstacle there has
// changed by (`Contact::obstacle_gain`), this is
//   1 - s = L = m n . c/r_N, held within 0 and 1:   0 for a node that rests or slides on a plane,
//                                                  1 where nothing presses it on
//   u = L r/m = (n . c) e, e = r/r_N, while 0 < L < 1:   the change of velocity that stopped the impact, m/s
// u is continuous: between its branches, and at take-off, where r vanishes. A second-order step leaves it out of what
// it carries over from its first stage (sim/step/second_start.h).
#ifndef CLOTHID_SIM_CONTACT_IMPACT_SHARE_H_
#define CLOTHID_SIM_CONTACT_IMPACT_SHARE_H_

#include <Eigen/Core>

#include "sim/contact/contact.h"

namespace clothid {

// L of a sticking or slipping node; `velocity_change` is v_1 - v_n.
double ImpactShare(const Contact& contact, double mass, const Eigen::Vector3d& velocity_change);

// u.
Eigen::Vector3d ImpactVelocity(const Contact& contact, double mass, const Eigen::Vector3d& velocity_change);

// du = U_c d(v_1 - v_n) + U_r dr + U_x dx_n + u_m dm, with N' = dn/dx; `motion` of the obstacle, null where it stands
// still:
//   0 < L < 1:   U_c = e n^T,   U_r = (n . c)/r_N (I - e n^T),   U_n = e (c - (n . c) e)^T,   u_m = 0
//   L = 1:       U_c = 0,       U_r = I/m,                       U_n = 0,                     u_m = -r/m^2
// U_x = U_n N' - U_c G, G the gradient of the obstacle's gain of velocity.
struct ImpactVelocityDerivative {
  Eigen::Matrix3d change = Eigen::Matrix3d::Zero();    // U_c
  Eigen::Matrix3d impulse = Eigen::Matrix3d::Zero();   // U_r, 1/kg
  Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();    // U_n, m/s
  Eigen::Matrix3d position = Eigen::Matrix3d::Zero();  // U_x, 1/s
  Eigen::Vector3d mass = Eigen::Vector3d::Zero();      // u_m, m/(s kg)
};
ImpactVelocityDerivative DifferentiateImpactVelocity(const Contact& contact, double mass,
                                                     const Eigen::Vector3d& velocity_change,
                                                     const AffineMotion* motion = nullptr);

}  // namespace clothid

#endif  // CLOTHID_SIM_CONTACT_IMPACT_SHARE_H_
