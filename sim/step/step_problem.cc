#include "sim/step/step_problem.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "sim/cloth/system_matrix.h"
#include "sim/step/second_start.h"

namespace clothid {

void AssembleStepHessian(const ClothModel& model, HessianKind kind, const ForcePoint& point, const HeldForces& held,
                         BlockMatrix* hessian) {
  const double h = point.time_step;
  const Material& material = point.parameters.material;
  model.forces().SetHessian(kind, point, held, h * h, h, hessian);
  const NodeForces& nodes = model.nodes();
  const double areal_mass = nodes.ArealSlope(material, h);
  const BlockPattern& pattern = hessian->pattern();
  for (int i = 0; i < model.num_free(); ++i) {
    hessian->block(pattern.Diagonal(i)).diagonal().array() += areal_mass * nodes.areas()[model.free_nodes()[i]];
  }
  for (int i = 0; nodes.has_density_field() && i < model.num_free(); ++i) {
    hessian->block(pattern.Diagonal(i)).diagonal().array() += nodes.FurtherSlope(material, h, model.free_nodes()[i]);
  }
}

StepProblem::StepProblem(const ClothModel& model, const Parameters& parameters, const SolveStart& start,
                         const SolveTimes& times, StepWorkspace* workspace, const HandlePath* handle_offsets)
    : model_(model),
      parameters_(parameters),
      work_(*workspace),
      time_step_(times.time_step),
      end_time_(times.end_time),
      stage_(times.stage) {
  const bool changed = work_.time_step != time_step_ || !(work_.material == parameters.material);
  if (changed) SetConstants();
  if (changed || model.nodes().drag() != nullptr) SetExternalImpulse();  // the wind changes with time
  SetHandles(handle_offsets);
  work_.start_positions = start.positions;
  work_.start_velocities.resize(3 * model.num_free());
  double square = 0.0;
  for (int i = 0; i < model.num_free(); ++i) {
    const Eigen::Vector3d velocity = start.velocities.segment<3>(3 * model.free_nodes()[i]);
    work_.start_velocities.segment<3>(3 * i) = velocity;
    square += (work_.masses[i] * velocity).squaredNorm();
  }
  work_.start_momentum = std::sqrt(square);
  HoldForces(start);
  if (model.has_contact() || model.scene().self_contact) FindContactsToBe(start, times);
}

StepProblem StepProblem::WithFriction(double share) const {
  StepProblem other = *this;
  other.eased_friction_ = parameters_.friction_coefficients;
  for (double& coefficient : other.eased_friction_) coefficient *= share;
  other.eased_self_friction_ = share * parameters_.self_friction;
  other.is_eased_ = true;
  return other;
}

void StepProblem::SetConstants() {
  work_.material = parameters_.material;
  work_.time_step = time_step_;
  work_.masses.resize(model_.num_free());
  for (int i = 0; i < model_.num_free(); ++i) {
    work_.masses[i] = model_.mass(parameters_.material, model_.free_nodes()[i]);
  }
  if (const AirDrag* drag = model_.nodes().drag()) {
    work_.drag = time_step_ * parameters_.material.drag * drag->areas()(model_.free_nodes());
  }
  work_.weights.resize(model_.num_free());
  for (int i = 0; i < model_.num_free(); ++i) {
    work_.weights[i] = SystemDiagonal(model_, parameters_.material, time_step_, model_.free_nodes()[i]);
  }
  work_.weight_norm = work_.weights.norm();
}

void StepProblem::SetExternalImpulse() {
  const Scene& scene = model_.scene();
  const AirDrag* const drag = model_.nodes().drag();
  work_.external_impulse.resize(3 * model_.num_free());
  for (int i = 0; i < model_.num_free(); ++i) {
    const int node = model_.free_nodes()[i];
    auto impulse = work_.external_impulse.segment<3>(3 * i);
    const double heavy_mass = parameters_.material.density * model_.nodes().mass_areas()[node];
    impulse = time_step_ * (heavy_mass * scene.gravity + scene.node_force);
    if (drag != nullptr) impulse += work_.drag[i] * drag->WindAt(node, end_time_, parameters_.wind);
  }
  work_.external_norm = work_.external_impulse.norm();
}

void StepProblem::SetHandles(const HandlePath* offsets) {
  const Handles& handles = model_.scene().handles;
  if (handles.path.num_handles() > 0) work_.handle_positions = handles.path.At(end_time_);
  if (offsets != nullptr) work_.handle_positions += offsets->At(end_time_);
}

// Handles have the velocity of their way over the solve.
void StepProblem::HoldForces(const SolveStart& start) {
  const ForceSet& forces = model_.forces();
  Eigen::VectorXd ends;
  if (forces.needs_velocities() || forces.needs_prediction()) {
    ends = start.positions;
    PlaceHandles(&ends);
    work_.all_velocities = (ends - start.positions) / time_step_;
  }
  SetForceStart(forces, start, time_step_, model_.scene().handles.nodes, ends, &work_.held.start);
  forces.Hold(parameters_, end_time_, &work_.held);
}

void StepProblem::FindContactsToBe(const SolveStart& start, const SolveTimes& times) {
  Eigen::VectorXd handle_velocities;
  if (model_.scene().self_contact) {
    handle_velocities = start.positions;
    PlaceHandles(&handle_velocities);
    handle_velocities = (handle_velocities - start.positions) / time_step_;
  }
  work_.contacts.Find(model_,
                      {work_.start_positions, start.velocities, handle_velocities, work_.weights, times.gap_time()},
                      ObstacleMotions(model_.scene(), parameters_, times));
}

double StepProblem::friction_coefficient(int candidate) const {
  return friction_coefficients()[work_.contacts.candidates()[candidate].obstacle];
}

bool StepProblem::has_friction() const {
  const std::vector<double>& mu = friction_coefficients();
  return std::any_of(mu.begin(), mu.end(), [](double coefficient) { return coefficient > 0.0; }) ||
         (work_.contacts.may_touch_itself() && self_friction() > 0.0);
}

void StepProblem::Evaluate(const Eigen::VectorXd& velocities, StepPoint* point) const {
  MoveTo(velocities, point);
  point->scale = std::max({work_.external_norm, work_.start_momentum, std::numeric_limits<double>::min()});
  AddForces(ForceGroup::kElastic, point);
  if (model_.nodes().drag() != nullptr) AddDrag(point);
  AddForces(ForceGroup::kAir, point);
  AddForces(ForceGroup::kViscous, point);
  work_.contacts.SubtractImpulses(*point, &point->momentum_gradient);
  work_.contacts.ApplyLaw(friction(), point->velocities, point->momentum_gradient, point, &point->residual);
  point->relative_residual = std::hypot(point->residual.norm(), point->pairs.residuals.norm()) / point->scale;
}

// One pass over the nodes for all that has no derivative: x = x_n + h v, M (v - v_n) - h f_ext and its potential.
void StepProblem::MoveTo(const Eigen::VectorXd& velocities, StepPoint* point) const {
  point->velocities = velocities;
  point->positions.resize(work_.start_positions.size());
  point->momentum_gradient.resize(velocities.size());
  Eigen::Array3d kinetic = Eigen::Array3d::Zero(), external = Eigen::Array3d::Zero();
  for (int i = 0; i < model_.num_free(); ++i) {
    const int row = 3 * i, node = 3 * model_.free_nodes()[i];
    const Eigen::Vector3d v = velocities.segment<3>(row), change = v - work_.start_velocities.segment<3>(row);
    const Eigen::Vector3d impulse = work_.external_impulse.segment<3>(row);
    point->positions.segment<3>(node) = work_.start_positions.segment<3>(node) + time_step_ * v;
    point->momentum_gradient.segment<3>(row) = work_.masses[i] * change - impulse;
    kinetic += work_.masses[i] * change.array().square();
    external += impulse.array() * v.array();
  }
  point->potential = 0.5 * kinetic.sum() - external.sum();
  PlaceHandles(&point->positions);
}

void StepProblem::PlaceHandles(Eigen::VectorXd* positions) const {
  const Handles& handles = model_.scene().handles;
  const bool move = handles.path.num_handles() > 0;
  for (size_t i = 0; i < handles.nodes.size(); ++i) {
    const int node = 3 * handles.nodes[i], row = 3 * static_cast<int>(i);
    positions->segment<3>(node) =
        move ? work_.handle_positions.segment<3>(row) : work_.start_positions.segment<3>(node);
  }
}

void StepProblem::AddDrag(StepPoint* point) const {
  for (int i = 0; i < model_.num_free(); ++i) {
    const Eigen::Vector3d v = point->velocities.segment<3>(3 * i);
    point->momentum_gradient.segment<3>(3 * i) += work_.drag[i] * v;
    point->potential += 0.5 * work_.drag[i] * v.squaredNorm();
  }
}

ForcePoint StepProblem::ForcesAt(const StepPoint& point) const {
  if (model_.forces().needs_velocities()) model_.Scatter(point.velocities, &work_.all_velocities);
  return {parameters_, time_step_, end_time_, point.positions, work_.all_velocities};
}

void StepProblem::AddForces(ForceGroup group, StepPoint* point) const {
  if (!model_.forces().has(group)) return;
  work_.force.setZero(3 * model_.num_nodes());
  point->potential += model_.forces().AddForce(group, ForcesAt(*point), work_.held, &work_.force);
  Eigen::Array3d squares = Eigen::Array3d::Zero();
  for (int i = 0; i < model_.num_free(); ++i) {
    const Eigen::Vector3d impulse = time_step_ * work_.force.segment<3>(3 * model_.free_nodes()[i]);
    point->momentum_gradient.segment<3>(3 * i) -= impulse;
    squares += impulse.array().square();
  }
  point->scale = std::max(point->scale, std::sqrt(squares.sum()));
}

void StepProblem::AssembleHessian(HessianKind kind, const StepPoint& point, BlockMatrix* hessian,
                                  ThreadTeam* team) const {
  ForcePoint forces = ForcesAt(point);
  forces.team = team;
  AssembleStepHessian(model_, kind, forces, work_.held, hessian);
}

double StepProblem::RoundingFloor(const StepPoint& point) const {
  const ForceSet& forces = model_.forces();
  const double growth = forces.stiffens() ? forces.StiffnessGrowth(ForcesAt(point)) : 1.0;
  return growth * 0.6 * std::numeric_limits<double>::epsilon() * std::sqrt(3.0) * work_.weight_norm *
         point.positions.lpNorm<Eigen::Infinity>() / (time_step_ * point.scale);
}

double StepProblem::ResidualSize(const StepPoint& point) const {
  if (!work_.contacts.may_touch_itself()) return point.residual.norm();
  double square = 0.0;
  for (int i = 0; i < model_.num_free(); ++i)
    square += point.residual.segment<3>(3 * i).squaredNorm() / work_.weights[i];
  work_.contacts.AddWeighedSquare(point, &square);
  return std::sqrt(square);
}

ContactSet StepProblem::ContactsAt(const StepPoint& point) const {
  ContactSet contacts;
  FindContacts(point, &contacts);
  return contacts;
}

void StepProblem::FindContacts(const StepPoint& point, ContactSet* contacts) const {
  work_.contacts.ContactsAt(friction(), point, contacts);
}

Eigen::VectorXd StepProblem::AllVelocities(const StepPoint& point) const {
  Eigen::VectorXd all = (point.positions - work_.start_positions) / time_step_;
  model_.Scatter(point.velocities, &all);
  return all;
}

}  // namespace clothid
