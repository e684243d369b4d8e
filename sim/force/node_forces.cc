#include "sim/force/node_forces.h"

#include <cstddef>
#include <utility>

#include "sim/force/field_terms.h"

namespace clothid {
namespace {

std::size_t PlaceOfPiece(ParameterId id, std::size_t num_places) {
  return id.part == kWhole ? num_places - 1 : static_cast<std::size_t>(id.part);
}

}  // namespace

NodeForces::NodeForces(const Scene& scene)
    : gravity_(scene.gravity),
      node_force_(scene.node_force),
      areas_(NodeAreas(scene.mesh)),
      has_density_pieces_(scene.has_of_pieces(ParameterKind::kDensity)) {
  if (scene.has_drag()) drag_.emplace(scene);
  if (scene.pieces.empty()) return;
  const int num_pieces = static_cast<int>(scene.mesh.piece_names.size());
  for (int i = 0; i <= num_pieces; ++i) {
    const Eigen::VectorXd mask = PieceMask(i < num_pieces ? i : kWhole, scene.mesh.face_pieces);
    piece_areas_.push_back(WeightedNodeAreas(scene.mesh, mask));
  }
}

void NodeForces::SetVariation(const ForceVariation& variation, const Mesh& mesh) {
  std::optional<Eigen::VectorXd> weights = variation.FieldOf(ParameterKind::kDensity);
  if (!weights) weights = variation.PiecesOf(ParameterKind::kDensity);
  if (weights) mass_areas_ = WeightedNodeAreas(mesh, *weights);
  if (!drag_) return;
  if (const auto of_pieces = variation.PiecesOf(ParameterKind::kDrag)) {
    drag_->SetAreas(WeightedNodeAreas(mesh, *of_pieces));
  }
}

double NodeForces::FurtherSlope(const Material& material, double time_step, int node) const {
  return material.density * (mass_areas()[node] - areas_[node]) +
         (drag_ ? time_step * material.drag * (drag_->areas()[node] - areas_[node]) : 0.0);
}

Eigen::Vector3d NodeForces::Impulse(const NodeMotion& motion, const Parameters& parameters) const {
  const Material& material = parameters.material;
  const double heavy_mass = material.density * mass_areas()[motion.node];
  Eigen::Vector3d impulse =
      mass(material, motion.node) * motion.change - motion.time_step * (heavy_mass * gravity_ + node_force_);
  if (drag_) {
    impulse += motion.time_step * drag(material, motion.node) *
               (motion.velocity - drag_->WindAt(motion.node, motion.time, parameters.wind));
  }
  return impulse;
}

bool NodeForces::DependOn(ParameterId id) const {
  return MassSlopes(id) != nullptr || (drag_ && (id.kind == ParameterKind::kDrag || IsWind(id.kind)));
}

Eigen::Vector3d NodeForces::ImpulseDerivative(ParameterId id, const NodeMotion& motion,
                                              const Parameters& parameters) const {
  if (const Eigen::VectorXd* slopes = MassSlopes(id)) {
    Eigen::Vector3d change = motion.change;
    if (id.kind == ParameterKind::kDensity) change -= motion.time_step * gravity_;  // the air has no weight
    return (*slopes)[motion.node] * change;
  }
  if (!DependOn(id)) return Eigen::Vector3d::Zero();
  if (id.kind == ParameterKind::kDrag) {
    return motion.time_step * DragAreas(id)[motion.node] *
           (motion.velocity - drag_->WindAt(motion.node, motion.time, parameters.wind));
  }
  return -motion.time_step * parameters.material.drag * drag_->areas()[motion.node] *
         drag_->WindDerivativeAt(motion.node, motion.time, parameters.wind, id);
}

const Eigen::VectorXd* NodeForces::MassSlopes(ParameterId id) const {
  if (id.kind == ParameterKind::kAddedMass) return &areas_;
  if (id.kind != ParameterKind::kDensity) return nullptr;
  return has_density_pieces_ ? &piece_areas_[PlaceOfPiece(id, piece_areas_.size())] : &mass_areas();
}

const Eigen::VectorXd& NodeForces::DragAreas(ParameterId id) const {
  return piece_areas_.empty() ? drag_->areas() : piece_areas_[PlaceOfPiece(id, piece_areas_.size())];
}

}  // namespace clothid
