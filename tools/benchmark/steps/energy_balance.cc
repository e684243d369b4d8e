#include "tools/benchmark/steps/energy_balance.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "sim/cloth/cloth_model.h"
#include "sim/rollout/record_reader.h"
#include "sim/rollout/simulator.h"
#include "sim/step/second_start.h"
#include "sim/step/step_problem.h"
#include "sim/step/step_solver.h"

namespace clothid {
namespace {

constexpr double kRoundings = 4.0;  // that a sum over the neighbours of a node takes, in units of eps

// -d(stretch + bending)/dx [3N], with the energies.
Eigen::VectorXd ElasticForce(const Material& material, const Eigen::VectorXd& positions, const ClothModel& model,
                             EnergyParts* parts) {
  Eigen::VectorXd force = Eigen::VectorXd::Zero(positions.size());
  const double k = material.stretch_stiffness, k_bend = material.bending_stiffness;
  parts->stretch = k * model.stretch().AddForce(k, positions, &force);
  if (model.bending() != nullptr) parts->bending = k_bend * model.bending()->AddForce(k_bend, positions, &force);
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

// What rounding makes of the energies of a state and of the work of its forces. The stretch energy k/2 a |F - R|^2 is
// computed from differences of positions, the bending energy from the positions themselves.
double EnergyRounding(const EnergyParts& parts, const Material& material, const Eigen::VectorXd& positions,
                      const ClothModel& model) {
  const double eps = std::numeric_limits<double>::epsilon();
  const double size = positions.lpNorm<Eigen::Infinity>();
  const double stretch = 3.0 * material.stretch_stiffness * model.laplacian_diagonal().sum();
  double sum = parts.kinetic + std::abs(parts.gravitational) + parts.elastic();
  sum += size * std::sqrt(2.0 * parts.stretch * stretch) + eps * size * size * stretch;
  if (model.bending() != nullptr) {
    sum += 3.0 * material.bending_stiffness * model.bending()->diagonal().sum() * size * size;
  }
  return kRoundings * eps * sum;
}

// What a solve is taken for in the balance of its step: kappa times for a first stage.
double Weight(const StepRecord& record) { return record.stage == Stage::kFirst ? kSecondStageReach : 1.0; }

void AddAir(const StepRecord& record, const Material& material, const ClothModel& model, EnergyFlow* flow) {
  const double seconds = Weight(record) * record.time_step;
  for (const int node : model.free_nodes()) {
    const Eigen::Vector3d v = record.velocities.segment<3>(3 * node);
    flow->force_work += seconds * model.scene().node_force.dot(v);
    if (model.drag() == nullptr) continue;
    flow->air_work +=
        seconds * material.drag * model.node_areas()[node] * (model.drag()->WindAt(node, record.time) - v).dot(v);
  }
}

// Works of the forces in the cloth; as elastic_loss, minus that of elastic forces.
void AddInternalForces(const StepRecord& record, const SolveStart& start, const Parameters& parameters,
                       const Simulator& simulator, EnergyFlow* flow) {
  const ClothModel& model = simulator.model();
  EnergyParts parts = StateEnergy(parameters, record.positions, record.velocities, simulator);
  const Eigen::VectorXd elastic = ElasticForce(parameters.material, record.positions, model, &parts);
  const Eigen::VectorXd viscous = DampingForce(parameters.material, record, start, model);
  const Eigen::VectorXd displacement = Weight(record) * record.time_step * record.velocities;
  for (const int node : model.scene().handles.nodes) {
    flow->handle_work -= (elastic + viscous).segment<3>(3 * node).dot(displacement.segment<3>(3 * node));
  }
  flow->damping_loss -= viscous.dot(displacement);
  flow->elastic_loss -= elastic.dot(displacement);
  flow->tolerance += EnergyRounding(parts, parameters.material, record.positions, model);
}

// What contacts do at the nodes of a step [N].
struct NodeWork {
  Eigen::ArrayXd work;        // of impulses, without those that push, J
  Eigen::ArrayXd in_contact;  // 1: in a solve of the step, 0: in none
};

// `impacts`: u [3N] of a first stage, zero of others.
void AddContacts(const StepRecord& record, const SolveStart& start, const Eigen::VectorXd& impacts,
                 const Parameters& parameters, Simulator* simulator, EnergyFlow* flow, NodeWork* nodes) {
  const ClothModel& model = simulator->model();
  const StepProblem problem(model, parameters, start, record.times(), &simulator->step_workspace());
  StepPoint point;
  problem.Evaluate(model.Gather(record.velocities), &point);
  for (std::size_t i = 0; i < point.responses.size(); ++i) {
    if (point.responses[i].branch == ContactBranch::kTakeOff) continue;
    const ContactCandidate& candidate = problem.candidates()[i];
    const double mass = parameters.material.density * model.node_areas()[candidate.node];
    const Eigen::Vector3d v = record.velocities.segment<3>(3 * candidate.node);
    const Eigen::Vector3d impulse =
        Weight(record) * (point.responses[i].impulse - mass * impacts.segment<3>(3 * candidate.node));
    const double work = impulse.dot(v), push = candidate.normal.dot(impulse) * candidate.normal.dot(v);
    flow->contact_work += work;
    flow->push_work += std::max(0.0, push);
    nodes->work[candidate.node] += work - std::max(0.0, push);
    nodes->in_contact[candidate.node] = 1.0;
  }
  flow->tolerance += Weight(record) * StepSolver::Tolerance(problem, model.scene().solver.step_tolerance, point) *
                     point.scale * point.velocities.norm();
}

// What inertia takes at each node [N], J: m/2 b . b, and over a first stage m (kappa c . u - c . c/2).
Eigen::VectorXd NodeInertiaLoss(const Eigen::VectorXd& b, const Eigen::VectorXd& c, const Eigen::VectorXd& u,
                                const Material& material, const ClothModel& model) {
  Eigen::VectorXd loss = Eigen::VectorXd::Zero(model.num_nodes());
  for (const int node : model.free_nodes()) {
    const double mass = material.density * model.node_areas()[node];
    const Eigen::Vector3d reach = c.segment<3>(3 * node), impact = u.segment<3>(3 * node);
    loss[node] =
        mass * (0.5 * b.segment<3>(3 * node).squaredNorm() + reach.dot(kSecondStageReach * impact - 0.5 * reach));
  }
  return loss;
}

}  // namespace

EnergyFlow& EnergyFlow::operator+=(const EnergyFlow& other) {
  for (double EnergyFlow::*const term :
       {&EnergyFlow::change, &EnergyFlow::force_work, &EnergyFlow::air_work, &EnergyFlow::handle_work,
        &EnergyFlow::contact_work, &EnergyFlow::push_work, &EnergyFlow::contact_gain, &EnergyFlow::inertia_loss,
        &EnergyFlow::damping_loss, &EnergyFlow::elastic_loss, &EnergyFlow::tolerance}) {
    this->*term += other.*term;
  }
  return *this;
}

EnergyParts StateEnergy(const Parameters& parameters, const Eigen::VectorXd& positions,
                        const Eigen::VectorXd& velocities, const Simulator& simulator) {
  const ClothModel& model = simulator.model();
  EnergyParts parts;
  ElasticForce(parameters.material, positions, model, &parts);
  for (const int node : model.free_nodes()) {
    const double mass = parameters.material.density * model.node_areas()[node];
    parts.kinetic += 0.5 * mass * velocities.segment<3>(3 * node).squaredNorm();
    parts.gravitational -= mass * model.scene().gravity.dot(positions.segment<3>(3 * node));
  }
  return parts;
}

EnergyFlow StepEnergyFlow(const Rollout& rollout, int last, RecordReader* reader, Simulator* simulator) {
  const ClothModel& model = simulator->model();
  const Parameters& parameters = rollout.parameters;
  const StepRecord& end = reader->record(last);
  const int first = end.stage == Stage::kSecond ? last - 1 : last;
  const Eigen::VectorXd b = end.velocities - reader->start(last).velocities;
  Eigen::VectorXd c = Eigen::VectorXd::Zero(b.size()), u = c;
  if (first < last) {
    const Eigen::VectorXd second_velocities = reader->start(last).velocities;
    const Eigen::VectorXd& start_velocities = reader->start(first).velocities;
    c = (second_velocities - start_velocities) / kSecondStageReach;
    u = reader->record(first).velocities - start_velocities - c;
  }
  EnergyFlow flow;
  NodeWork nodes{Eigen::ArrayXd::Zero(model.num_nodes()), Eigen::ArrayXd::Zero(model.num_nodes())};
  for (int i = first; i <= last; ++i) {
    const StepRecord& record = reader->record(i);
    const SolveStart start = reader->start(i);
    AddAir(record, parameters.material, model, &flow);
    AddInternalForces(record, start, parameters, *simulator, &flow);
    AddContacts(record, start, i < last ? u : Eigen::VectorXd::Zero(u.size()), parameters, simulator, &flow, &nodes);
  }
  const Eigen::VectorXd node_loss = NodeInertiaLoss(b, c, u, parameters.material, model);
  flow.inertia_loss = node_loss.sum();
  flow.contact_gain = (nodes.in_contact * (nodes.work - node_loss.array())).max(0.0).sum();
  const SolveStart start = reader->start(first);
  const EnergyParts before = StateEnergy(parameters, start.positions, start.velocities, *simulator);
  const EnergyParts after = StateEnergy(parameters, end.positions, end.velocities, *simulator);
  flow.change = after.total() - before.total();
  flow.elastic_loss += before.elastic() - after.elastic();
  flow.tolerance += EnergyRounding(before, parameters.material, start.positions, model);
  return flow;
}

EnergyBalance BalanceEnergy(const Rollout& rollout, Simulator* simulator) {
  EnergyBalance balance;
  const EnergyParts start =
      StateEnergy(rollout.parameters, rollout.initial_positions, rollout.initial_velocities, *simulator);
  balance.start_energy = start.total();
  balance.largest_energy = start.kinetic + start.elastic();
  balance.excess_time = rollout.start_time;
  RecordReader reader(rollout, simulator);
  for (std::size_t i = 0; i < rollout.records.size(); ++i) {
    const StepRecord& record = rollout.records[i];
    if (!record.ends_step()) continue;
    const EnergyFlow flow = StepEnergyFlow(rollout, static_cast<int>(i), &reader, simulator);
    balance.total += flow;
    balance.gain += std::max(0.0, flow.excess());
    balance.contact_gain = std::max(balance.contact_gain, flow.contact_gain);
    balance.unexplained_steps += !(std::abs(flow.unexplained()) <= flow.tolerance);
    if (balance.total.excess() > balance.excess) {
      balance.excess = balance.total.excess();
      balance.excess_time = record.time;
    }
    const EnergyParts end = StateEnergy(rollout.parameters, record.positions, record.velocities, *simulator);
    balance.largest_energy = std::max(balance.largest_energy,
                                      end.kinetic + end.elastic() + std::abs(end.gravitational - start.gravitational));
  }
  return balance;
}

}  // namespace clothid
