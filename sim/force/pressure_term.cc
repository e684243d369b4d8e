#include "sim/force/pressure_term.h"

#include <Eigen/Geometry>

namespace clothid {
namespace {

// f of p = 1 Pa over all nodes [3N], m^2.
struct HeldAreas final : HeldForce {
  Eigen::VectorXd areas;
};

const Eigen::VectorXd& AreasOf(const HeldForce* held) { return static_cast<const HeldAreas*>(held)->areas; }

// Two edges of a triangle from its first corner.
struct Edges {
  Eigen::Vector3d first, second;
};

Edges EdgesOf(const Eigen::Vector3i& face, const double* positions) {
  const auto corner = [&](int k) { return Eigen::Map<const Eigen::Vector3d>(positions + 3 * face[k]); };
  return {corner(1) - corner(0), corner(2) - corner(0)};
}

}  // namespace

void PressureTerm::Hold(const Parameters&, double, const ForceStart& start, std::unique_ptr<HeldForce>* held) const {
  if (*held == nullptr) *held = std::make_unique<HeldAreas>();
  Eigen::VectorXd& areas = static_cast<HeldAreas*>(held->get())->areas;
  areas.setZero(start.predicted.size());
  for (Eigen::Index f = 0; f < faces_.cols(); ++f) {
    const Edges edges = EdgesOf(faces_.col(f), start.predicted.data());
    const Eigen::Vector3d third = edges.first.cross(edges.second) / 6.0;
    for (const int node : faces_.col(f)) areas.segment<3>(3 * node) += third;
  }
}

// The potential is -f . x, as f does not change over the solve.
double PressureTerm::AddForce(const ForcePoint& point, const HeldForce* held, Eigen::VectorXd* force) const {
  const double pressure = point.parameters.material.pressure;
  *force += pressure * AreasOf(held);
  return -pressure * AreasOf(held).dot(point.positions);
}

void PressureTerm::AddPredictionProduct(double factor, const ForcePoint& point, const HeldForce*,
                                        const Eigen::VectorXd& predicted, const Eigen::MatrixXd& columns,
                                        Eigen::MatrixXd* product) const {
  const double sixth = factor * point.parameters.material.pressure / 6.0;
  for (Eigen::Index f = 0; f < faces_.cols(); ++f) {
    const Edges edges = EdgesOf(faces_.col(f), predicted.data());
    for (Eigen::Index c = 0; c < columns.cols(); ++c) {
      const Edges changes = EdgesOf(faces_.col(f), columns.col(c).data());
      const Eigen::Vector3d third = sixth * (changes.first.cross(edges.second) + edges.first.cross(changes.second));
      for (const int node : faces_.col(f)) product->col(c).segment<3>(3 * node) += third;
    }
  }
}

void PressureTerm::AddPredictionProductTransposed(double factor, const ForcePoint& point, const HeldForce*,
                                                  const Eigen::VectorXd& predicted, const Eigen::MatrixXd& columns,
                                                  Eigen::MatrixXd* product) const {
  const double sixth = factor * point.parameters.material.pressure / 6.0;
  for (Eigen::Index f = 0; f < faces_.cols(); ++f) {
    const Edges edges = EdgesOf(faces_.col(f), predicted.data());
    for (Eigen::Index c = 0; c < columns.cols(); ++c) {
      Eigen::Vector3d sum = Eigen::Vector3d::Zero();
      for (const int node : faces_.col(f)) sum += columns.col(c).segment<3>(3 * node);
      const Eigen::Vector3d by_first = sixth * edges.second.cross(sum), by_second = sixth * sum.cross(edges.first);
      product->col(c).segment<3>(3 * faces_(0, f)) -= by_first + by_second;
      product->col(c).segment<3>(3 * faces_(1, f)) += by_first;
      product->col(c).segment<3>(3 * faces_(2, f)) += by_second;
    }
  }
}

void PressureTerm::AddDerivative(ParameterId id, double factor, const ForcePoint&, const HeldForce* held,
                                 Eigen::VectorXd* force) const {
  if (id.kind == ParameterKind::kPressure) *force += factor * AreasOf(held);
}

std::unique_ptr<ForceTerm> PressureTerm::PartOf(const ForcePart& part) const {
  Eigen::Matrix3Xi faces = faces_(Eigen::all, part.faces);
  for (int& node : faces.reshaped()) node = part.index[node];
  return std::make_unique<PressureTerm>(std::move(faces));
}

}  // namespace clothid
