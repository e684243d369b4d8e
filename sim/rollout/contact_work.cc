#include "sim/rollout/contact_work.h"

#include <vector>

#include "sim/contact/impact_share.h"
#include "sim/rollout/energy_loss.h"
#include "sim/rollout/simulator.h"
#include "sim/step/step_problem.h"

namespace clothid {
namespace {

void AddSolve(const StepRecord& record, const SolveStart& start, const Parameters& parameters,
              const Simulator& simulator, ContactWork* work) {
  if (record.contacts.empty()) return;
  const ClothModel& model = simulator.model();
  const std::vector<ObstacleMotion> motions = ObstacleMotions(model.scene(), parameters, record.times());
  for (const Contact& contact :
       RestoreContacts(model, parameters, start.positions, record.times(), motions, record.contacts)) {
    const int row = 3 * contact.candidate.node;
    Eigen::Vector3d impulse = contact.response.impulse;
    if (record.stage == Stage::kFirst) {
      const double mass = model.mass(parameters.material, contact.candidate.node);
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
}

}  // namespace

ContactWork StepContactWork(const Rollout& rollout, int last, RecordReader* reader, const Simulator& simulator) {
  ContactWork work;
  const int first = FirstOfStep(rollout, last);
  for (int i = first; i <= last; ++i) {
    AddSolve(reader->record(i), reader->start(i), rollout.parameters, simulator, &work);
  }
  return work;
}

}  // namespace clothid
