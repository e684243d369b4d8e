// The contacts of a solve, those of nodes with obstacles and those of the cloth with itself, in one place: which there
// may be, what the law makes of them at a point of the solve, and which of them are there in contact. Whoever solves,
// searches along a line or records asks here, and need not know what kinds there are.
//
// At an obstacle F and the impulse follow from v and g alone (contact_law.h). A pair's impulse r is an unknown of the
// solve beside v, with R = 0 beside Phi = 0 (self_contact.h). J^T r of the pairs is taken off g first, so that with it
//   Phi_i = g_i - r_i(F_i),   F_i = d_i (v_i - V_i) - g_i + d_i gap_speed n      at every node i that may touch
//   R_c   = r_c - Pi(-F_c),   F_c = d_c (J v + gap_speed n)_c - r_c              of every pair c
#ifndef CLOTHID_SIM_CONTACT_STEP_CONTACTS_H_
#define CLOTHID_SIM_CONTACT_STEP_CONTACTS_H_

#include <Eigen/Core>
#include <map>
#include <memory>
#include <vector>

#include "sim/contact/contact_set.h"
#include "sim/contact/self_contact_search.h"
#include "sim/scene/parameters.h"

namespace clothid {

// The equations of the cloth's pairs with itself, in their order.
struct PairPoint {
  Eigen::Matrix3Xd impulses;               // r
  Eigen::Matrix3Xd residuals;              // R
  std::vector<Eigen::Vector3d> forces;     // F
  std::vector<ContactResponse> responses;  // at F
};

// The contacts at a point of a solve.
struct ContactPoint {
  std::vector<Eigen::Vector3d> forces;     // F, per candidate
  std::vector<ContactResponse> responses;  // per candidate
  PairPoint pairs;                         // whose J^T r are taken off g; r is given before the evaluation
};

// mu of every obstacle and of the cloth with itself, as long as `obstacles` lives.
struct ContactFriction {
  const std::vector<double>& obstacles;
  double self = 0.0;
};

// Impulses of pairs in contact over the size of their solve, r/h, N.
using PairMemory = std::map<PairFeatures, Eigen::Vector3d>;

class StepContacts {
 public:
  // Where a solve starts, over what times, and d of the free nodes, kg. `handle_velocities` [3N]: of the way of handles
  // over the solve; read where the cloth may touch itself. `gap_time`: T of sim/step/stage.h.
  struct Start {
    const Eigen::VectorXd& positions;   // x_n [3N] m
    const Eigen::VectorXd& velocities;  // v_n [3N] m/s
    const Eigen::VectorXd& handle_velocities;
    const Eigen::VectorXd& weights;
    double gap_time;
  };
  // What a solve from `start` may touch, in place of what an earlier call has found. `motions`: of the obstacles over
  // it, empty where all stand still. Model, positions and weights must outlive the calls below; an object serves one
  // model.
  void Find(const ClothModel& model, const Start& start, std::vector<ObstacleMotion> motions);

  const std::vector<ObstacleMotion>& motions() const { return motions_; }
  const std::vector<ContactCandidate>& candidates() const { return candidates_; }
  const std::vector<PairCandidate>& pairs() const { return pairs_; }
  bool may_touch() const { return !candidates_.empty(); }    // an obstacle
  bool may_touch_itself() const { return !pairs_.empty(); }  // then r are unknowns, too
  int free_block(int candidate) const;                       // its node among the free nodes
  double weight(int candidate) const;                        // d of its node, kg
  Eigen::Index num_impulses() const { return static_cast<Eigen::Index>(pairs_.size()); }  // columns of r

  // Adds the pairs that thinning has left out and that `velocities` [3 Nf] bring too near, without friction. True:
  // there are some, and the step has to be solved again, with rows that may depend on each other.
  bool TakeBack(const Eigen::VectorXd& velocities);

  // What `velocities` [3 Nf] ended with: covers the recorded pairs beside those that thinning accepts and gives `point`
  // their impulses r = d (u + gap_speed n) - F. False: one of them is none that the solve could have.
  bool Restore(const ContactSet& recorded, const Eigen::VectorXd& velocities, ContactPoint* point);

  // J^T r [3 Nf] of impulses r, columns [3 x c] or one below the other.
  Eigen::VectorXd Spread(const Eigen::Ref<const Eigen::VectorXd>& impulses) const;
  // Takes J^T r at `point` off g [3 Nf].
  void SubtractImpulses(const ContactPoint& point, Eigen::VectorXd* momentum_gradient) const;
  // What else `point` has, from v and g [3 Nf], and Phi.
  void ApplyLaw(const ContactFriction& friction, const Eigen::VectorXd& velocities,
                const Eigen::VectorXd& momentum_gradient, ContactPoint* point, Eigen::VectorXd* residual) const;

  // What is added to the potential whose gradient is g where normal impulses r_N are held as at `lagged`: friction
  // mu r_N |u_T| at obstacles and pairs, less the work r_N n . u of pairs, J.
  double HeldPotential(const ContactFriction& friction, const ContactPoint& lagged,
                       const Eigen::VectorXd& velocities) const;
  // square += sum |R_c|^2/d_c.
  void AddWeighedSquare(const ContactPoint& point, double* square) const;

  // v_N <- max(v_N, V_N - gap_speed) at every candidate.
  void ClipToFeasible(Eigen::VectorXd* velocities) const;

  // r of pairs that `memory` knows, as h times that; zero of others.
  void Recall(const PairMemory& memory, double time_step, ContactPoint* point) const;
  // What `memory` then knows: the pairs in contact at `point`.
  void Remember(const ContactPoint& point, double time_step, PairMemory* memory) const;

  // The sticking and slipping nodes at `point`, and all of its pairs, those that leave as well, overwrite `contacts`.
  void ContactsAt(const ContactFriction& friction, const ContactPoint& point, ContactSet* contacts) const;

 private:
  void FindPairs(const ClothModel& model, const Start& start);
  void ApplyPairLaw(const ContactFriction& friction, const Eigen::VectorXd& velocities, PairPoint* point) const;

  const std::vector<int>* free_index_ = nullptr;  // of the model
  const Eigen::VectorXd* start_positions_ = nullptr;
  const Eigen::VectorXd* weights_ = nullptr;
  double gap_time_ = 0.0;
  double thickness_ = 0.0;
  std::vector<ObstacleMotion> motions_;
  std::vector<ContactCandidate> candidates_;   // empty without obstacles
  std::unique_ptr<SelfContactSearch> search_;  // of the model's mesh; null without self-contact
  std::vector<int> follow_order_;              // of its nodes (pair_thinning.h)
  std::vector<PairFeatures> near_pairs_;       // that it has found
  std::vector<PairCandidate> pairs_;           // those that the solve covers
  std::vector<PairCandidate> left_out_;
};

// A solve that is over.
struct SolvedStep {
  const Eigen::VectorXd& start_positions;  // x_n [3N] m
  const Eigen::VectorXd& velocities;       // v_{n+1} [3N] m/s, those of handles among them
  double time_step;                        // s
  double gap_time;                         // T, s
};

// The contacts that `records` kept of `step`, over which obstacles had `motions`: the numbers of its solver to the last
// bit.
ContactSet RestoreContacts(const ContactRecords& records, const SolvedStep& step,
                           const std::vector<ObstacleMotion>& motions, const Parameters& parameters,
                           const ClothModel& model);

}  // namespace clothid

#endif  // CLOTHID_SIM_CONTACT_STEP_CONTACTS_H_
