#include "sim/rollout/energy_loss.h"

#include <cstddef>
#include <vector>

#include "sim/cloth/cloth_model.h"
#include "sim/rollout/simulator.h"
#include "sim/step/second_start.h"

namespace clothid {
namespace {

// -d(stretch + bending + seams)/dx [3N], with the energies.
Eigen::VectorXd ElasticForce(const Material& material, const Eigen::VectorXd& positions, const ClothModel& model,
                             double time, EnergyParts* parts) {
  Eigen::VectorXd force = Eigen::VectorXd::Zero(positions.size());
  parts->stretch = model.membrane().AddForce(material, positions, &force);
  for (const BendingTerm& term : model.bending_terms()) {
    const double stiffness = term.stiffness(material);
    parts->bending += stiffness * term.AddForce(stiffness, positions, &force);
  }
  if (model.seams() != nullptr) parts->seams = model.seams()->AddForce(time, positions, &force);
  return force;
}

Eigen::VectorXd DampingForce(const Material& material, const StepRecord& record, const SolveStart& start,
                             const ClothModel& model) {
  Eigen::VectorXd force = Eigen::VectorXd::Zero(record.positions.size());
  if (model.damping() == nullptr) return force;
  std::vector<MetricBatch> start_metrics;
  SetStartMetrics(model, start, &start_metrics);
  model.damping()->AddForce(material.damping, record.time_step, start_metrics, record.positions, &force);
  return force;
}

}  // namespace

EnergyParts StateEnergy(const Parameters& parameters, const Eigen::VectorXd& positions,
                        const Eigen::VectorXd& velocities, const Simulator& simulator, double time) {
  const ClothModel& model = simulator.model();
  EnergyParts parts;
  ElasticForce(parameters.material, positions, model, time, &parts);
  for (const int node : model.free_nodes()) {
    const double weighty = parameters.material.density * model.mass_areas()[node];  // kg; air has no weight
    parts.kinetic += 0.5 * model.mass(parameters.material, node) * velocities.segment<3>(3 * node).squaredNorm();
    parts.gravitational -= weighty * model.scene().gravity.dot(positions.segment<3>(3 * node));
  }
  return parts;
}

double SolveWeight(const StepRecord& record) { return record.stage == Stage::kFirst ? kSecondStageReach : 1.0; }

InternalForces ForcesAtEnd(const Parameters& parameters, const StepRecord& record, const SolveStart& start,
                           const Simulator& simulator) {
  EnergyParts parts;
  return {ElasticForce(parameters.material, record.positions, simulator.model(), record.time, &parts),
          DampingForce(parameters.material, record, start, simulator.model())};
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
  const SeamEnergy* seams = simulator.model().seams();
  double work = 0.0;
  for (int i = FirstOfStep(rollout, last); i <= last && seams != nullptr; ++i) {
    const StepRecord& record = reader->record(i);
    work += SolveWeight(record) * record.time_step * seams->Power(record.time, record.positions);
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
  loss.elastic += SeamWork(rollout, last, reader, simulator);
  const SolveStart start = reader->start(first);
  const double start_time = reader->record(first).time - reader->record(first).time_step;
  loss.elastic += StateEnergy(parameters, start.positions, start.velocities, simulator, start_time).elastic();
  const StepRecord& end = reader->record(last);
  loss.elastic -= StateEnergy(parameters, end.positions, end.velocities, simulator, end.time).elastic();
  return loss;
}

}  // namespace clothid
