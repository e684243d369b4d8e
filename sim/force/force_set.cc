#include "sim/force/force_set.h"

#include <algorithm>
#include <cstddef>

#include "sim/scene/material_field.h"
#include "sim/scene/pieces.h"

namespace clothid {

std::optional<Eigen::VectorXd> ForceVariation::FieldOf(ParameterKind kind) const {
  for (std::size_t i = 0; fields && i < scene.fields.size(); ++i) {
    if (scene.fields[i].kind != kind) continue;
    if (parameters.fields == nullptr) return Eigen::VectorXd::Ones(scene.mesh.num_faces());
    return (*parameters.fields)[i].log_factors.array().exp();
  }
  return std::nullopt;
}

std::optional<Eigen::VectorXd> ForceVariation::PiecesOf(ParameterKind kind) const {
  if (!pieces || !scene.has_of_pieces(kind)) return std::nullopt;
  return PieceWeights(parameters, kind, scene.mesh);
}

void ForceSet::Add(std::unique_ptr<ForceTerm> term) {
  has_group_[static_cast<std::size_t>(term->group())] = true;
  needs_velocities_ = needs_velocities_ || term->needs_velocities();
  needs_origins_ = needs_origins_ || term->needs_origins();
  needs_prediction_ = needs_prediction_ || term->needs_prediction();
  stiffens_ = stiffens_ || term->stiffens();
  terms_.push_back(std::move(term));
}

void ForceSet::SetVariation(const ForceVariation& variation) {
  for (const auto& term : terms_) term->SetVariation(variation);
}

void ForceSet::Hold(const Parameters& parameters, double time, HeldForces* held) const {
  held->terms.resize(terms_.size());
  for (std::size_t i = 0; needs_start() && i < terms_.size(); ++i)
    terms_[i]->Hold(parameters, time, held->start, &held->terms[i]);
}

double ForceSet::AddForce(ForceGroup group, const ForcePoint& point, const HeldForces& held,
                          Eigen::VectorXd* force) const {
  double potential = 0.0;
  for (std::size_t i = 0; i < terms_.size(); ++i) {
    if (terms_[i]->group() == group) potential += terms_[i]->AddForce(point, held.terms[i].get(), force);
  }
  return potential;
}

void ForceSet::SetHessian(HessianKind kind, const ForcePoint& point, const HeldForces& held, double position_factor,
                          double velocity_factor, BlockMatrix* hessian) const {
  ForColumns(hessian->pattern(), point.team, [&](const BlockColumns& columns) {
    hessian->values.segment(columns.begin, columns.end - columns.begin).setZero();
  });
  for (std::size_t i = 0; i < terms_.size(); ++i) {
    terms_[i]->AddPositionHessian(position_factor, kind, point, held.terms[i].get(), hessian);
  }
  hessian->CompleteFromLower(point.team);
  for (std::size_t i = 0; i < terms_.size(); ++i) {
    terms_[i]->AddVelocityHessian(velocity_factor, point, held.terms[i].get(), hessian);
  }
}

void ForceSet::AddVelocityProduct(double factor, const ForcePoint& point, const HeldForces& held,
                                  const Eigen::MatrixXd& columns, Eigen::MatrixXd* product) const {
  for (std::size_t i = 0; i < terms_.size(); ++i) {
    terms_[i]->AddVelocityProduct(factor, point, held.terms[i].get(), columns, product);
  }
}

void ForceSet::AddOriginProduct(double factor, const ForcePoint& point, const Eigen::VectorXd& origin,
                                const Eigen::MatrixXd& columns, Eigen::MatrixXd* product) const {
  for (const auto& term : terms_) term->AddOriginProduct(factor, point, origin, columns, product);
}

void ForceSet::AddOriginProductTransposed(double factor, const ForcePoint& point, const Eigen::VectorXd& origin,
                                          const Eigen::MatrixXd& columns, Eigen::MatrixXd* product) const {
  for (const auto& term : terms_) term->AddOriginProductTransposed(factor, point, origin, columns, product);
}

void ForceSet::AddPredictionProduct(double factor, const ForcePoint& point, const HeldForces& held,
                                    const Eigen::MatrixXd& columns, Eigen::MatrixXd* product) const {
  for (std::size_t i = 0; i < terms_.size(); ++i) {
    terms_[i]->AddPredictionProduct(factor, point, held.terms[i].get(), held.start.predicted, columns, product);
  }
}

void ForceSet::AddPredictionProductTransposed(double factor, const ForcePoint& point, const HeldForces& held,
                                              const Eigen::MatrixXd& columns, Eigen::MatrixXd* product) const {
  for (std::size_t i = 0; i < terms_.size(); ++i) {
    terms_[i]->AddPredictionProductTransposed(factor, point, held.terms[i].get(), held.start.predicted, columns,
                                              product);
  }
}

void ForceSet::AddSlopeForce(const ForcePoint& point, Eigen::VectorXd* force) const {
  for (const auto& term : terms_) term->AddSlopeForce(point, force);
}

void ForceSet::AddDerivative(ParameterId id, double factor, const ForcePoint& point, const HeldForces& held,
                             Eigen::VectorXd* force) const {
  for (std::size_t i = 0; i < terms_.size(); ++i) {
    terms_[i]->AddDerivative(id, factor, point, held.terms[i].get(), force);
  }
}

void ForceSet::AddFieldProducts(const FieldFactors& field, double factor, const ForcePoint& point,
                                const Eigen::MatrixXd& columns, Eigen::Ref<Eigen::MatrixXd> products) const {
  for (const auto& term : terms_) term->AddFieldProducts(field, factor, point, columns, products);
}

double ForceSet::LaplacianWeight(const Material& material, double time_step) const {
  double weight = 0.0;
  for (const auto& term : terms_) weight += term->LaplacianWeight(material, time_step);
  return weight;
}

double ForceSet::StiffnessGrowth(const ForcePoint& point) const {
  double growth = 1.0;
  for (const auto& term : terms_) growth = std::max(growth, term->StiffnessGrowth(point));
  return growth;
}

std::vector<std::vector<int>> ForceSet::CoupledWith(const std::vector<int>& chosen, int num_nodes) const {
  std::vector<bool> is_chosen(static_cast<std::size_t>(num_nodes), false);
  for (const int node : chosen) is_chosen[node] = true;
  std::vector<std::vector<int>> coupled;
  for (const auto& term : terms_) {
    term->VisitCoupled(is_chosen, [&](std::vector<int> nodes) { coupled.push_back(std::move(nodes)); });
  }
  return coupled;
}

ForceSet ForceSet::PartOf(const ForcePart& part) const {
  ForceSet own;
  for (const auto& term : terms_) own.Add(term->PartOf(part));
  return own;
}

}  // namespace clothid
