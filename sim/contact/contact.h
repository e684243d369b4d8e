// Which nodes may touch what: gaps and normals at the start of a step, and the contacts at its end.
#ifndef CLOTHID_SIM_CONTACT_CONTACT_H_
#define CLOTHID_SIM_CONTACT_CONTACT_H_

#include <Eigen/Core>
#include <vector>

#include "sim/contact/contact_law.h"
#include "sim/obstacle/obstacle_motion.h"

namespace clothid {

class ClothModel;

// A node that the contact law of this step covers, with the geometry at x_n that is held during the step. It has one
// obstacle: the one with the smallest gap. With several obstacles that choice jumps; the jumps are counted.
struct ContactCandidate {
  int node = 0;
  int obstacle = 0;
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();
  Eigen::Matrix3d normal_gradient = Eigen::Matrix3d::Zero();  // 1/m
  double gap = 0.0;                                           // phi(x_n), m, from the contact distance
  double gap_speed =
      0.0;  // what u_N may be at least, negated: phi/T, limited below by the depenetration speed; 0 in velocity mode
  // d gap_speed / d(n . x_n): 1/T (times the slope of the gap where the obstacle moves, obstacle_motion.h), or 0 where
  // limited and in velocity mode.
  double gap_speed_slope = 0.0;
  double least_speed = 0.0;                          // what n . v may be at least: n . V - gap_speed, m/s
  Eigen::Vector3d target = Eigen::Vector3d::Zero();  // V - gap_speed n, the velocity of a node that sticks, m/s
};

// A candidate in contact at the end of the step, with the response of the law there.
struct Contact {
  ContactCandidate candidate;
  ContactResponse response;
  Eigen::Vector3d force = Eigen::Vector3d::Zero();  // F, see contact_law.h
  double weight = 0.0;                              // d, kg
  // In a first stage, what the obstacle's velocity there has changed by since its start, m/s.
  Eigen::Vector3d obstacle_gain = Eigen::Vector3d::Zero();
  double friction_coefficient = 0.0;  // mu of the obstacle
};

// What a rollout keeps of a contact; the rest follows from the state at the start of the step.
struct ContactRecord {
  int node = 0;
  int obstacle = 0;
  ContactBranch branch = ContactBranch::kTakeOff;
  Eigen::Vector3d force = Eigen::Vector3d::Zero();  // F

  bool operator<(const ContactRecord& other) const { return node < other.node; }
};

// `node` and its nearest obstacle in a solve that starts at `positions` [3N]. `gap_time`: T, within which a gap may be
// used up, s; the size of the solve, unless sim/step/stage.h says otherwise. `motions`: of the obstacles over the
// solve; none where all stand still.
void FindCandidate(const ClothModel& model, int node, const Eigen::VectorXd& positions, double gap_time,
                   const std::vector<ObstacleMotion>& motions, ContactCandidate* candidate);

// The candidates of a solve that starts at `positions` [3N], among the free nodes: in gap mode every one, in velocity
// mode those with gap <= touch. `candidates` is overwritten.
void FindCandidates(const ClothModel& model, const Eigen::VectorXd& positions, double gap_time,
                    const std::vector<ObstacleMotion>& motions, std::vector<ContactCandidate>* candidates);

// What the velocity of `obstacle` near `position` changes by over a first stage, m/s (`Contact::obstacle_gain`).
Eigen::Vector3d ObstacleGain(const std::vector<ObstacleMotion>& motions, int obstacle, const Eigen::Vector3d& position);

// dPhi/dx_n of a contact through normal, gap and V: X = -[D + S d (gap_speed_slope n n^T + gap_speed N' - W)], W =
// dV/dx of its obstacle; `motion` is that near the node, or null: it stands still.
Eigen::Matrix3d ContactPositionJacobian(const Contact& contact, const AffineMotion* motion = nullptr);

// d(J^T r)/dtheta of a contact at fixed v and x_n, where its obstacle's motion depends on theta: `change`.
Eigen::Vector3d ContactMotionDerivative(const Contact& contact, const MotionChange& change);

}  // namespace clothid

#endif  // CLOTHID_SIM_CONTACT_CONTACT_H_
