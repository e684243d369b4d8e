#include "tools/benchmark/steps/energy_balance.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "sim/cloth/cloth_model.h"
#include "sim/rollout/simulator.h"
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

Eigen::VectorXd DampingForce(const Material& material, double time_step, const Eigen::VectorXd& start_positions,
                             const Eigen::VectorXd& positions, const ClothModel& model) {
  Eigen::VectorXd force = Eigen::VectorXd::Zero(positions.size());
  if (model.damping() == nullptr) return force;
  std::vector<MetricBatch> start_metrics;
  model.damping()->SetMetrics(start_positions, &start_metrics);
  model.damping()->AddForce(material.damping, time_step, start_metrics, positions, &force);
  return force;
}

// Works of node force and air and the loss of inertia: sums over the free nodes.
void AddFreeNodes(const StepRecord& record, const Eigen::VectorXd& start_velocities, const Material& material,
                  const ClothModel& model, EnergyFlow* flow) {
  const double h = record.time_step;
  for (const int node : model.free_nodes()) {
    const double area = model.node_areas()[node];
    const Eigen::Vector3d v = record.velocities.segment<3>(3 * node);
    flow->force_work += h * model.scene().node_force.dot(v);
    flow->inertia_loss += 0.5 * material.density * area * (v - start_velocities.segment<3>(3 * node)).squaredNorm();
    if (model.drag() == nullptr) continue;
    flow->air_work += h * material.drag * area * (model.drag()->WindAt(node, record.time) - v).dot(v);
  }
}

void AddContacts(const StepProblem& problem, const StepPoint& point, EnergyFlow* flow) {
  for (std::size_t i = 0; i < point.responses.size(); ++i) {
    const ContactResponse& response = point.responses[i];
    if (response.branch == ContactBranch::kTakeOff) continue;
    const Eigen::Vector3d v = point.velocities.segment<3>(3 * problem.free_block(static_cast<int>(i)));
    flow->contact_work += response.impulse.dot(v);
    flow->push_work += std::max(0.0, -response.normal_force * problem.candidates()[i].normal.dot(v));
  }
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

}  // namespace

EnergyFlow& EnergyFlow::operator+=(const EnergyFlow& other) {
  for (double EnergyFlow::*const term :
       {&EnergyFlow::change, &EnergyFlow::force_work, &EnergyFlow::air_work, &EnergyFlow::handle_work,
        &EnergyFlow::contact_work, &EnergyFlow::push_work, &EnergyFlow::inertia_loss, &EnergyFlow::damping_loss,
        &EnergyFlow::elastic_loss, &EnergyFlow::tolerance}) {
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

EnergyFlow StepEnergyFlow(const StepRecord& record, const Eigen::VectorXd& start_positions,
                          const Eigen::VectorXd& start_velocities, const Parameters& parameters, Simulator* simulator) {
  const ClothModel& model = simulator->model();
  const Material& material = parameters.material;
  const EnergyParts start = StateEnergy(parameters, start_positions, start_velocities, *simulator);
  EnergyParts end = StateEnergy(parameters, record.positions, record.velocities, *simulator);
  const Eigen::VectorXd elastic = ElasticForce(material, record.positions, model, &end);
  const Eigen::VectorXd viscous = DampingForce(material, record.time_step, start_positions, record.positions, model);
  const Eigen::VectorXd displacement = record.positions - start_positions;
  EnergyFlow flow;
  flow.change = end.total() - start.total();
  AddFreeNodes(record, start_velocities, material, model, &flow);
  for (const int node : model.scene().handles.nodes) {
    flow.handle_work -= (elastic + viscous).segment<3>(3 * node).dot(displacement.segment<3>(3 * node));
  }
  flow.damping_loss = -viscous.dot(displacement);
  flow.elastic_loss = start.elastic() - end.elastic() - elastic.dot(displacement);
  const StepProblem problem(model, parameters, {start_positions, start_velocities}, record.times(),
                            &simulator->step_workspace());
  StepPoint point;
  problem.Evaluate(model.Gather(record.velocities), &point);
  AddContacts(problem, point, &flow);
  flow.tolerance = StepSolver::Tolerance(problem, model.scene().solver.step_tolerance, point) * point.scale *
                       point.velocities.norm() +
                   EnergyRounding(start, material, start_positions, model) +
                   EnergyRounding(end, material, record.positions, model);
  return flow;
}

EnergyBalance BalanceEnergy(const Rollout& rollout, Simulator* simulator) {
  EnergyBalance balance;
  const EnergyParts start =
      StateEnergy(rollout.parameters, rollout.initial_positions, rollout.initial_velocities, *simulator);
  balance.start_energy = start.total();
  balance.largest_energy = start.kinetic + start.elastic();
  balance.excess_time = rollout.start_time;
  for (std::size_t i = 0; i < rollout.records.size(); ++i) {
    const StepRecord& record = rollout.records[i];
    if (record.stage != Stage::kOnly) throw std::logic_error("a balance of energy is that of backward Euler");
    const Eigen::VectorXd& x = i == 0 ? rollout.initial_positions : rollout.records[i - 1].positions;
    const Eigen::VectorXd& v = i == 0 ? rollout.initial_velocities : rollout.records[i - 1].velocities;
    const EnergyFlow flow = StepEnergyFlow(record, x, v, rollout.parameters, simulator);
    balance.total += flow;
    balance.gain += std::max(0.0, flow.excess());
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
