// Whether a cloth that meets itself has stayed out of itself, found out from its positions alone.
#ifndef CLOTHID_SIM_ROLLOUT_SELF_CONTACT_AUDIT_H_
#define CLOTHID_SIM_ROLLOUT_SELF_CONTACT_AUDIT_H_

#include <Eigen/Core>
#include <memory>

#include "sim/rollout/rollout.h"
#include "sim/scene/scene.h"

namespace clothid {

class Simulator;

struct SelfContactAudit {
  int num_states = 0;     // that were looked at
  int intersections = 0;  // pairs of triangles that cut each other (sim/contact/intersections.h), over all states
  int num_cut = 0;        // states that have some
  int first_cut = -1;     // the first of these; -1: none
  // m: how much nearer than the thickness two parts of the cloth came at most; the whole thickness where triangles cut.
  double violation = 0.0;
  int deepest = -1;  // the first state of that; -1: none came nearer
  // Of a rollout: its steps that ended with a pair in contact which thinning had left out
  // (sim/contact/pair_thinning.h), so that contacts depend on each other and the derivative of the step is not certain.
  int dependent_steps = 0;
  double push = 0.0;  // J, of a rollout: what its parts gained by pushing each other apart (`ContactWork::push`)
};

// Takes one state after the other. Not to be used by several threads at once.
class SelfContactAuditor {
 public:
  // Of a scene with self-contact.
  explicit SelfContactAuditor(const Scene& scene);
  ~SelfContactAuditor();

  void Add(const Eigen::VectorXd& positions);  // [3N] m
  const SelfContactAudit& audit() const { return audit_; }

 private:
  struct Search;
  std::unique_ptr<Search> search_;
  double thickness_;
  SelfContactAudit audit_;
};

// State n is that after n steps of `rollout`, of the scene of `simulator`; nothing where that has no self-contact.
SelfContactAudit AuditSelfContact(const Rollout& rollout, Simulator* simulator);

}  // namespace clothid

#endif  // CLOTHID_SIM_ROLLOUT_SELF_CONTACT_AUDIT_H_
