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

void AddAir(const StepRecord& record, const Parameters& parameters, const ClothModel& model, EnergyFlow* flow) {
  const Material& material = parameters.material;
  const double seconds = SolveWeight(record) * record.time_step;
  for (const int node : model.free_nodes()) {
    const Eigen::Vector3d v = record.velocities.segment<3>(3 * node);
    flow->force_work += seconds * model.scene().node_force.dot(v);
    if (model.drag() == nullptr) continue;
    flow->air_work += seconds * material.drag * model.node_areas()[node] *
                      (model.drag()->WindAt(node, record.time, parameters.wind) - v).dot(v);
  }
}

// What holds a handle acts against the forces in the cloth.
void AddHandles(const StepRecord& record, const SolveStart& start, const Parameters& parameters,
                const Simulator& simulator, EnergyFlow* flow) {
  const InternalForces forces = ForcesAtEnd(parameters, record, start, simulator);
  const double seconds = SolveWeight(record) * record.time_step;
  for (const int node : simulator.scene().handles.nodes) {
    const Eigen::Vector3d force = (forces.elastic + forces.viscous).segment<3>(3 * node);
    flow->handle_work -= seconds * force.dot(record.velocities.segment<3>(3 * node));
  }
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
    const double mass = model.mass(parameters.material, candidate.node);
    const Eigen::Vector3d v = record.velocities.segment<3>(3 * candidate.node);
    const Eigen::Vector3d impulse =
        SolveWeight(record) * (point.responses[i].impulse - mass * impacts.segment<3>(3 * candidate.node));
    const double work = impulse.dot(v), push = candidate.normal.dot(impulse) * candidate.normal.dot(v);
    flow->contact_work += work;
    flow->push_work += std::max(0.0, push);
    nodes->work[candidate.node] += work - std::max(0.0, push);
    nodes->in_contact[candidate.node] = 1.0;
  }
  flow->tolerance += SolveWeight(record) * StepSolver::Tolerance(problem, model.scene().solver.step_tolerance, point) *
                     point.scale * point.velocities.norm();
}

}  // namespace

EnergyFlow& EnergyFlow::operator+=(const EnergyFlow& other) {
  for (double EnergyFlow::*const term :
       {&EnergyFlow::change, &EnergyFlow::force_work, &EnergyFlow::air_work, &EnergyFlow::handle_work,
        &EnergyFlow::contact_work, &EnergyFlow::push_work, &EnergyFlow::contact_gain, &EnergyFlow::tolerance}) {
    this->*term += other.*term;
  }
  for (double EnergyLoss::*const term : {&EnergyLoss::inertia, &EnergyLoss::damping, &EnergyLoss::elastic}) {
    loss.*term += other.loss.*term;
  }
  return *this;
}

EnergyFlow StepEnergyFlow(const Rollout& rollout, int last, RecordReader* reader, Simulator* simulator) {
  const ClothModel& model = simulator->model();
  const Parameters& parameters = rollout.parameters;
  const StepRecord& end = reader->record(last);
  const int first = end.stage == Stage::kSecond ? last - 1 : last;
  const VelocityChanges changes = ChangesInStep(rollout, last, reader);
  const Eigen::VectorXd no_impacts = Eigen::VectorXd::Zero(changes.impact.size());
  EnergyFlow flow;
  NodeWork nodes{Eigen::ArrayXd::Zero(model.num_nodes()), Eigen::ArrayXd::Zero(model.num_nodes())};
  for (int i = first; i <= last; ++i) {
    const StepRecord& record = reader->record(i);
    const SolveStart start = reader->start(i);
    AddAir(record, parameters, model, &flow);
    AddHandles(record, start, parameters, *simulator, &flow);
    AddContacts(record, start, i < last ? changes.impact : no_impacts, parameters, simulator, &flow, &nodes);
    flow.tolerance += EnergyRounding(StateEnergy(parameters, record.positions, record.velocities, *simulator),
                                     parameters.material, record.positions, model);
  }
  flow.loss = StepEnergyLoss(rollout, last, reader, *simulator);
  const Eigen::VectorXd node_loss = NodeInertiaLoss(parameters, changes, *simulator);
  flow.contact_gain = (nodes.in_contact * (nodes.work - node_loss.array())).max(0.0).sum();
  const SolveStart start = reader->start(first);
  const EnergyParts before = StateEnergy(parameters, start.positions, start.velocities, *simulator);
  flow.change = StateEnergy(parameters, end.positions, end.velocities, *simulator).total() - before.total();
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
