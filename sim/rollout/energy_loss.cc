#include "sim/rollout/energy_loss.h"

#include <cstddef>
#include <vector>

#include "sim/cloth/cloth_model.h"
#include "sim/force/seam_term.h"
#include "sim/rollout/simulator.h"
#include "sim/step/second_start.h"

namespace clothid {
namespace {

double& ShareOf(EnergyShare share, EnergyParts* parts) {
  if (share == EnergyShare::kSeams) return parts->seams;
  return share == EnergyShare::kBending ? parts->bending : parts->stretch;
}

// -d(stretch + bending + seams)/dx [3N], with the energies, which hold nothing of the start of a solve.
Eigen::VectorXd ElasticForce(const Parameters& parameters, const Eigen::VectorXd& positions, const ClothModel& model,
                             double time, EnergyParts* parts) {
  Eigen::VectorXd force = Eigen::VectorXd::Zero(positions.size());
  const ForcePoint point{parameters, /*time_step=*/0.0, time, positions, positions};
  for (const auto& term : model.forces().terms()) {
    if (term->group() != ForceGroup::kElastic) continue;
    ShareOf(term->energy_share(), parts) += term->AddForce(point, nullptr, &force);
  }
  return force;
}

Eigen::VectorXd DampingForce(const Parameters& parameters, const StepRecord& record, const SolveStart& start,
                             const ClothModel& model) {
  Eigen::VectorXd force = Eigen::VectorXd::Zero(record.positions.size());
  const ForceSet& forces = model.forces();
  if (!forces.has(ForceGroup::kViscous)) return force;
  HeldForces held;
  SetForceStart(forces, start, record.time_step, model.scene().handles.nodes, record.positions, &held.start);
  forces.Hold(parameters, record.time, &held);
  const ForcePoint point{parameters, record.time_step, record.time, record.positions, record.velocities};
  forces.AddForce(ForceGroup::kViscous, point, held, &force);
  return force;
}

}  // namespace

EnergyParts StateEnergy(const Parameters& parameters, const Eigen::VectorXd& positions,
                        const Eigen::VectorXd& velocities, const Simulator& simulator, double time) {
  const ClothModel& model = simulator.model();
  EnergyParts parts;
  ElasticForce(parameters, positions, model, time, &parts);
  for (const int node : model.free_nodes()) {
    const double weighty = parameters.material.density * model.nodes().mass_areas()[node];  // kg; air has no weight
    parts.kinetic += 0.5 * model.mass(parameters.material, node) * velocities.segment<3>(3 * node).squaredNorm();
    parts.gravitational -= weighty * model.scene().gravity.dot(positions.segment<3>(3 * node));
  }
  return parts;
}

double SolveWeight(const StepRecord& record) { return record.stage == Stage::kFirst ? kSecondStageReach : 1.0; }

InternalForces ForcesAtEnd(const Parameters& parameters, const StepRecord& record, const SolveStart& start,
                           const Simulator& simulator) {
  EnergyParts parts;
  return {ElasticForce(parameters, record.positions, simulator.model(), record.time, &parts),
          DampingForce(parameters, record, start, simulator.model())};
}

int FirstOfStep(const Rollout& rollout, int last) {
  return rollout.records[static_cast<std::size_t>(last)].stage == Stage::kSecond ? last - 1 : last;
}

VelocityChanges ChangesInStep(const Rollout& rollout, int last, RecordReader* reader) {
  VelocityChanges changes;
  const Eigen::VectorXd last_start = reader->start(last).velocities;
  changes.last = reader->record(last).velocities - last_start;
  changes.first = changes.impact = Eigen::VectorXd::Zero(last_start.size());
  const int first = FirstOfStep(rollout, last);
  if (first == last) return changes;
  const Eigen::VectorXd start = reader->start(first).velocities;
  changes.first = (last_start - start) / kSecondStageReach;
  changes.impact = reader->record(first).velocities - start - changes.first;
  return changes;
}

Eigen::VectorXd NodeInertiaLoss(const Parameters& parameters, const VelocityChanges& changes,
                                const Simulator& simulator) {
  const ClothModel& model = simulator.model();
  Eigen::VectorXd loss = Eigen::VectorXd::Zero(model.num_nodes());
  for (const int node : model.free_nodes()) {
    const Eigen::Vector3d b = changes.last.segment<3>(3 * node), c = changes.first.segment<3>(3 * node);
    const Eigen::Vector3d u = changes.impact.segment<3>(3 * node);
    loss[node] =
        model.mass(parameters.material, node) * (0.5 * b.squaredNorm() + c.dot(kSecondStageReach * u - 0.5 * c));
  }
  return loss;
}

double SeamWork(const Rollout& rollout, int last, RecordReader* reader, const Simulator& simulator) {
  const SeamTerm* const seams = simulator.model().forces().Find<SeamTerm>();
  double work = 0.0;
  for (int i = FirstOfStep(rollout, last); i <= last && seams != nullptr; ++i) {
    const StepRecord& record = reader->record(i);
    work += SolveWeight(record) * record.time_step * seams->energy().Power(record.time, record.positions);
  }
  return work;
}

double ClampWork(const Rollout& rollout, int last, RecordReader* reader, const Simulator& simulator) {
  const Handles& handles = simulator.scene().handles;
  double work = 0.0;
  for (int i = FirstOfStep(rollout, last); i <= last && !handles.clamped.empty(); ++i) {
    const StepRecord& record = reader->record(i);
    const ForcePoint point{rollout.parameters, record.time_step, record.time, record.positions, record.velocities};
    Eigen::VectorXd upon_slopes = Eigen::VectorXd::Zero(3 * handles.slopes.num_handles());
    simulator.model().forces().AddSlopeForce(point, &upon_slopes);
    work -= SolveWeight(record) * record.time_step * upon_slopes.dot(handles.slopes.RateAt(record.time));
  }
  return work;
}

EnergyLoss StepEnergyLoss(const Rollout& rollout, int last, RecordReader* reader, const Simulator& simulator) {
  const Parameters& parameters = rollout.parameters;
  const int first = FirstOfStep(rollout, last);
  EnergyLoss loss;
  loss.inertia = NodeInertiaLoss(parameters, ChangesInStep(rollout, last, reader), simulator).sum();
  for (int i = first; i <= last; ++i) {
    const StepRecord& record = reader->record(i);
    const InternalForces forces = ForcesAtEnd(parameters, record, reader->start(i), simulator);
    const Eigen::VectorXd displacement = SolveWeight(record) * record.time_step * record.velocities;
    loss.damping -= forces.viscous.dot(displacement);
    loss.elastic -= forces.elastic.dot(displacement);
  }
  loss.elastic += SeamWork(rollout, last, reader, simulator) + ClampWork(rollout, last, reader, simulator);
  const SolveStart start = reader->start(first);
  const double start_time = reader->record(first).time - reader->record(first).time_step;
  loss.elastic += StateEnergy(parameters, start.positions, start.velocities, simulator, start_time).elastic();
  const StepRecord& end = reader->record(last);
  loss.elastic -= StateEnergy(parameters, end.positions, end.velocities, simulator, end.time).elastic();
  return loss;
}

}  // namespace clothid
