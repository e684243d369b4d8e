#include "sim/step_problem.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace clothid {
namespace {

// Diagonal of P = M + h C + h^2 (k L + k_b Q) + h eta L at the free nodes.
Eigen::VectorXd SystemDiagonal(const ClothModel& model, const Material& material, double h) {
  Eigen::VectorXd diagonal = (material.density + (model.drag() ? h * material.drag : 0.0)) * model.node_areas();
  diagonal += h * h * material.stretch_stiffness * model.laplacian_diagonal();
  if (model.damping() != nullptr) diagonal += h * material.damping * model.laplacian_diagonal();
  if (model.bending() != nullptr) diagonal += h * h * material.bending_stiffness * model.bending()->diagonal();
  return diagonal(model.free_nodes());
}

void AddBendingHessian(const ClothModel& model, double stiffness, BlockMatrix* hessian) {
  const Eigen::SparseMatrix<double>& matrix = model.bending()->matrix();
  for (int column = 0; column < matrix.outerSize(); ++column) {
    const int free_column = model.free_index()[column];
    if (free_column < 0) continue;
    for (Eigen::SparseMatrix<double>::InnerIterator it(matrix, column); it; ++it) {
      const int free_row = model.free_index()[it.row()];
      if (free_row < 0) continue;
      hessian->block(hessian->pattern().Find(free_row, free_column)).diagonal().array() += stiffness * it.value();
    }
  }
}

}  // namespace

void AssembleStepHessian(const ClothModel& model, const Parameters& parameters, double time_step, HessianKind kind,
                         const std::vector<Eigen::Matrix2d>& start_metrics, const Eigen::VectorXd& positions,
                         BlockMatrix* hessian) {
  const Material& material = parameters.material;
  const double h = time_step;
  hessian->values.setZero();
  model.stretch().AddHessian(h * h * material.stretch_stiffness, kind, positions, hessian);
  if (model.bending() != nullptr) AddBendingHessian(model, h * h * material.bending_stiffness, hessian);
  if (model.damping() != nullptr) {
    model.damping()->AddHessian(h * h * material.damping, h, kind, start_metrics, positions, hessian);
  }
  const double areal_mass = material.density + (model.drag() ? h * material.drag : 0.0);
  for (int i = 0; i < model.num_free(); ++i) {
    hessian->block(hessian->pattern().Find(i, i)).diagonal().array() +=
        areal_mass * model.node_areas()[model.free_nodes()[i]];
  }
}

std::vector<ContactRecord> RecordContacts(const std::vector<Contact>& contacts) {
  std::vector<ContactRecord> records;
  records.reserve(contacts.size());
  for (const Contact& contact : contacts) {
    records.push_back({contact.candidate.node, contact.candidate.obstacle, contact.response.branch, contact.force});
  }
  return records;
}

std::vector<Contact> RestoreContacts(const ClothModel& model, const Parameters& parameters,
                                     const Eigen::VectorXd& start_positions, double time_step,
                                     const std::vector<ContactRecord>& records) {
  if (records.empty()) return {};
  const Eigen::VectorXd weights = SystemDiagonal(model, parameters.material, time_step);
  std::vector<Contact> contacts;
  contacts.reserve(records.size());
  for (const ContactRecord& record : records) {
    const ContactCandidate candidate = MakeCandidate(model, record.node, start_positions, time_step);
    const double mu = parameters.friction_coefficients[record.obstacle];
    contacts.push_back({candidate, EvaluateContactLaw(record.force, candidate.normal, mu), record.force,
                        weights[model.free_index()[record.node]]});
  }
  return contacts;
}

StepProblem::StepProblem(const ClothModel& model, const Parameters& parameters, const Eigen::VectorXd& positions,
                         const Eigen::VectorXd& velocities, double time_step, double end_time)
    : model_(model),
      parameters_(parameters),
      time_step_(time_step),
      end_time_(end_time),
      start_positions_(positions),
      end_positions_(positions),
      start_velocities_(model.Gather(velocities)),
      weights_(SystemDiagonal(model, parameters.material, time_step)) {
  const Scene& scene = model.scene();
  const Material& material = parameters.material;
  const int num_free = model.num_free();
  masses_.resize(3 * num_free);
  external_impulse_.resize(3 * num_free);
  if (model.drag() != nullptr) drag_.resize(3 * num_free);
  for (int i = 0; i < num_free; ++i) {
    const int node = model.free_nodes()[i];
    const double mass = material.density * model.node_areas()[node];
    masses_.segment<3>(3 * i).setConstant(mass);
    external_impulse_.segment<3>(3 * i) = time_step * (mass * scene.gravity + scene.node_force);
    if (model.drag() == nullptr) continue;
    const double drag = time_step * material.drag * model.drag()->areas()[node];
    drag_.segment<3>(3 * i).setConstant(drag);
    external_impulse_.segment<3>(3 * i) += drag * model.drag()->WindAt(node, end_time);
  }
  if (scene.handles.path.num_handles() > 0) {
    const Eigen::VectorXd path = scene.handles.path.At(end_time);
    for (size_t i = 0; i < scene.handles.nodes.size(); ++i) {
      end_positions_.segment<3>(3 * scene.handles.nodes[i]) = path.segment<3>(3 * static_cast<int>(i));
    }
  }
  if (model.damping() != nullptr) start_metrics_ = model.damping()->Metrics(positions);
  if (model.has_contact()) FindCandidates(model, positions, time_step, &candidates_);
}

