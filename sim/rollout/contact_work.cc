#include "sim/rollout/contact_work.h"

#include <algorithm>
#include <vector>

#include "sim/contact/impact_share.h"
#include "sim/rollout/energy_loss.h"
#include "sim/rollout/simulator.h"
#include "sim/step/obstacle_motions.h"

namespace clothid {
namespace {

void AddNode(const Contact& contact, const StepRecord& record, const SolveStart& start,
             const std::vector<ObstacleMotion>& motions, double mass, ContactWork* work) {
  const int row = 3 * contact.candidate.node;
  Eigen::Vector3d impulse = contact.response.impulse;
  if (record.stage == Stage::kFirst) {
    const Eigen::Vector3d change = record.velocities.segment<3>(row) - start.velocities.segment<3>(row);
    impulse -= mass * ImpactVelocity(contact, mass, change);
  }
  impulse *= SolveWeight(record);
  const Eigen::Vector3d place = start.positions.segment<3>(row);
  const Eigen::Vector3d carried = motions.empty()
                                      ? Eigen::Vector3d(Eigen::Vector3d::Zero())
                                      : motions[contact.candidate.obstacle].Near(place).velocity().At(place);
  work->work += impulse.dot(carried);
  work->friction -= impulse.dot(record.velocities.segment<3>(row) - carried);
}

void AddPair(const PairContact& contact, const StepRecord& record, const PairImpactNodes& nodes,
             const Eigen::VectorXd& velocities, ContactWork* work) {
  const PairCandidate& pair = contact.candidate;
  Eigen::Vector3d impulse = SolveWeight(record) * contact.response.impulse;
  if (record.stage == Stage::kFirst) impulse *= 1.0 - EvaluatePairImpact(contact, nodes).share;
  const Eigen::Vector3d relative = pair.RelativeVelocity(velocities);
  const Eigen::Vector3d& normal = pair.geometry.normal;
  work->work -= impulse.dot(pair.held_velocity);
  work->friction -= impulse.dot(relative);
  work->push += std::max(0.0, normal.dot(impulse) * normal.dot(relative));
}

void AddSolve(const StepRecord& record, const SolveStart& start, const Parameters& parameters,
              const Simulator& simulator, ContactWork* work) {
  if (record.contacts.empty()) return;
  const ClothModel& model = simulator.model();
  const std::vector<ObstacleMotion> motions = ObstacleMotions(model.scene(), parameters, record.times());
  const ContactSet contacts = RestoreContacts(record, start.positions, motions, parameters, model);
  for (const Contact& contact : contacts.nodes) {
    AddNode(contact, record, start, motions, model.mass(parameters.material, contact.candidate.node), work);
  }
  const Eigen::VectorXd velocities = model.Gather(record.velocities);
  const SolveMotion motion{model, parameters.material, start.velocities, record.velocities};
  for (const PairContact& contact : contacts.pairs) {
    AddPair(contact, record, ImpactNodes(contact.candidate, motion), velocities, work);
  }
}

}  // namespace

ContactWork& ContactWork::operator+=(const ContactWork& other) {
  work += other.work;
  friction += other.friction;
  push += other.push;
  return *this;
}

ContactWork StepContactWork(const Rollout& rollout, int last, RecordReader* reader, const Simulator& simulator) {
  ContactWork work;
  for (int i = FirstOfStep(rollout, last); i <= last; ++i) {
    AddSolve(reader->record(i), reader->start(i), rollout.parameters, simulator, &work);
  }
  return work;
}

}  // namespace clothid
