// The part of HandleForces that is about constants that vary over the cloth.
#include <cmath>
#include <cstddef>

#include "sim/cloth/field_terms.h"
#include "sim/rollout/handle_forces.h"
#include "sim/scene/material_field.h"

namespace clothid {

Eigen::MatrixXd HandleForces::FieldDerivative(int step, const States& states) const {
  if (fields_ == nullptr) return Eigen::MatrixXd(3 * num_groups(), 0);
  const Eigen::Index num_faces = model_.scene().mesh.num_faces();
  Eigen::MatrixXd derivative =
      Eigen::MatrixXd::Zero(3 * num_groups(), static_cast<Eigen::Index>(fields_->size()) * num_faces);
  Eigen::Index first = 0;
  for (const FieldFactors& field : *fields_) {
    if (field.kind == ParameterKind::kStretchStiffness) {
      AddStretchColumns(step, states, derivative.middleCols(first, num_faces));
    } else if (field.kind == ParameterKind::kDensity) {
      AddMassColumns(field, states, derivative.middleCols(first, num_faces));
    } else if (model_.weighted_bending() != nullptr) {
      AddBendingColumns(field, step, states, derivative.middleCols(first, num_faces));
    }
    first += num_faces;
  }
  return derivative;
}

void HandleForces::AddStretchColumns(int step, const States& states, Eigen::Ref<Eigen::MatrixXd> derivative) const {
  const Eigen::VectorXd positions = states[static_cast<std::size_t>(Window(step).place)].col(0);
  Eigen::MatrixXd products = Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(faces_.size()), selection_.cols());
  stretch_->AddForceProducts(material_.stretch_stiffness, positions, selection_, products);
  for (std::size_t i = 0; i < faces_.size(); ++i) {
    derivative.col(faces_[i]) -= products.row(static_cast<Eigen::Index>(i)).transpose();
  }
}

void HandleForces::AddMassColumns(const FieldFactors& field, const States& states,
                                  Eigen::Ref<Eigen::MatrixXd> derivative) const {
  const Mesh& mesh = model_.scene().mesh;
  const Eigen::VectorXd areas = TriangleAreas(mesh);
  for (const Handle& handle : handles_) {
    const Eigen::Vector3d gain = Acceleration(handle, states) - model_.scene().gravity;
    for (const int face : faces_) {
      if ((mesh.faces.col(face).array() != handle.node).all()) continue;
      const double mass = material_.density / 3.0 * areas[face] * std::exp(field.log_factors[face]);
      derivative.col(face).segment<3>(3 * handle.group) += mass * gain;
    }
  }
}

void HandleForces::AddBendingColumns(const FieldFactors& field, int step, const States& states,
                                     Eigen::Ref<Eigen::MatrixXd> derivative) const {
  const Eigen::Index num_rows = 3 * static_cast<Eigen::Index>(model_.num_nodes());
  const Eigen::MatrixXd& near = states[static_cast<std::size_t>(Window(step).place)];
  Eigen::VectorXd positions = Eigen::VectorXd::Zero(num_rows);
  Eigen::MatrixXd columns = Eigen::MatrixXd::Zero(num_rows, selection_.cols());
  for (std::size_t i = 0; i < nodes_.size(); ++i) {
    const Eigen::Index row = 3 * static_cast<Eigen::Index>(i);
    positions.segment<3>(3 * nodes_[i]) = near.col(0).segment<3>(row);
    columns.middleRows<3>(3 * nodes_[i]) = selection_.middleRows<3>(row);
  }
  Eigen::MatrixXd products = Eigen::MatrixXd::Zero(derivative.cols(), columns.cols());
  model_.weighted_bending()->AddForceProducts(material_.bending_stiffness, positions, columns, products);
  derivative -= (field.log_factors.array().exp().matrix().asDiagonal() * products).transpose();
}

}  // namespace clothid
