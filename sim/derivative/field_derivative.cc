#include "sim/derivative/field_derivative.h"

#include <cstddef>
#include <stdexcept>
#include <utility>

#include "sim/force/field_terms.h"
#include "sim/scene/material_field.h"

namespace clothid {
namespace {

// v - v_n - h g_0 of a node.
Eigen::Vector3d MassFactor(const ClothModel& model, const StepRecord& record, const SolveStart& start, int node) {
  return record.velocities.segment<3>(3 * node) - start.velocities.segment<3>(3 * node) -
         record.time_step * model.scene().gravity;
}

Eigen::VectorXd FactorsOf(const FieldFactors& field) { return field.log_factors.array().exp(); }

}  // namespace

FieldTangent::FieldTangent(const Eigen::MatrixXd& columns, const Parameters& parameters, const ClothModel& model)
    : parameters_(parameters), model_(model) {
  if (columns.cols() == 0) return;
  const Mesh& mesh = model.scene().mesh;
  const Eigen::Index num_fields =
      parameters.fields == nullptr ? 0 : static_cast<Eigen::Index>(parameters.fields->size());
  if (columns.rows() != num_fields * mesh.num_faces()) {
    throw std::logic_error("directions of fields: expected those of the parameters, a row per triangle");
  }
  for (Eigen::Index c = 0; c < columns.cols(); ++c) {
    Direction& direction = directions_.emplace_back();
    for (Eigen::Index k = 0; k < num_fields; ++k) {
      const FieldFactors& field = (*parameters.fields)[static_cast<std::size_t>(k)];
      const Eigen::VectorXd weights =
          FactorsOf(field).cwiseProduct(columns.col(c).segment(k * mesh.num_faces(), mesh.num_faces()));
      if (field.kind == ParameterKind::kDensity) {
        direction.masses = parameters.material.density * WeightedNodeAreas(mesh, weights);
      }
      for (const auto& term : model.forces().terms()) {
        if (auto along = term->AlongField(field.kind, weights)) direction.forces.push_back(std::move(along));
      }
    }
  }
}

void FieldTangent::Subtract(const StepRecord& record, const SolveStart& start, Eigen::MatrixXd* right) const {
  const ForcePoint point{parameters_, record.time_step, record.time, record.positions, record.velocities};
  for (std::size_t i = 0; i < directions_.size(); ++i) {
    const Direction& direction = directions_[i];
    Eigen::VectorXd impulse = Eigen::VectorXd::Zero(record.positions.size());  // -dg
    for (const auto& add_force : direction.forces) add_force(record.time_step, point, &impulse);
    for (Eigen::Index node = 0; node < direction.masses.size(); ++node) {
      impulse.segment<3>(3 * node) -=
          direction.masses[node] * MassFactor(model_, record, start, static_cast<int>(node));
    }
    right->col(right->cols() - static_cast<Eigen::Index>(directions_.size() - i)) += model_.Gather(impulse);
  }
}

void FieldTangent::SubtractMasses(const SecondStartDerivative& derivative, StateColumns* second) const {
  for (std::size_t i = 0; i < directions_.size(); ++i) {
    if (directions_[i].masses.size() == 0) continue;
    const Eigen::Index column = second->velocities.cols() - static_cast<Eigen::Index>(directions_.size() - i);
    derivative.SubtractMasses(static_cast<int>(column), directions_[i].masses, second);
  }
}

FieldGradient::FieldGradient(const Parameters& parameters, int num_columns, const ClothModel& model)
    : parameters_(parameters), model_(model) {
  if (parameters.fields == nullptr) return;
  const Mesh& mesh = model.scene().mesh;
  values_ = Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(parameters.fields->size()) * mesh.num_faces(), num_columns);
  for (const FieldFactors& field : *parameters.fields) {
    if (field.kind != ParameterKind::kDensity) continue;
    third_masses_ = (parameters.material.density / 3.0) * TriangleAreas(mesh).cwiseProduct(FactorsOf(field));
  }
}

void FieldGradient::AddSolve(const StepRecord& record, const SolveStart& start, const Eigen::MatrixXd& y) {
  if (is_empty()) return;
  const ForcePoint point{parameters_, record.time_step, record.time, record.positions, record.velocities};
  const Eigen::MatrixXd all = model_.ScatterColumns(y);
  const Eigen::Index num_faces = model_.scene().mesh.num_faces();
  Eigen::Index first_row = 0;
  for (const FieldFactors& field : *parameters_.fields) {
    if (field.kind == ParameterKind::kDensity) {
      Eigen::MatrixXd by_mass(model_.num_nodes(), all.cols());
      for (int node = 0; node < model_.num_nodes(); ++node) {
        by_mass.row(node) = -MassFactor(model_, record, start, node).transpose() * all.middleRows<3>(3 * node);
      }
      AddMassGradient(by_mass, first_row);
    }
    model_.forces().AddFieldProducts(field, record.time_step, point, all, values_.middleRows(first_row, num_faces));
    first_row += num_faces;
  }
}

void FieldGradient::AddSecondStart(const SecondStartDerivative& derivative, const StateColumns& second) {
  if (third_masses_.size() == 0) return;
  Eigen::MatrixXd by_mass = Eigen::MatrixXd::Zero(model_.num_nodes(), values_.cols());
  derivative.AddMassGradient(second, &by_mass);
  Eigen::Index first_row = 0;
  for (const FieldFactors& field : *parameters_.fields) {
    if (field.kind == ParameterKind::kDensity) AddMassGradient(by_mass, first_row);
    first_row += model_.scene().mesh.num_faces();
  }
}

void FieldGradient::AddMassGradient(const Eigen::MatrixXd& by_mass, Eigen::Index first_row) {
  const Mesh& mesh = model_.scene().mesh;
  for (int f = 0; f < mesh.num_faces(); ++f) {
    for (int i = 0; i < 3; ++i) values_.row(first_row + f) += third_masses_[f] * by_mass.row(mesh.faces(i, f));
  }
}

}  // namespace clothid