int StepProblem::free_block(int candidate) const { return model_.free_index()[candidates_[candidate].node]; }
double StepProblem::weight(int candidate) const { return weights_[free_block(candidate)]; }
double StepProblem::friction_coefficient(int candidate) const {
  return parameters_.friction_coefficients[candidates_[candidate].obstacle];
}

void StepProblem::Evaluate(const Eigen::VectorXd& velocities, StepPoint* point) const {
  point->velocities = velocities;
  point->positions = end_positions_;
  model_.Scatter(model_.Gather(start_positions_) + time_step_ * velocities, &point->positions);

  const Eigen::VectorXd change = velocities - start_velocities_;
  point->momentum_gradient = masses_.cwiseProduct(change) - external_impulse_;
  point->potential = 0.5 * change.cwiseAbs2().dot(masses_) - external_impulse_.dot(velocities);
  point->scale = std::max(
      {external_impulse_.norm(), masses_.cwiseProduct(start_velocities_).norm(), std::numeric_limits<double>::min()});
  AddElasticForce(point);
  if (drag_.size() > 0) {
    point->momentum_gradient += drag_.cwiseProduct(velocities);
    point->potential += 0.5 * drag_.dot(velocities.cwiseAbs2());
  }
  if (model_.damping() != nullptr) AddViscousForce(point);
  point->residual = point->momentum_gradient;
  if (may_touch()) ApplyContactLaw(velocities, point->momentum_gradient, point);
  point->relative_residual = point->residual.norm() / point->scale;
}

void StepProblem::AddElasticForce(StepPoint* point) const {
  const Material& material = parameters_.material;
  Eigen::VectorXd force = Eigen::VectorXd::Zero(3 * model_.num_nodes());
  double energy =
      material.stretch_stiffness * model_.stretch().AddForce(material.stretch_stiffness, point->positions, &force);
  if (model_.bending() != nullptr) {
    energy +=
        material.bending_stiffness * model_.bending()->AddForce(material.bending_stiffness, point->positions, &force);
  }
  AddInternalForce(force, energy, point);
}

void StepProblem::AddViscousForce(StepPoint* point) const {
  const double damping = parameters_.material.damping;
  Eigen::VectorXd force = Eigen::VectorXd::Zero(3 * model_.num_nodes());
  const double potential =
      damping * model_.damping()->AddForce(damping, time_step_, start_metrics_, point->positions, &force);
  AddInternalForce(force, potential, point);
}

void StepProblem::AddInternalForce(const Eigen::VectorXd& force, double potential, StepPoint* point) const {
  const Eigen::VectorXd impulse = time_step_ * model_.Gather(force);
  point->momentum_gradient -= impulse;
  point->potential += potential;
  point->scale = std::max(point->scale, impulse.norm());
}

void StepProblem::ApplyContactLaw(const Eigen::VectorXd& velocities, const Eigen::VectorXd& gradient,
                                  StepPoint* point) const {
  point->residual = gradient;
  point->forces.resize(candidates_.size());
  point->responses.resize(candidates_.size());
  for (size_t i = 0; i < candidates_.size(); ++i) {
    const int index = static_cast<int>(i);
    const int row = 3 * free_block(index);
    const ContactCandidate& candidate = candidates_[i];
    point->forces[i] = weight(index) * (velocities.segment<3>(row) + candidate.gap_speed * candidate.normal) -
                       gradient.segment<3>(row);
    point->responses[i] = EvaluateContactLaw(point->forces[i], candidate.normal, friction_coefficient(index));
    point->residual.segment<3>(row) -= point->responses[i].impulse;
  }
}

void StepProblem::AssembleHessian(HessianKind kind, const StepPoint& point, BlockMatrix* hessian) const {
  AssembleStepHessian(model_, parameters_, time_step_, kind, start_metrics_, point.positions, hessian);
}

double StepProblem::RoundingFloor(const StepPoint& point) const {
  return 0.6 * std::numeric_limits<double>::epsilon() * std::sqrt(3.0) * weights_.norm() *
         point.positions.lpNorm<Eigen::Infinity>() / (time_step_ * point.scale);
}

void StepProblem::ClipToFeasible(Eigen::VectorXd* velocities) const {
  for (size_t i = 0; i < candidates_.size(); ++i) {
    const Eigen::Vector3d& n = candidates_[i].normal;
    auto v = velocities->segment<3>(3 * free_block(static_cast<int>(i)));
    v += std::max(0.0, -candidates_[i].gap_speed - n.dot(v)) * n;
  }
}

std::vector<Contact> StepProblem::ActiveContacts(const StepPoint& point) const {
  std::vector<Contact> contacts;
  for (size_t i = 0; i < candidates_.size(); ++i) {
    if (point.responses[i].branch == ContactBranch::kTakeOff) continue;
    contacts.push_back({candidates_[i], point.responses[i], point.forces[i], weight(static_cast<int>(i))});
  }
  return contacts;
}

Eigen::VectorXd StepProblem::AllVelocities(const StepPoint& point) const {
  Eigen::VectorXd all = (point.positions - start_positions_) / time_step_;
  model_.Scatter(point.velocities, &all);
  return all;
}

}  // namespace clothid
