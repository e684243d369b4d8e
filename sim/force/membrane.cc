#include "sim/force/membrane.h"

#include <algorithm>
#include <cstddef>
#include <utility>

#include "sim/force/field_terms.h"
#include "sim/scene/material_field.h"

namespace clothid {
namespace {

OrthotropicConstants ConstantsOf(const Material& material) {
  return {material.warp_stiffness, material.weft_stiffness, material.poisson_stiffness, material.shear_stiffness};
}

OrthotropicConstants Scaled(const OrthotropicConstants& k, double factor) {
  return {factor * k.c11, factor * k.c22, factor * k.c12, factor * k.c66};
}

YarnConstants YarnConstantsOf(const Material& material) {
  return {ConstantsOf(material), {material.warp_stiffening, material.weft_stiffening}};
}

// Of laws along warp and weft, what can be a field.
constexpr ParameterKind kPartKinds[] = {ParameterKind::kWarpStiffness, ParameterKind::kWeftStiffness,
                                        ParameterKind::kShearStiffness};

using Parts = std::shared_ptr<const std::vector<MembranePart>>;

std::variant<StretchEnergy, OrthotropicEnergy, YarnEnergy, Parts> MakeEnergy(
    MembraneLaw law, std::shared_ptr<const TriangleElements> triangles) {
  if (law == MembraneLaw::kOrthotropic) return OrthotropicEnergy(std::move(triangles));
  if (law == MembraneLaw::kYarn) return YarnEnergy(std::move(triangles));
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
  if (const auto* yarn = std::get_if<YarnEnergy>(&energy_)) {
    return yarn->AddForce(YarnConstantsOf(material), positions, force);
  }
  double energy = 0.0;
  for (const MembranePart& part : *std::get<Parts>(energy_)) {
    energy += part.membrane.AddForce(part.material, positions, force);
  }
  return energy;
}

void Membrane::AddHessian(double factor, const Material& material, HessianKind kind, const Eigen::VectorXd& positions,
                          BlockMatrix* hessian, ThreadTeam* team) const {
  if (const auto* arap = std::get_if<StretchEnergy>(&energy_)) {
    arap->AddHessian(factor * material.stretch_stiffness, kind, positions, hessian, team);
    return;
  }
  if (const auto* parts = std::get_if<Parts>(&energy_)) {
    for (const MembranePart& part : **parts)
      part.membrane.AddHessian(factor, part.material, kind, positions, hessian, team);
    return;
  }
  if (const auto* yarn = std::get_if<YarnEnergy>(&energy_)) {
    yarn->AddHessian(factor, YarnConstantsOf(material), kind, positions, hessian, team);
    return;
  }
  std::get<OrthotropicEnergy>(energy_).AddHessian(Scaled(ConstantsOf(material), factor), kind, positions, hessian,
                                                  team);
}

void Membrane::AddForceDerivative(ParameterId id, double factor, const Material& material,
                                  const Eigen::VectorXd& positions, Eigen::VectorXd* force) const {
  if (const auto* arap = std::get_if<StretchEnergy>(&energy_)) {
    if (id.kind == ParameterKind::kStretchStiffness) arap->AddForce(factor, positions, force);
    return;
  }
  if (const auto* parts = std::get_if<Parts>(&energy_)) {
    for (std::size_t i = 0; i < (*parts)->size(); ++i) {
      if (id.part != kWhole && id.part != static_cast<int>(i)) continue;
      const MembranePart& part = (**parts)[i];
      part.membrane.AddForceDerivative({id.kind}, factor, part.material, positions, force);
    }
    return;
  }
  if (id.kind == ParameterKind::kStretchStiffness) return;
  Material direction;
  direction.*RowOf(id.kind).constant = factor;
  if (const auto* orthotropic = std::get_if<OrthotropicEnergy>(&energy_)) {
    orthotropic->AddForce(ConstantsOf(direction), positions, force);
    return;
  }
  const YarnEnergy& yarn = std::get<YarnEnergy>(energy_);
  YarnConstants constants = YarnConstantsOf(material);
  if (RowOf(id.kind).need == ParameterNeed::kYarnMembrane) {
    yarn.AddStiffeningDerivative(id.kind == ParameterKind::kWarpStiffening ? 0 : 1, factor, constants, positions,
                                 force);
    return;
  }
  constants.k = ConstantsOf(direction);
  yarn.AddForce(constants, positions, force);
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

double Membrane::StiffnessGrowth(const Material& material, const Eigen::VectorXd& positions) const {
  if (const auto* yarn = std::get_if<YarnEnergy>(&energy_)) {
    return yarn->StiffnessGrowth(YarnConstantsOf(material), positions);
  }
  double growth = 1.0;
  if (const auto* parts = std::get_if<Parts>(&energy_)) {
    for (const MembranePart& part : **parts) {
      growth = std::max(growth, part.membrane.StiffnessGrowth(part.material, positions));
    }
  }
  return growth;
}

void Membrane::AddForceProducts(double factor, const Material& material, const Eigen::VectorXd& positions,
                                const Eigen::MatrixXd& columns, Eigen::Ref<Eigen::MatrixXd> products) const {
  if (const auto* arap = std::get_if<StretchEnergy>(&energy_)) {
    arap->AddForceProducts(factor * material.stretch_stiffness, positions, columns, products);
  } else if (const auto* orthotropic = std::get_if<OrthotropicEnergy>(&energy_)) {
    orthotropic->AddForceProducts(Scaled(ConstantsOf(material), factor), positions, columns, products);
  } else {
    YarnConstants constants = YarnConstantsOf(material);
    constants.k = Scaled(constants.k, factor);
    std::get<YarnEnergy>(energy_).AddForceProducts(constants, positions, columns, products);
  }
}

std::vector<MembranePart> MembraneParts(MembraneLaw law, const TriangleElements& triangles,
                                        const std::vector<int>& face_pieces, const std::vector<Material>& materials) {
  std::vector<std::vector<int>> faces(materials.size());
  for (std::size_t f = 0; f < face_pieces.size(); ++f) {
    faces[static_cast<std::size_t>(face_pieces[f])].push_back(static_cast<int>(f));
  }
  std::vector<MembranePart> parts;
  for (std::size_t i = 0; i < materials.size(); ++i) {
    auto own = std::make_shared<const TriangleElements>(SelectTriangles(triangles, faces[i]));
    parts.push_back({Membrane(law, std::move(own)), materials[i]});
  }
  return parts;
}

MembraneTerm::MembraneTerm(MembraneLaw law, std::shared_ptr<const TriangleElements> triangles,
                           std::vector<int> face_pieces, std::vector<Material> materials)
    : law_(law),
      triangles_(std::move(triangles)),
      face_pieces_(std::move(face_pieces)),
      materials_(std::move(materials)),
      membrane_(materials_.empty() ? Membrane(law, triangles_)
                                   : Membrane(MembraneParts(law, *triangles_, face_pieces_, materials_))) {}

void MembraneTerm::SetWeights(Eigen::VectorXd weights) {
  weights_ = std::move(weights);
  membrane_ = Membrane(law_, WeightedTriangles(*triangles_, weights_));
}

Material MembraneTerm::ConstantPart::Own(const Material& material) const {
  Material own;
  own.*RowOf(kind).constant = material.*RowOf(kind).constant;
  own.warp_stiffening = material.warp_stiffening;
  own.weft_stiffening = material.weft_stiffening;
  return own;
}

void MembraneTerm::SetConstantPart(ParameterKind kind, Eigen::VectorXd weights) {
  parts_.erase(
      std::remove_if(parts_.begin(), parts_.end(), [&](const ConstantPart& part) { return part.kind == kind; }),
      parts_.end());
  Membrane membrane(law_, WeightedTriangles(*triangles_, weights));
  parts_.push_back({kind, std::move(weights), std::move(membrane)});
}

const MembraneTerm::ConstantPart* MembraneTerm::FindPart(ParameterKind kind) const {
  for (const ConstantPart& part : parts_) {
    if (part.kind == kind) return &part;
  }
  return nullptr;
}

Material MembraneTerm::Others(const Material& material) const {
  Material others = material;
  for (const ConstantPart& part : parts_) others.*RowOf(part.kind).constant = 0.0;
  return others;
}

void MembraneTerm::SetVariation(const ForceVariation& variation) {
  if (auto factors = variation.FieldOf(ParameterKind::kStretchStiffness)) SetWeights(std::move(*factors));
  for (const ParameterKind kind : kPartKinds) {
    if (auto factors = variation.FieldOf(kind)) SetConstantPart(kind, std::move(*factors));
  }
  if (!variation.pieces || materials_.empty()) return;
  materials_ = variation.parameters.pieces;
  membrane_.SetMaterials(materials_);
}

double MembraneTerm::AddForce(const ForcePoint& point, const HeldForce*, Eigen::VectorXd* force) const {
  const Material& material = point.parameters.material;
  if (parts_.empty()) return membrane_.AddForce(material, point.positions, force);
  double energy = membrane_.AddForce(Others(material), point.positions, force);
  for (const ConstantPart& part : parts_) {
    energy += part.membrane.AddForce(part.Own(material), point.positions, force);
  }
  return energy;
}

void MembraneTerm::AddPositionHessian(double factor, HessianKind kind, const ForcePoint& point, const HeldForce*,
                                      BlockMatrix* hessian) const {
  const Material& material = point.parameters.material;
  if (parts_.empty()) {
    membrane_.AddHessian(factor, material, kind, point.positions, hessian, point.team);
    return;
  }
  membrane_.AddHessian(factor, Others(material), kind, point.positions, hessian, point.team);
  for (const ConstantPart& part : parts_) {
    part.membrane.AddHessian(factor, part.Own(material), kind, point.positions, hessian, point.team);
  }
}

// A stiffening acts on the constant along its yarn, wherever that is; another constant in its own part alone.
void MembraneTerm::AddDerivative(ParameterId id, double factor, const ForcePoint& point, const HeldForce*,
                                 Eigen::VectorXd* force) const {
  if (RowOf(id.kind).term != ParameterTerm::kMembrane) return;
  const Material& material = point.parameters.material;
  if (parts_.empty()) {
    membrane_.AddForceDerivative(id, factor, material, point.positions, force);
    return;
  }
  const bool is_stiffening = RowOf(id.kind).need == ParameterNeed::kYarnMembrane;
  if (is_stiffening || FindPart(id.kind) == nullptr) {
    membrane_.AddForceDerivative(id, factor, Others(material), point.positions, force);
  }
  for (const ConstantPart& part : parts_) {
    if (!is_stiffening && part.kind != id.kind) continue;
    part.membrane.AddForceDerivative(id, factor, part.Own(material), point.positions, force);
  }
}

void MembraneTerm::AddFieldProducts(const FieldFactors& field, double factor, const ForcePoint& point,
                                    const Eigen::MatrixXd& columns, Eigen::Ref<Eigen::MatrixXd> products) const {
  const ConstantPart* const part = FindPart(field.kind);
  if (part == nullptr && field.kind != ParameterKind::kStretchStiffness) return;
  const Membrane& membrane = part == nullptr ? membrane_ : part->membrane;
  const Material material = part == nullptr ? point.parameters.material : part->Own(point.parameters.material);
  if (faces_.empty()) {
    membrane.AddForceProducts(factor, material, point.positions, columns, products);
    return;
  }
  Eigen::MatrixXd own = Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(faces_.size()), columns.cols());
  membrane.AddForceProducts(factor, material, point.positions, columns, own);
  for (std::size_t i = 0; i < faces_.size(); ++i) {
    products.row(faces_[i]) += own.row(static_cast<Eigen::Index>(i));
  }
}

ForceTerm::FieldDirection MembraneTerm::AlongField(ParameterKind kind, const Eigen::VectorXd& weights) const {
  if (RowOf(kind).term != ParameterTerm::kMembrane) return nullptr;
  return [membrane = Membrane(law_, WeightedTriangles(*triangles_, weights)), kind](
             double factor, const ForcePoint& point, Eigen::VectorXd* force) {
    const Material& material = point.parameters.material;
    membrane.AddForceDerivative({kind}, factor * material.*RowOf(kind).constant, material, point.positions, force);
  };
}

double MembraneTerm::LaplacianWeight(const Material& material, double time_step) const {
  return time_step * time_step * membrane_.SystemStiffness(material);
}

double MembraneTerm::StiffnessGrowth(const ForcePoint& point) const {
  return membrane_.StiffnessGrowth(point.parameters.material, point.positions);
}

std::unique_ptr<ForceTerm> MembraneTerm::PartOf(const ForcePart& part) const {
  std::vector<int> face_pieces;
  for (const int face : part.faces) {
    if (!materials_.empty()) face_pieces.push_back(face_pieces_[static_cast<std::size_t>(face)]);
  }
  auto own = std::make_unique<MembraneTerm>(law_, part.triangles, std::move(face_pieces), materials_);
  own->faces_ = part.faces;
  if (weights_.size() > 0) own->SetWeights(weights_(part.faces));
  for (const ConstantPart& field : parts_) own->SetConstantPart(field.kind, field.weights(part.faces));
  return own;
}

}  // namespace clothid
