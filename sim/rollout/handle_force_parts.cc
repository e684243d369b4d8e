// The part of HandleForces that finds the surroundings of the handles and the terms that act there.
#include <cstddef>
#include <numeric>
#include <string>
#include <utility>

#include "sim/base/error.h"
#include "sim/cloth/field_terms.h"
#include "sim/rollout/handle_forces.h"
#include "sim/scene/material_field.h"
#include "sim/scene/pieces.h"
#include "sim/scene/warp.h"

namespace clothid {
namespace {

// What the factors of a field of `kind` are; nothing where there is none.
const Eigen::VectorXd* LogFactors(const Parameters& parameters, ParameterKind kind) {
  if (parameters.fields == nullptr) return nullptr;
  for (const FieldFactors& field : *parameters.fields) {
    if (field.kind == kind) return &field.log_factors;
  }
  return nullptr;
}

}  // namespace

HandleForces::HandleForces(const ClothModel& model, const Parameters& parameters, int num_steps,
                           const std::vector<std::vector<int>>& groups)
    : model_(model),
      material_(parameters.material),
      wind_(parameters.wind),
      num_steps_(num_steps),
      time_step_(model.scene().time_step),
      groups_(groups),
      fields_(parameters.fields) {
  if (model.directional_drag() != nullptr) {
    throw Error(
        ErrorKind::kBadData,
        "forces at handles: the derivative of what drag by direction adds to them is not known; expected a scene "
        "without drag_normal and drag_tangential");
  }
  for (const SeamLink& link : model.scene().mesh.links) {
    for (const int node : {link.node, link.edge[0], link.edge[1]}) {
      if (model.free_index()[node] >= 0) continue;
      throw Error(ErrorKind::kBadData,
                  "forces at handles: expected no seam that closes and no button at a handle, found "
                  "one at node " +
                      std::to_string(node));
    }
  }
  for (const BendingTerm& term : model.bending_terms()) {
    if (term.curvature == nullptr) continue;
    throw Error(ErrorKind::kBadData, "forces at handles: expected a cloth that is flat at rest");
  }
  for (std::size_t g = 0; g < groups.size(); ++g) {
    if (groups[g].empty()) throw Error(ErrorKind::kBadData, "group " + std::to_string(g) + " of handles: has no node");
    for (const int node : groups[g]) {
      const bool is_handle = node >= 0 && node < model.num_nodes() && model.free_index()[node] < 0;
      if (!is_handle) {
        throw Error(ErrorKind::kBadData,
                    "group " + std::to_string(g) + " of handles: node " + std::to_string(node) + " is no handle");
      }
      const double drag_area = model.drag() != nullptr ? model.drag()->areas()[node] : 0.0;
      handles_.push_back(
          {static_cast<int>(g), node, -1, model.mass_areas()[node], model.mass(material_, node), drag_area});
    }
  }
  FindNodes(groups);
  MakeTriangles(parameters);
  MakeBending();
}

// The corners of the triangles at handles, and what bending couples handles with.
void HandleForces::FindNodes(const std::vector<std::vector<int>>& groups) {
  const Mesh& mesh = model_.scene().mesh;
  std::vector<bool> is_held(static_cast<std::size_t>(mesh.num_nodes())), is_near = is_held;
  for (const std::vector<int>& group : groups) {
    for (const int node : group) is_held[node] = is_near[node] = true;
  }
  for (int f = 0; f < mesh.num_faces(); ++f) {
    const Eigen::Vector3i corners = mesh.faces.col(f);
    if (!is_held[corners[0]] && !is_held[corners[1]] && !is_held[corners[2]]) continue;
    faces_.push_back(f);
    for (const int node : corners) is_near[node] = true;
  }
  for (const BendingTerm& term : model_.bending_terms()) {
    const Eigen::SparseMatrix<double>& matrix = term.energy.matrix();
    for (const Handle& handle : handles_) {
      for (Eigen::SparseMatrix<double>::InnerIterator it(matrix, handle.node); it; ++it) is_near[it.row()] = true;
    }
  }
  local_.assign(is_near.size(), -1);
  for (int node = 0; node < mesh.num_nodes(); ++node) {
    if (!is_near[node]) continue;
    local_[node] = static_cast<int>(nodes_.size());
    nodes_.push_back(node);
  }
  selection_ = Eigen::MatrixXd::Zero(3 * static_cast<Eigen::Index>(nodes_.size()), 3 * num_groups());
  for (Handle& handle : handles_) {
    handle.local = local_[handle.node];
    selection_.block<3, 3>(3 * handle.local, 3 * handle.group) += Eigen::Matrix3d::Identity();
  }
}

void HandleForces::MakeTriangles(const Parameters& parameters) {
  const Scene& scene = model_.scene();
  Mesh mesh;
  mesh.rest_positions = scene.mesh.rest_positions(Eigen::all, nodes_);
  mesh.faces = scene.mesh.faces(Eigen::all, faces_);
  if (scene.mesh.has_corner_rest()) {
    mesh.corner_rest.resize(2, 3 * mesh.faces.cols());
    for (int f = 0; f < mesh.num_faces(); ++f) {
      mesh.corner_rest.middleCols<3>(3 * f) = scene.mesh.corner_rest.middleCols<3>(3 * faces_[f]);
    }
  }
  for (int& node : mesh.faces.reshaped()) node = local_[node];
  std::vector<std::vector<int>> neighbours(nodes_.size());
  for (int f = 0; f < mesh.num_faces(); ++f) {
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) {
        if (i != j) neighbours[mesh.faces(i, f)].push_back(mesh.faces(j, f));
      }
    }
  }
  pattern_ = std::make_shared<const BlockPattern>(neighbours);
  std::vector<int> index(nodes_.size());
  std::iota(index.begin(), index.end(), 0);
  Eigen::Matrix3Xd warp;
  const bool has_axes = scene.membrane == MembraneLaw::kOrthotropic;
  if (has_axes) warp = WarpDirections(scene.warp, scene.mesh)(Eigen::all, faces_);
  std::shared_ptr<const TriangleElements> triangles = std::make_shared<const TriangleElements>(
      MakeTriangleElements(mesh, index, *pattern_, has_axes ? &warp : nullptr));
  triangles_ = triangles;
  if (model_.damping() != nullptr) damping_.emplace(triangles);
  if (const Eigen::VectorXd* factors = LogFactors(parameters, ParameterKind::kStretchStiffness)) {
    triangles = WeightedTriangles(*triangles, (*factors)(faces_).array().exp());
    stretch_.emplace(triangles);
  }
  membrane_.emplace(scene.membrane, triangles);
  if (!scene.pieces.empty()) MakePieces(parameters);
}

