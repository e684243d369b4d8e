#include "sim/rollout/self_contact_audit.h"

#include "sim/cloth/cloth_model.h"
#include "sim/contact/intersections.h"
#include "sim/contact/self_contact_search.h"
#include "sim/rollout/contact_work.h"
#include "sim/rollout/record_reader.h"
#include "sim/rollout/simulator.h"

namespace clothid {

struct SelfContactAuditor::Search {
  Search(const Mesh& mesh, double thickness) : counter(mesh), search(mesh, thickness) {}

  IntersectionCounter counter;
  SelfContactSearch search;
};

SelfContactAuditor::SelfContactAuditor(const Scene& scene)
    : search_(std::make_unique<Search>(scene.mesh, scene.self_contact->thickness)),
      thickness_(scene.self_contact->thickness) {}

SelfContactAuditor::~SelfContactAuditor() = default;

void SelfContactAuditor::Add(const Eigen::VectorXd& positions) {
  const int state = audit_.num_states++, count = search_->counter.Count(positions).count;
  if (count > 0) {
    audit_.intersections += count;
    ++audit_.num_cut;
    if (audit_.first_cut < 0) audit_.first_cut = state;
  }
  const double violation = count > 0 ? thickness_ : thickness_ - search_->search.LeastDistance(positions);
  if (!(violation > audit_.violation)) return;
  audit_.violation = violation;
  audit_.deepest = state;
}

SelfContactAudit AuditSelfContact(const Rollout& rollout, Simulator* simulator) {
  if (!simulator->scene().self_contact) return {};
  RecordReader reader(rollout, simulator);
  SelfContactAuditor auditor(simulator->model().scene());
  auditor.Add(rollout.initial_positions);
  int dependent_steps = 0, first = 0;
  double push = 0.0;
  for (const int last : rollout.last_record) {
    bool is_dependent = false;
    for (int i = first; i <= last; ++i) {
      const StepRecord& record = reader.record(i);
      is_dependent = is_dependent || record.contacts.depend();
      if (record.ends_step()) push += StepContactWork(rollout, i, &reader, *simulator).push;
    }
    dependent_steps += is_dependent;
    auditor.Add(reader.record(last).positions);
    first = last + 1;
  }
  SelfContactAudit audit = auditor.audit();
  audit.dependent_steps = dependent_steps;
  audit.push = push;
  return audit;
}

}  // namespace clothid
