// Contacts of a cloth with itself: a point of one feature against a point of another.
//
// With the weights w of the two closest points (pair_geometry.h) and nodes of velocity v_i, the relative velocity is
// u = sum w_i v_i, and the impulse r of the contact acts on node i as w_i r. Weights, normal n and gap are those at
// x_n, held during the step. Two surfaces touch at the distance `thickness`: gap = |e| - thickness. The law is that of
// contact_law.h on (r, u) in gap mode, r an unknown of the step beside v:
//   R = r - Pi(a) = 0,   a = r - d (u + gap_speed n),   d = (sum w_i^2/d_i)^-1 over free nodes
// Pi(a) is the impulse of that law at the force F = -a: zero, a itself, or a on the cone of friction. d scales the
// equation and does not change its solution.
#ifndef CLOTHID_SIM_CONTACT_SELF_CONTACT_H_
#define CLOTHID_SIM_CONTACT_SELF_CONTACT_H_

#include <Eigen/Core>
#include <array>
#include <vector>

#include "sim/contact/contact_law.h"
#include "sim/contact/pair_geometry.h"

namespace clothid {

// What thinning leaves out is taken back where it comes nearer than this share of the thickness.
inline constexpr double kLeastPairDistance = 0.75;

// A pair that the law covers in a solve, with what is held of it.
struct PairCandidate {
  PairFeatures features;
  PairGeometry geometry;                                    // at x_n
  std::array<int, 4> blocks = {-1, -1, -1, -1};             // of its nodes among the free ones; -1: a handle, or unused
  double gap = 0.0;                                         // m
  double gap_speed = 0.0;                                   // gap/T, limited below (MakePairCandidate), m/s
  double gap_speed_slope = 0.0;                             // 1/T, or 0 where limited
  Eigen::Vector3d held_velocity = Eigen::Vector3d::Zero();  // w_i v_i of handles, m/s
  double weight = 0.0;                                      // d, kg

  // False: a pair that thinning has left out and the step has shown to be needed. It keeps its nodes apart, no more.
  bool has_friction = true;

  double FrictionOf(double friction_coefficient) const { return has_friction ? friction_coefficient : 0.0; }
  // Sets `held_velocity` and `weight`, from the velocities of all nodes [3N], of which those of handles count, and d of
  // the pair's nodes, in its order.
  void SetNodes(const Eigen::VectorXd& velocities, const Eigen::Vector4d& weights);
  // u from the velocities of the free nodes [3 Nf].
  Eigen::Vector3d RelativeVelocity(const Eigen::VectorXd& velocities) const;
};

// A pair with the law at the end of a solve.
struct PairContact {
  PairCandidate candidate;
  ContactResponse response;                         // at F
  Eigen::Vector3d force = Eigen::Vector3d::Zero();  // F = -a, N s
  double friction_coefficient = 0.0;                // mu of the pair
};

// What a rollout keeps of a pair in contact.
struct PairContactRecord {
  PairFeatures features;
  Eigen::Vector3d force = Eigen::Vector3d::Zero();  // F
  ContactBranch branch = ContactBranch::kTakeOff;
  bool has_friction = true;

  bool operator<(const PairContactRecord& other) const { return features < other.features; }
};

// The candidate of `features` at `positions` [3N], but for `weight` and `held_velocity`. `free_index` maps nodes to
// blocks. `gap_time` as for obstacles (sim/step/stage.h). Layers that start nearer than the thickness are pushed apart
// with the speed that takes them to kLeastPairDistance in `gap_time`, and the rest of the way with at most 20
// thicknesses per second; altogether with at most the depenetration speed. Thinning takes in pairs that are somewhat
// too near, and to push these apart at once would throw the layers off each other.
PairCandidate MakePairCandidate(const PairFeatures& features, const Eigen::VectorXd& positions,
                                const std::vector<int>& free_index, double thickness, double gap_time,
                                double depenetration_speed);

// dR/dx_n [3 x 12] at fixed v and r, by the nodes of the pair. `velocities` [3N], those of handles included.
Eigen::Matrix<double, 3, 12> PairPositionJacobian(const PairContact& contact, const PairGeometryGradient& gradient,
                                                  const Eigen::VectorXd& velocities);

// dR/dmu at fixed v, r and x_n.
Eigen::Vector3d PairFrictionDerivative(const ContactResponse& response);

}  // namespace clothid

#endif  // CLOTHID_SIM_CONTACT_SELF_CONTACT_H_
