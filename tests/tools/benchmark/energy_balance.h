// Where the energy of a rollout comes from and where it goes.
//
// Energy E_n = kinetic and gravitational energy of the free nodes + stretch and bending energy of the whole cloth. A
// step has one solve (backward Euler) or two (SDIRK2, sim/step/stage.h). Solve s, of size h_s, ends with the velocities
// v_s, and counts with the weight w_s = h_s, but kappa h_s in a first stage, so that x_{n+1} - x_n = sum of w_s v_s.
// Its impulses J^T r_s count likewise as R_s = r_s, but kappa (r_s - M u) in a first stage: that part of them which is
// carried on (sim/step/second_start.h). With U stretch and bending, f = -dU/dx and f_d internal damping at the end of
// the solve, e its residual, sums over the solves of the step, it is exactly
//   E_{n+1} - E_n = W_force + W_air + W_handles + W_contact + W_seams - D_inertia - D_damping - D_elastic + sum e . v_s
//   W_force   = sum over free nodes of w_s node_force . v_s
//   W_air     = sum over free nodes of w_s c_d a (w - v_s) . v_s
//   W_handles = -w_s (f + f_d) . v_s over the handles: what holds a handle acts against the cloth
//   W_seams   = what draws seams (sim/rollout/energy_loss.h)
//   W_contact = sum over contacts of R_s . v_s: not positive but for W_push, that part of normal impulses which does
//               positive work, where a node starts inside an obstacle
//   D_inertia, D_damping, D_elastic: what the integrator takes (sim/rollout/energy_loss.h)
// So a step can gain energy that no work pays for, by D_elastic < -(D_inertia + D_damping): a property of its
// integrator, not an error. It is summed as the excess. Whatever is left over is e . v_s, for which |e| <= tolerance *
// scale bounds it: more would be an error of a force, of an energy or of the solver.
//
// **What contacts gain.** At a node with impulses, R_s . v_s without W_push, less its part of D_inertia, is what
// contact brings it beyond the work of all other forces. An impact that threw a node back would be a gain.
#ifndef CLOTHID_TESTS_TOOLS_BENCHMARK_ENERGY_BALANCE_H_
#define CLOTHID_TESTS_TOOLS_BENCHMARK_ENERGY_BALANCE_H_

#include <algorithm>
#include <cmath>
#include <limits>

#include "sim/cloth/cloth_model.h"
#include "sim/rollout/energy_loss.h"
#include "sim/rollout/record_reader.h"
#include "sim/rollout/rollout.h"
#include "sim/rollout/simulator.h"
#include "sim/step/second_start.h"
#include "sim/step/step_problem.h"
#include "sim/step/step_solver.h"

namespace clothid {

// The balance of one step, or of several: they add up. J.
struct EnergyFlow {
  double change = 0.0;  // E_1 - E_0
  double force_work = 0.0, air_work = 0.0, handle_work = 0.0, contact_work = 0.0, seam_work = 0.0;
  double push_work = 0.0;     // part of contact_work
  double contact_gain = 0.0;  // what contacts gain, over the nodes where it is positive
  EnergyLoss loss;
  double tolerance = 0.0;  // of unexplained(): that of the solver, |v_1| times the residual, and of rounding

  double work() const { return force_work + air_work + handle_work + contact_work + seam_work; }
  // E_1 - E_0 beyond the work: positive where energy was gained without a source.
  double excess() const { return change - work(); }
  // e . v_1 and rounding.
  double unexplained() const { return excess() + loss.total(); }

