#include "sim/cloth/membrane.h"

#include <utility>

namespace clothid {
namespace {

OrthotropicConstants ConstantsOf(const Material& material) {
  return {material.warp_stiffness, material.weft_stiffness, material.poisson_stiffness, material.shear_stiffness};
}

std::variant<StretchEnergy, OrthotropicEnergy> MakeEnergy(MembraneLaw law,
                                                          std::shared_ptr<const TriangleElements> triangles) {
  if (law == MembraneLaw::kOrthotropic) return OrthotropicEnergy(std::move(triangles));
  return StretchEnergy(std::move(triangles));
}

}  // namespace

Membrane::Membrane(MembraneLaw law, std::shared_ptr<const TriangleElements> triangles)
    : energy_(MakeEnergy(law, std::move(triangles))) {}

double Membrane::AddForce(const Material& material, const Eigen::VectorXd& positions, Eigen::VectorXd* force) const {
  if (const auto* arap = std::get_if<StretchEnergy>(&energy_)) {
    return material.stretch_stiffness * arap->AddForce(material.stretch_stiffness, positions, force);
  }
  return std::get<OrthotropicEnergy>(energy_).AddForce(ConstantsOf(material), positions, force);
}

void Membrane::AddHessian(double factor, const Material& material, HessianKind kind, const Eigen::VectorXd& positions,
                          BlockMatrix* hessian) const {
  if (const auto* arap = std::get_if<StretchEnergy>(&energy_)) {
    arap->AddHessian(factor * material.stretch_stiffness, kind, positions, hessian);
    return;
  }
  OrthotropicConstants constants = ConstantsOf(material);
  for (double* constant : {&constants.c11, &constants.c22, &constants.c12, &constants.c66}) *constant *= factor;
  std::get<OrthotropicEnergy>(energy_).AddHessian(constants, kind, positions, hessian);
}

void Membrane::AddForceDerivative(ParameterKind kind, double factor, const Eigen::VectorXd& positions,
                                  Eigen::VectorXd* force) const {
  if (const auto* arap = std::get_if<StretchEnergy>(&energy_)) {
    if (kind == ParameterKind::kStretchStiffness) arap->AddForce(factor, positions, force);
    return;
  }
  if (kind == ParameterKind::kStretchStiffness) return;
  Material direction;
  direction.*MaterialConstant(kind) = factor;
  std::get<OrthotropicEnergy>(energy_).AddForce(ConstantsOf(direction), positions, force);
}

double Membrane::SystemStiffness(const Material& material) const {
  if (std::holds_alternative<StretchEnergy>(energy_)) return material.stretch_stiffness;
  return ConstantsOf(material).Largest();
}

}  // namespace clothid
