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
      sizes_(sizes),
      hessian_(simulator->step_solver().hessian()),
      jacobian_(simulator->step_solver().jacobian()) {
  const ScopedTimer timer(&jacobian_.seconds().assembly);
  if (model_.damping() != nullptr) SetStartMetrics(model_, start, &held_.start_metrics);
  if (model_.directional_drag() != nullptr) {
    predicted_ = PredictedPositions(start, record.time_step, model_.scene().handles.nodes, record.positions);
    model_.directional_drag()->SetAir(predicted_, parameters.wind, record.time, &held_.air);
  }
  AssembleStepHessian(model_, parameters, record.time_step, HessianKind::kExact, held_, record.positions,
                      record.velocities, &hessian_);
  const Material& material = parameters.material;
  const double areal_drag = model_.drag() ? record.time_step * material.drag : 0.0;
  masses_.resize(3 * model_.num_free());
  for (int i = 0; i < model_.num_free(); ++i) {
    masses_.segment<3>(3 * i).setConstant(model_.mass(material, model_.free_nodes()[i]));
  }
  damped_masses_ = masses_ * ((material.areal_inertia() + areal_drag) / material.areal_inertia());
  for (int i = 0; model_.has_density_field() && i < model_.num_free(); ++i) {
    const int row = 3 * i;
    damped_masses_.segment<3>(row) =
        masses_.segment<3>(row).array() +
        (model_.drag() ? areal_drag * model_.drag()->areas()[model_.free_nodes()[i]] : 0.0);
  }
  if (!record.pairs.empty()) {
    pairs_ = std::make_unique<PairDerivative>(
        model_, RestorePairs(model_, parameters, start.positions, record.velocities, record.times(), record.pairs),
        start.positions, record.velocities, parameters.self_friction);
  }
  if (record.contacts.empty()) return;
  motions_ = ObstacleMotions(model_.scene(), parameters, record.times());
  contacts_ = RestoreContacts(model_, parameters, start.positions, record.times(), motions_, record.contacts);
  if (motions_.empty()) return;
  for (const Contact& contact : contacts_) {
    const Eigen::Vector3d place = start.positions.segment<3>(3 * contact.candidate.node);
    contact_motions_.push_back(motions_[contact.candidate.obstacle].Near(place));
  }
}

const AffineMotion* StepDerivative::motion_of(const Contact& contact) const {
  if (motions_.empty() || !motions_[contact.candidate.obstacle].moves()) return nullptr;
  return &contact_motions_[static_cast<std::size_t>(&contact - contacts_.data())];
}

bool StepDerivative::Factor(StepJacobian::Method method) {
  return jacobian_.Factor(method, hessian_, contacts_, parameters_.friction_coefficients);
}

void StepDerivative::UseFactor(std::shared_ptr<const ReducedFactor> factor) {
  jacobian_.SetPoint(hessian_, contacts_, parameters_.friction_coefficients);
  jacobian_.SetFactor(std::move(factor));
}

void StepDerivative::SetPoint(PairJacobian* jacobian) const {
  std::vector<PairCandidate> candidates;
  for (const PairContact& contact : pairs_->contacts()) candidates.push_back(contact.candidate);
  jacobian->SetCandidates(candidates);
  jacobian->SetPoint(hessian_, contacts_, parameters_.friction_coefficients, pairs_->contacts(),
                     parameters_.self_friction);
}

Eigen::MatrixXd StepDerivative::TimesMass(const Eigen::MatrixXd& columns) const {
  return masses_.asDiagonal() * columns;
}

Eigen::MatrixXd StepDerivative::TimesVelocity(const Eigen::MatrixXd& columns) const {
  return MultiplySymmetric(hessian_, columns);
}

Eigen::MatrixXd StepDerivative::TimesHessian(const Eigen::MatrixXd& columns) const {
  Eigen::MatrixXd product = MultiplySymmetric(hessian_, columns);
  product -= damped_masses_.asDiagonal() * columns;
  if (has_prediction()) {
    Eigen::MatrixXd drag = Eigen::MatrixXd::Zero(3 * model_.num_nodes(), columns.cols());
    model_.directional_drag()->AddVelocityProduct(record_.time_step, DragConstantsOf(parameters_.material),
                                                  record_.velocities, held_.air, model_.ScatterColumns(columns), &drag);
    product -= model_.GatherColumns(drag);
  }
  return product / record_.time_step;
}

Eigen::MatrixXd StepDerivative::TimesStart(const Eigen::MatrixXd& columns) const {
  Eigen::MatrixXd product = TimesHessian(columns);
  if (model_.damping() != nullptr && !has_origins()) {
    product += TimesMixed(record_.positions, start_.positions, columns);
  }
  if (pairs_ != nullptr) product += pairs_->TimesWeights(columns);
  return product;
}