  EnergyFlow& operator+=(const EnergyFlow& other);
};

// Of a rollout that keeps all its records, as far as it came. J.
struct EnergyBalance {
  EnergyFlow total;
  double start_energy = 0.0;  // E_0
  double largest_energy =
      0.0;                    // of kinetic + elastic energy + what gravitational energy has changed by since the start
  double excess = 0.0;        // the largest of E_n - E_0 - work up to n, at least 0
  double excess_time = 0.0;   // s, of that n; the start where there is none
  double gain = 0.0;          // the sum of the excesses of the steps that have one
  double contact_gain = 0.0;  // the largest of a step
  int unexplained_steps = 0;  // steps and substeps with |unexplained()| > tolerance
};

inline constexpr double kRoundings = 4.0;  // that a sum over the neighbours of a node takes, in units of eps

// What rounding makes of the energies of a state and of the work of its forces. The stretch energy k/2 a |F - R|^2 is
// computed from differences of positions, the bending energy from the positions themselves.
inline double EnergyRounding(const EnergyParts& parts, const Material& material, const Eigen::VectorXd& positions,
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

inline void AddAir(const StepRecord& record, const Parameters& parameters, const ClothModel& model, EnergyFlow* flow) {
  const Material& material = parameters.material;
  const double seconds = SolveWeight(record) * record.time_step;
  for (const int node : model.free_nodes()) {
    const Eigen::Vector3d v = record.velocities.segment<3>(3 * node);
    flow->force_work += seconds * model.scene().node_force.dot(v);
    if (model.nodes().drag() == nullptr) continue;
    flow->air_work += seconds * material.drag * model.node_areas()[node] *
                      (model.nodes().drag()->WindAt(node, record.time, parameters.wind) - v).dot(v);
  }
}

// What holds a handle acts against the forces in the cloth.
inline void AddHandles(const StepRecord& record, const SolveStart& start, const Parameters& parameters,
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
inline void AddContacts(const StepRecord& record, const SolveStart& start, const Eigen::VectorXd& impacts,
                        const Parameters& parameters, Simulator* simulator, EnergyFlow* flow, NodeWork* nodes) {
  const ClothModel& model = simulator->model();
  const StepProblem problem(model, parameters, start, record.times(), &simulator->step_workspace());
  StepPoint point;
  problem.Evaluate(model.Gather(record.velocities), &point);
  for (std::size_t i = 0; i < point.responses.size(); ++i) {
    if (point.responses[i].branch == ContactBranch::kTakeOff) continue;
    const ContactCandidate& candidate = problem.contacts().candidates()[i];
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

inline EnergyFlow& EnergyFlow::operator+=(const EnergyFlow& other) {
  for (double EnergyFlow::*const term : {&EnergyFlow::change, &EnergyFlow::force_work, &EnergyFlow::air_work,
                                         &EnergyFlow::handle_work, &EnergyFlow::contact_work, &EnergyFlow::seam_work,
                                         &EnergyFlow::push_work, &EnergyFlow::contact_gain, &EnergyFlow::tolerance}) {
    this->*term += other.*term;
  }
  for (double EnergyLoss::*const term : {&EnergyLoss::inertia, &EnergyLoss::damping, &EnergyLoss::elastic}) {
    loss.*term += other.loss.*term;
  }
  return *this;
}

// Of the step or substep that ends in record `last` of `rollout`, which `reader` reads.
inline EnergyFlow StepEnergyFlow(const Rollout& rollout, int last, RecordReader* reader, Simulator* simulator) {
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
    flow.tolerance +=
        EnergyRounding(StateEnergy(parameters, record.positions, record.velocities, *simulator, record.time),
                       parameters.material, record.positions, model);
  }
  flow.loss = StepEnergyLoss(rollout, last, reader, *simulator);
  const Eigen::VectorXd node_loss = NodeInertiaLoss(parameters, changes, *simulator);
  flow.contact_gain = (nodes.in_contact * (nodes.work - node_loss.array())).max(0.0).sum();
  const SolveStart start = reader->start(first);
  flow.seam_work = SeamWork(rollout, last, reader, *simulator);
  const double start_time = reader->record(first).time - reader->record(first).time_step;
  const EnergyParts before = StateEnergy(parameters, start.positions, start.velocities, *simulator, start_time);
  flow.change = StateEnergy(parameters, end.positions, end.velocities, *simulator, end.time).total() - before.total();
  flow.tolerance += EnergyRounding(before, parameters.material, start.positions, model);
  return flow;
}

inline EnergyBalance BalanceEnergy(const Rollout& rollout, Simulator* simulator) {
  EnergyBalance balance;
  const EnergyParts start = StateEnergy(rollout.parameters, rollout.initial_positions, rollout.initial_velocities,
                                        *simulator, rollout.start_time);
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
    const EnergyParts end =
        StateEnergy(rollout.parameters, record.positions, record.velocities, *simulator, record.time);
    balance.largest_energy = std::max(balance.largest_energy,
                                      end.kinetic + end.elastic() + std::abs(end.gravitational - start.gravitational));
  }
  return balance;
}

}  // namespace clothid

#endif  // CLOTHID_TESTS_TOOLS_BENCHMARK_ENERGY_BALANCE_H_