void HandleForces::MakePieces(const Parameters& parameters) {
  const Scene& scene = model_.scene();
  if (damping_) {
    const Eigen::VectorXd weights = PieceWeights(parameters, ParameterKind::kDamping, scene.mesh)(faces_);
    damping_.emplace(WeightedTriangles(*triangles_, weights));
  }
  if (stretch_) return;  // a field
  std::vector<int> pieces;
  for (const int face : faces_) pieces.push_back(scene.mesh.face_pieces[static_cast<std::size_t>(face)]);
  membrane_.emplace(MembraneParts(scene.membrane, *triangles_, pieces, parameters.pieces));
}

void HandleForces::MakeBending() {
  for (const BendingTerm& term : model_.bending_terms()) {
    bending_.push_back({term.kind, term.stiffness(material_), RowsOf(term.energy.matrix())});
  }
}

Eigen::SparseMatrix<double> HandleForces::RowsOf(const Eigen::SparseMatrix<double>& matrix) const {
  std::vector<Eigen::Triplet<double>> entries;
  for (const Handle& handle : handles_) {
    // Q is symmetric.
    for (Eigen::SparseMatrix<double>::InnerIterator it(matrix, handle.node); it; ++it) {
      entries.emplace_back(handle.group, local_[it.row()], it.value());
    }
  }
  Eigen::SparseMatrix<double> rows(num_groups(), static_cast<Eigen::Index>(nodes_.size()));
  rows.setFromTriplets(entries.begin(), entries.end());
  return rows;
}

StrainRateDamping HandleForces::DampingOf(ParameterId id) const {
  if (model_.PiecesOf(id.kind) == nullptr) return *damping_;
  const Eigen::VectorXd mask = PieceMask(id.piece, model_.scene().mesh.face_pieces)(faces_);
  return StrainRateDamping(WeightedTriangles(*triangles_, mask));
}

}  // namespace clothid