Eigen::MatrixXd StepDerivative::TimesStartTransposed(const Eigen::MatrixXd& columns) const {
  Eigen::MatrixXd product = TimesHessian(columns);
  if (model_.damping() != nullptr && !has_origins()) {
    product += TimesMixed(start_.positions, record_.positions, columns);
  }
  if (pairs_ != nullptr) product += pairs_->TimesWeightsTransposed(columns);
  return product;
}

Eigen::MatrixXd StepDerivative::TimesOrigins(const Eigen::MatrixXd& step, const Eigen::MatrixXd& first) const {
  return (1.0 - kSecondStageReach) * TimesMixed(record_.positions, *start_.step_positions, step) +
         kSecondStageReach * TimesMixed(record_.positions, *start_.first_positions, first);
}

void StepDerivative::SubtractOriginsTransposed(const Eigen::MatrixXd& columns, Eigen::MatrixXd* step,
                                               Eigen::MatrixXd* first) const {
  *step -= (1.0 - kSecondStageReach) * TimesMixed(*start_.step_positions, record_.positions, columns);
  *first -= kSecondStageReach * TimesMixed(*start_.first_positions, record_.positions, columns);
}

Eigen::MatrixXd StepDerivative::TimesMixed(const Eigen::VectorXd& positions, const Eigen::VectorXd& start_positions,
                                           const Eigen::MatrixXd& columns) const {
  const double h = record_.time_step;
  const Eigen::MatrixXd all = model_.ScatterColumns(columns);
  Eigen::MatrixXd product = Eigen::MatrixXd::Zero(all.rows(), all.cols());
  model_.damping()->AddMixedProduct(h * parameters_.material.damping, h, positions, start_positions, all, &product);
  return model_.GatherColumns(product);
}

Eigen::MatrixXd StepDerivative::TimesPrediction(const Eigen::MatrixXd& columns) const {
  Eigen::MatrixXd product = Eigen::MatrixXd::Zero(3 * model_.num_nodes(), columns.cols());
  model_.directional_drag()->AddNormalProduct(-record_.time_step, DragConstantsOf(parameters_.material),
                                              record_.velocities, held_.air, predicted_, model_.ScatterColumns(columns),
                                              &product);
  return model_.GatherColumns(product);
}

Eigen::MatrixXd StepDerivative::TimesPredictionTransposed(const Eigen::MatrixXd& columns) const {
  Eigen::MatrixXd product = Eigen::MatrixXd::Zero(3 * model_.num_nodes(), columns.cols());
  model_.directional_drag()->AddNormalProductTransposed(-record_.time_step, DragConstantsOf(parameters_.material),
                                                        record_.velocities, held_.air, predicted_,
                                                        model_.ScatterColumns(columns), &product);
  return model_.GatherColumns(product);
}

Eigen::MatrixXd StepDerivative::TimesFrames(const Eigen::MatrixXd& columns) const {
  Eigen::MatrixXd product = Eigen::MatrixXd::Zero(columns.rows(), columns.cols());
  for (const Contact& contact : contacts_) {
    const int row = 3 * model_.free_index()[contact.candidate.node];
    const double mu = parameters_.friction_coefficients[contact.candidate.obstacle];
    product.middleRows<3>(row) = ContactPositionJacobian(contact, mu, motion_of(contact)) * columns.middleRows<3>(row);
  }
  return product;
}

Eigen::MatrixXd StepDerivative::TimesFramesTransposed(const Eigen::MatrixXd& columns) const {
  Eigen::MatrixXd product = Eigen::MatrixXd::Zero(columns.rows(), columns.cols());
  for (const Contact& contact : contacts_) {
    const int row = 3 * model_.free_index()[contact.candidate.node];
    const double mu = parameters_.friction_coefficients[contact.candidate.obstacle];
    product.middleRows<3>(row) =
        ContactPositionJacobian(contact, mu, motion_of(contact)).transpose() * columns.middleRows<3>(row);
  }
  return product;
}

Eigen::VectorXd StepDerivative::DragDerivative(ParameterId id) const {
  const double h = record_.time_step;
  Eigen::VectorXd derivative = Eigen::VectorXd::Zero(record_.positions.size());
  if (const AirDrag* drag = model_.drag(); drag != nullptr && IsWind(id.kind)) {
    for (const int node : model_.free_nodes()) {
      derivative.segment<3>(3 * node) = -h * parameters_.material.drag * drag->areas()[node] *
                                        drag->WindDerivativeAt(node, record_.time, parameters_.wind, id);
    }
  }
  const DirectionalDrag* drag = model_.directional_drag();
  if (drag == nullptr) return derivative;
  if (IsWind(id.kind)) {
    drag->AddWindDerivative(-h, DragConstantsOf(parameters_.material), record_.velocities, held_.air, parameters_.wind,
                            record_.time, id, &derivative);
  } else {
    // The force is linear in its constants.
    Eigen::VectorXd force = Eigen::VectorXd::Zero(derivative.size());
    const DragConstants unit = {id.kind == ParameterKind::kNormalDrag ? 1.0 : 0.0,
                                id.kind == ParameterKind::kTangentialDrag ? 1.0 : 0.0};
    drag->AddForce(unit, record_.velocities, held_.air, &force);
    derivative -= h * force;
  }
  return derivative;
}

