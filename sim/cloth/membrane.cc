#include "sim/cloth/membrane.h"

#include <algorithm>
#include <cstddef>
#include <utility>

namespace clothid {
namespace {

OrthotropicConstants ConstantsOf(const Material& material) {
  return {material.warp_stiffness, material.weft_stiffness, material.poisson_stiffness, material.shear_stiffness};
}

using Parts = std::shared_ptr<const std::vector<MembranePart>>;

std::variant<StretchEnergy, OrthotropicEnergy, Parts> MakeEnergy(MembraneLaw law,
                                                                 std::shared_ptr<const TriangleElements> triangles) {
  if (law == MembraneLaw::kOrthotropic) return OrthotropicEnergy(std::move(triangles));
  return StretchEnergy(std::move(triangles));
}

}  // namespace

Membrane::Membrane(MembraneLaw law, std::shared_ptr<const TriangleElements> triangles)
    : energy_(MakeEnergy(law, std::move(triangles))) {}

Membrane::Membrane(std::vector<MembranePart> parts)
    : energy_(std::make_shared<const std::vector<MembranePart>>(std::move(parts))) {}

void Membrane::SetMaterials(const std::vector<Material>& materials) {
  const auto* const parts = std::get_if<Parts>(&energy_);
  if (parts == nullptr) return;
  std::vector<MembranePart> others = **parts;
  for (std::size_t i = 0; i < others.size(); ++i) others[i].material = materials[i];
  energy_ = std::make_shared<const std::vector<MembranePart>>(std::move(others));
}

double Membrane::AddForce(const Material& material, const Eigen::VectorXd& positions, Eigen::VectorXd* force) const {
  if (const auto* arap = std::get_if<StretchEnergy>(&energy_)) {
    return material.stretch_stiffness * arap->AddForce(material.stretch_stiffness, positions, force);
  }
  if (const auto* orthotropic = std::get_if<OrthotropicEnergy>(&energy_)) {
    return orthotropic->AddForce(ConstantsOf(material), positions, force);
  }
  double energy = 0.0;
  for (const MembranePart& part : *std::get<Parts>(energy_)) {
    energy += part.membrane.AddForce(part.material, positions, force);
  }
  return energy;
}

void Membrane::AddHessian(double factor, const Material& material, HessianKind kind, const Eigen::VectorXd& positions,
                          BlockMatrix* hessian) const {
  if (const auto* arap = std::get_if<StretchEnergy>(&energy_)) {
    arap->AddHessian(factor * material.stretch_stiffness, kind, positions, hessian);
    return;
  }
  if (const auto* parts = std::get_if<Parts>(&energy_)) {
    for (const MembranePart& part : **parts) part.membrane.AddHessian(factor, part.material, kind, positions, hessian);
    return;
  }
  OrthotropicConstants constants = ConstantsOf(material);
  for (double* constant : {&constants.c11, &constants.c22, &constants.c12, &constants.c66}) *constant *= factor;
  std::get<OrthotropicEnergy>(energy_).AddHessian(constants, kind, positions, hessian);
}

void Membrane::AddForceDerivative(ParameterId id, double factor, const Eigen::VectorXd& positions,
                                  Eigen::VectorXd* force) const {
  if (const auto* arap = std::get_if<StretchEnergy>(&energy_)) {
    if (id.kind == ParameterKind::kStretchStiffness) arap->AddForce(factor, positions, force);
    return;
  }
  if (const auto* parts = std::get_if<Parts>(&energy_)) {
    for (std::size_t i = 0; i < (*parts)->size(); ++i) {
      if (id.piece != kWholeCloth && id.piece != static_cast<int>(i)) continue;
      (**parts)[i].membrane.AddForceDerivative({id.kind}, factor, positions, force);
    }
    return;
  }
  if (id.kind == ParameterKind::kStretchStiffness) return;
  Material direction;
  direction.*RowOf(id.kind).constant = factor;
  std::get<OrthotropicEnergy>(energy_).AddForce(ConstantsOf(direction), positions, force);
}

double Membrane::SystemStiffness(const Material& material) const {
  if (std::holds_alternative<StretchEnergy>(energy_)) return material.stretch_stiffness;
  if (const auto* parts = std::get_if<Parts>(&energy_)) {
    double largest = 0.0;
    for (const MembranePart& part : **parts) {
      largest = std::max(largest, part.membrane.SystemStiffness(part.material));
    }
    return largest;
  }
  return ConstantsOf(material).Largest();
}

}  // namespace clothid
