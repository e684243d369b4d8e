#include "sim/derivative/step_derivative.h"

#include <stdexcept>
#include <utility>

#include "sim/matrix/block_product.h"
#include "sim/rollout/simulator.h"
#include "sim/step/second_start.h"
#include "sim/step/step_solver.h"

namespace clothid {

StepDerivative::StepDerivative(const StepRecord& record, const SolveStart& start, const Parameters& parameters,
                               Simulator* simulator, const SizeDerivative* sizes)
    : record_(record),
      start_(start),
      parameters_(parameters),
      model_(simulator->model()),
      forces_(model_.forces()),
      sizes_(sizes),
      hessian_(simulator->step_solver().hessian()),
      jacobian_(simulator->step_solver().jacobian()) {
  const ScopedTimer timer(&jacobian_.seconds().assembly);
  SetForceStart(forces_, start, record.time_step, model_.scene().handles.nodes, record.positions, &held_.start);
  forces_.Hold(parameters, record.time, &held_);
  AssembleStepHessian(model_, HessianKind::kExact, point(), held_, &hessian_);
  const Material& material = parameters.material;
  const NodeForces& nodes = model_.nodes();
  masses_.resize(3 * model_.num_free());
  for (int i = 0; i < model_.num_free(); ++i) {
    masses_.segment<3>(3 * i).setConstant(model_.mass(material, model_.free_nodes()[i]));
  }
  damped_masses_ = masses_ * (nodes.ArealSlope(material, record.time_step) / material.areal_inertia());
  for (int i = 0; nodes.has_density_field() && i < model_.num_free(); ++i) {
    const double drag = nodes.drag(material, model_.free_nodes()[i]);
    damped_masses_.segment<3>(3 * i) = masses_.segment<3>(3 * i).array() + record.time_step * drag;
  }
  if (!record.contacts.empty()) motions_ = ObstacleMotions(model_.scene(), parameters, record.times());
  contacts_ = RestoreContacts(record, start.positions, motions_, parameters, model_);
  impulses_ = DifferentiateImpulses(contacts_, start.positions, record.velocities);
  if (motions_.empty()) return;
  for (const Contact& contact : contacts_.nodes) {
    const Eigen::Vector3d place = start.positions.segment<3>(3 * contact.candidate.node);
    contact_motions_.push_back(motions_[contact.candidate.obstacle].Near(place));
  }
}

const AffineMotion* StepDerivative::motion_of(const Contact& contact) const {
  if (motions_.empty() || !motions_[contact.candidate.obstacle].moves()) return nullptr;
  return &contact_motions_[static_cast<std::size_t>(&contact - contacts_.nodes.data())];
}

bool StepDerivative::Factor(StepJacobian::Method method) { return jacobian_.Factor(method, hessian_, contacts_); }

bool StepDerivative::FactorOtherwise() {
  if (num_impulses() == 0) return Factor(StepJacobian::Method::kLu);
  BlockMatrix positive(model_.pattern());
  AssembleStepHessian(model_, HessianKind::kClamped, point(), held_, &positive);
  jacobian_.SetPoint(hessian_, contacts_);
  return jacobian_.FactorInstead(positive);
}

bool StepDerivative::UseFactor(std::shared_ptr<const ReducedFactor> factor) {
  if (factor == nullptr) return false;
  jacobian_.SetPoint(hessian_, contacts_);
  jacobian_.SetFactor(std::move(factor));
  return true;
}

Eigen::MatrixXd StepDerivative::TimesMass(const Eigen::MatrixXd& columns) const {
  return masses_.asDiagonal() * columns;
}

Eigen::MatrixXd StepDerivative::TimesUnknowns(const StepColumns& columns) const {
  Eigen::MatrixXd product = MultiplySymmetric(hessian_, columns.velocities, jacobian_.team());
  if (!impulses_.is_empty()) product -= model_.GatherColumns(impulses_.spread * columns.impulses);
  return product;
}

StepColumns StepDerivative::TimesUnknownsTransposed(const Eigen::MatrixXd& columns) const {
  StepColumns product{MultiplySymmetric(hessian_, columns, jacobian_.team()),
                      Eigen::MatrixXd(num_impulses(), columns.cols())};
  if (!impulses_.is_empty()) product.impulses = -(impulses_.spread.transpose() * model_.ScatterColumns(columns));
  return product;
}

Eigen::MatrixXd StepDerivative::TimesHessian(const Eigen::MatrixXd& columns) const {
  Eigen::MatrixXd product = MultiplySymmetric(hessian_, columns, jacobian_.team());
  product -= damped_masses_.asDiagonal() * columns;
  if (forces_.needs_velocities()) {
    Eigen::MatrixXd drag = Eigen::MatrixXd::Zero(3 * model_.num_nodes(), columns.cols());
    forces_.AddVelocityProduct(record_.time_step, point(), held_, model_.ScatterColumns(columns), &drag);
    product -= model_.GatherColumns(drag);
  }
  return product / record_.time_step;
}

Eigen::MatrixXd StepDerivative::TimesStart(const Eigen::MatrixXd& columns) const {
  Eigen::MatrixXd product = TimesHessian(columns);
  if (forces_.needs_origins() && !has_origins()) product += TimesMixed(start_.positions, columns);
  if (!impulses_.is_empty()) product += model_.GatherColumns(impulses_.weights * model_.ScatterColumns(columns));
  return product;
}

Eigen::MatrixXd StepDerivative::TimesStartTransposed(const Eigen::MatrixXd& columns) const {
  Eigen::MatrixXd product = TimesHessian(columns);
  if (forces_.needs_origins() && !has_origins()) product += TimesMixedTransposed(start_.positions, columns);
  if (!impulses_.is_empty())
    product += model_.GatherColumns(impulses_.weights.transpose() * model_.ScatterColumns(columns));
  return product;
}

Eigen::MatrixXd StepDerivative::TimesOrigins(const Eigen::MatrixXd& step, const Eigen::MatrixXd& first) const {
  return (1.0 - kSecondStageReach) * TimesMixed(*start_.step_positions, step) +
         kSecondStageReach * TimesMixed(*start_.first_positions, first);
}

void StepDerivative::SubtractOriginsTransposed(const Eigen::MatrixXd& columns, Eigen::MatrixXd* step,
                                               Eigen::MatrixXd* first) const {
  *step -= (1.0 - kSecondStageReach) * TimesMixedTransposed(*start_.step_positions, columns);
  *first -= kSecondStageReach * TimesMixedTransposed(*start_.first_positions, columns);
}

Eigen::MatrixXd StepDerivative::TimesMixed(const Eigen::VectorXd& origin, const Eigen::MatrixXd& columns) const {
  Eigen::MatrixXd product = Eigen::MatrixXd::Zero(3 * model_.num_nodes(), columns.cols());
  forces_.AddOriginProduct(record_.time_step, point(), origin, model_.ScatterColumns(columns), &product);
  return model_.GatherColumns(product);
}

Eigen::MatrixXd StepDerivative::TimesMixedTransposed(const Eigen::VectorXd& origin,
                                                     const Eigen::MatrixXd& columns) const {
  Eigen::MatrixXd product = Eigen::MatrixXd::Zero(3 * model_.num_nodes(), columns.cols());
  forces_.AddOriginProductTransposed(record_.time_step, point(), origin, model_.ScatterColumns(columns), &product);
  return model_.GatherColumns(product);
}

Eigen::MatrixXd StepDerivative::TimesPrediction(const Eigen::MatrixXd& columns) const {
  Eigen::MatrixXd product = Eigen::MatrixXd::Zero(3 * model_.num_nodes(), columns.cols());
  forces_.AddPredictionProduct(-record_.time_step, point(), held_, model_.ScatterColumns(columns), &product);
  return model_.GatherColumns(product);
}

Eigen::MatrixXd StepDerivative::TimesPredictionTransposed(const Eigen::MatrixXd& columns) const {
  Eigen::MatrixXd product = Eigen::MatrixXd::Zero(3 * model_.num_nodes(), columns.cols());
  forces_.AddPredictionProductTransposed(-record_.time_step, point(), held_, model_.ScatterColumns(columns), &product);
  return model_.GatherColumns(product);
}

StepColumns StepDerivative::TimesFrames(const Eigen::MatrixXd& columns) const {
  StepColumns product{Eigen::MatrixXd::Zero(columns.rows(), columns.cols()),
                      Eigen::MatrixXd(num_impulses(), columns.cols())};
  if (!impulses_.is_empty()) product.impulses = impulses_.geometry * model_.ScatterColumns(columns);
  for (const Contact& contact : contacts_.nodes) {
    const int row = 3 * model_.free_index()[contact.candidate.node];
    product.velocities.middleRows<3>(row) =
        ContactPositionJacobian(contact, motion_of(contact)) * columns.middleRows<3>(row);
  }
  return product;
}

Eigen::MatrixXd StepDerivative::TimesFramesTransposed(const StepColumns& columns) const {
  Eigen::MatrixXd product = Eigen::MatrixXd::Zero(columns.velocities.rows(), columns.velocities.cols());
  for (const Contact& contact : contacts_.nodes) {
    const int row = 3 * model_.free_index()[contact.candidate.node];
    product.middleRows<3>(row) =
        ContactPositionJacobian(contact, motion_of(contact)).transpose() * columns.velocities.middleRows<3>(row);
  }
  if (!impulses_.is_empty()) product += model_.GatherColumns(impulses_.geometry.transpose() * columns.impulses);
  return product;
}

Eigen::MatrixXd StepDerivative::TimesHandleForces(const Eigen::MatrixXd& impulses, const Eigen::MatrixXd& start) const {
  if (impulses_.is_empty()) {
    const auto num_handles = static_cast<Eigen::Index>(model_.scene().handles.nodes.size());
    return Eigen::MatrixXd::Zero(3 * num_handles, start.cols());
  }
  const Eigen::MatrixXd change = impulses_.spread * impulses - impulses_.weights * model_.ScatterColumns(start);
  return model_.GatherHandles(change) / record_.time_step;
}

void StepDerivative::AddHandleForcesTransposed(const Eigen::MatrixXd& forces, Eigen::MatrixXd* impulses,
                                               Eigen::MatrixXd* start) const {
  if (impulses_.is_empty()) return;
  const Eigen::MatrixXd all = model_.ScatterHandles(forces / record_.time_step);
  *impulses += impulses_.spread.transpose() * all;
  *start -= model_.GatherColumns(impulses_.weights.transpose() * all);
}

ForcePoint StepDerivative::point() const {
  return {parameters_, record_.time_step, record_.time, record_.positions, record_.velocities, jacobian_.team()};
}

Eigen::VectorXd StepDerivative::MomentumDerivative(ParameterId id) const {
  if (IsOfContact(id.kind)) return Eigen::VectorXd::Zero(3 * model_.num_free());
  if (IsSize(id.kind)) {
    if (sizes_ == nullptr) throw std::logic_error("the derivative by a size that was not asked for");
    return model_.Gather(sizes_->MomentumDerivative(id, record_, start_));
  }
  Eigen::VectorXd derivative = Eigen::VectorXd::Zero(record_.positions.size());
  if (model_.nodes().DependOn(id)) {
    for (const int node : model_.free_nodes()) {
      const NodeMotion motion = MotionOf(node, record_.time_step, record_.time, start_.velocities, record_.velocities);
      derivative.segment<3>(3 * node) = model_.nodes().ImpulseDerivative(id, motion, parameters_);
    }
  }
  forces_.AddDerivative(id, -record_.time_step, point(), held_, &derivative);
  return model_.Gather(derivative);
}

const Eigen::VectorXd* StepDerivative::MassSlopes(ParameterId id) const {
  return IsSize(id.kind) ? &sizes_->MassSlopes(id) : model_.nodes().MassSlopes(id);
}

std::vector<MotionChange> StepDerivative::MotionChanges(ParameterId id) const {
  std::vector<MotionChange> changes(contacts_.nodes.size());
  if (contacts_.nodes.empty()) return changes;
  const ObstacleChange change(model_.scene().obstacles[id.part], motions_[id.part], parameters_.placement(id.part),
                              PlacementPartOf(id), record_.times());
  for (std::size_t i = 0; i < contacts_.nodes.size(); ++i) {
    const ContactCandidate& candidate = contacts_.nodes[i].candidate;
    if (candidate.obstacle != id.part) continue;
    changes[i] =
        change.At(start_.positions.segment<3>(3 * candidate.node), candidate.normal, candidate.normal_gradient);
  }
  return changes;
}

StepColumns StepDerivative::ImpulseDerivative(ParameterId id) const {
  StepColumns columns{Eigen::VectorXd::Zero(3 * model_.num_free()), Eigen::VectorXd::Zero(num_impulses())};
  if (id.kind == ParameterKind::kSelfFriction) columns.impulses = -impulses_.friction;
  auto derivative = columns.velocities.col(0);
  if (IsPlacement(id.kind)) {
    const std::vector<MotionChange> changes = MotionChanges(id);
    for (std::size_t i = 0; i < contacts_.nodes.size(); ++i) {
      const ContactCandidate& candidate = contacts_.nodes[i].candidate;
      if (candidate.obstacle != id.part) continue;
      derivative.segment<3>(3 * model_.free_index()[candidate.node]) =
          ContactMotionDerivative(contacts_.nodes[i], changes[i]);
    }
  }
  if (id.kind != ParameterKind::kFriction) return columns;
  for (const Contact& contact : contacts_.nodes) {
    if (contact.response.branch != ContactBranch::kSlip) continue;
    if (id.part != kWhole && id.part != contact.candidate.obstacle) continue;
    derivative.segment<3>(3 * model_.free_index()[contact.candidate.node]) =
        contact.response.normal_force * contact.response.slip_direction;
  }
  return columns;
}

}  // namespace clothid