// g = M (v - v_n) - h (rho a g_0 + node_force + c_d a (w - v) + F) - h f_int, F the drag by direction
Eigen::VectorXd StepDerivative::MomentumDerivative(ParameterId id) const {
  if (IsOfContact(id.kind)) return Eigen::VectorXd::Zero(3 * model_.num_free());
  const double h = record_.time_step;
  Eigen::VectorXd derivative = Eigen::VectorXd::Zero(record_.positions.size());
  switch (RowOf(id.kind).term) {
    case ParameterTerm::kMembrane:
      model_.membrane().AddForceDerivative(id, -h, record_.positions, &derivative);
      break;
    case ParameterTerm::kBending:
      model_.AddBendingDerivative(id, -h, record_.positions, &derivative);
      break;
    case ParameterTerm::kMass: {
      const Eigen::VectorXd& areas = *model_.MassSlopes(id);
      const bool has_weight = id.kind == ParameterKind::kDensity;
      for (const int node : model_.free_nodes()) {
        Eigen::Vector3d change = record_.velocities.segment<3>(3 * node) - start_.velocities.segment<3>(3 * node);
        if (has_weight) change -= h * model_.scene().gravity;
        derivative.segment<3>(3 * node) = areas[node] * change;
      }
      break;
    }
    case ParameterTerm::kDrag:
      if (model_.drag() == nullptr) break;
      for (const int node : model_.free_nodes()) {
        derivative.segment<3>(3 * node) =
            h * model_.DragAreas(id)[node] *
            (record_.velocities.segment<3>(3 * node) - model_.drag()->WindAt(node, record_.time, parameters_.wind));
      }
      break;
    case ParameterTerm::kSize:
      if (sizes_ == nullptr) throw std::logic_error("the derivative by a size that was not asked for");
      derivative = sizes_->MomentumDerivative(id.kind, record_, start_);
      break;
    case ParameterTerm::kDirectionalDrag:
    case ParameterTerm::kWind:
      derivative = DragDerivative(id);
      break;
    case ParameterTerm::kDamping:
      if (model_.damping() != nullptr) {
        model_.DampingOf(id).AddForce(-h, h, held_.start_metrics, record_.positions, &derivative);
      }
      break;
    case ParameterTerm::kFriction:
    case ParameterTerm::kSelfFriction:
    case ParameterTerm::kPlacement:
      break;  // of contact: above
  }
  return model_.Gather(derivative);
}

const Eigen::VectorXd* StepDerivative::MassSlopes(ParameterId id) const {
  return IsSize(id.kind) ? &sizes_->MassSlopes(id.kind) : model_.MassSlopes(id);
}

std::vector<MotionChange> StepDerivative::MotionChanges(ParameterId id) const {
  std::vector<MotionChange> changes(contacts_.size());
  if (contacts_.empty()) return changes;
  const ObstacleChange change(model_.scene().obstacles[id.obstacle], motions_[id.obstacle],
                              parameters_.placement(id.obstacle), RowOf(id.kind).part, record_.times());
  for (std::size_t i = 0; i < contacts_.size(); ++i) {
    const ContactCandidate& candidate = contacts_[i].candidate;
    if (candidate.obstacle != id.obstacle) continue;
    changes[i] =
        change.At(start_.positions.segment<3>(3 * candidate.node), candidate.normal, candidate.normal_gradient);
  }
  return changes;
}

Eigen::VectorXd StepDerivative::ImpulseDerivative(ParameterId id) const {
  Eigen::VectorXd derivative = Eigen::VectorXd::Zero(3 * model_.num_free());
  if (IsPlacement(id.kind)) {
    const std::vector<MotionChange> changes = MotionChanges(id);
    for (std::size_t i = 0; i < contacts_.size(); ++i) {
      const ContactCandidate& candidate = contacts_[i].candidate;
      if (candidate.obstacle != id.obstacle) continue;
      derivative.segment<3>(3 * model_.free_index()[candidate.node]) =
          ContactMotionDerivative(contacts_[i], parameters_.friction_coefficients[candidate.obstacle], changes[i]);
    }
  }
  if (id.kind != ParameterKind::kFriction) return derivative;
  for (const Contact& contact : contacts_) {
    if (contact.response.branch != ContactBranch::kSlip) continue;
    if (id.obstacle != kAllObstacles && id.obstacle != contact.candidate.obstacle) continue;
    derivative.segment<3>(3 * model_.free_index()[contact.candidate.node]) =
        contact.response.normal_force * contact.response.slip_direction;
  }
  return derivative;
}

}  // namespace clothid
