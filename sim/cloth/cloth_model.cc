#include "sim/cloth/cloth_model.h"

#include <algorithm>
#include <stdexcept>
#include <utility>

#include "sim/matrix/fill_reducing_order.h"
#include "sim/scene/pieces.h"
#include "sim/shell/bending_patch.h"

namespace clothid {
namespace {

// Of the law that the scene has.
std::vector<BendingMatrix> BendingMatrices(const Scene& scene, const Mesh& chosen_on) {
  if (!scene.has_bending()) return {};
  if (scene.bending.law == BendingLaw::kEdges) {
    return {{ParameterKind::kBendingStiffness, EdgeBendingMatrix(scene.mesh), {}}};
  }
  const bool orthotropic = scene.bending.orthotropic;
  const BendingPatches patches(scene.mesh,
                               orthotropic ? WarpDirections(scene.warp, scene.mesh) : FirstEdges(scene.mesh),
                               RestOf(scene), chosen_on);
  const auto term = [&](ParameterKind kind, const FlexuralRigidity& rigidity) -> BendingMatrix {
    return {kind, patches.Matrix(rigidity), patches.Moments(rigidity)};
  };
  if (!orthotropic) return {term(ParameterKind::kBendingStiffness, IsotropicRigidity(1.0, scene.bending.poisson))};
  const OrthotropicShares shares = SharesOfRigidity(scene.bending.poisson);
  return {term(ParameterKind::kWarpBending, shares.warp), term(ParameterKind::kWeftBending, shares.weft),
          term(ParameterKind::kTwistBending, shares.twist)};
}

// Neighbours of each free node: those that share a triangle, and those that have an entry in the matrices of bending
// and of `seams`.
std::vector<std::vector<int>> FreeNeighbours(const Mesh& mesh, const std::vector<int>& free_index, int num_free,
                                             const std::vector<BendingMatrix>& bending,
                                             const Eigen::SparseMatrix<double>& seams) {
  std::vector<std::vector<int>> neighbours(num_free);
  const auto add = [&](int a, int b) {
    if (a != b && free_index[a] >= 0 && free_index[b] >= 0) neighbours[free_index[a]].push_back(free_index[b]);
  };
  for (int f = 0; f < mesh.num_faces(); ++f) {
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) add(mesh.faces(i, f), mesh.faces(j, f));
    }
  }
  const auto add_entries = [&](const Eigen::SparseMatrix<double>& matrix) {
    for (int column = 0; column < matrix.outerSize(); ++column) {
      for (Eigen::SparseMatrix<double>::InnerIterator it(matrix, column); it; ++it) {
        add(static_cast<int>(it.row()), static_cast<int>(it.col()));
      }
    }
  };
  add_entries(seams);
  for (const BendingMatrix& term : bending) {
    add_entries(term.matrix);
    for (const RestMoment& moment : term.moments) {
      for (const int node : moment.nodes) {
        for (std::size_t k = 0; k < 3; ++k) {
          add(node, moment.nodes[k]);
          add(moment.nodes[k], node);
        }
      }
    }
  }
  return neighbours;
}

// `pattern`, or, where it lacks some of the neighbours, one that has both.
std::shared_ptr<const BlockPattern> PatternFor(std::vector<std::vector<int>> neighbours,
                                               const std::shared_ptr<const BlockPattern>& pattern) {
  bool covers = true;
  for (int i = 0; i < pattern->num_blocks(); ++i) {
    const int* const rows = pattern->rows_begin(i);
    for (const int j : neighbours[i]) covers = covers && std::binary_search(rows, rows + pattern->num_rows(i), j);
  }
  if (covers) return pattern;
  for (int i = 0; i < pattern->num_blocks(); ++i) {
    for (int k = 0; k < pattern->num_rows(i); ++k) {
      if (const int j = pattern->rows_begin(i)[k]; j != i) neighbours[i].push_back(j);
    }
  }
  return std::make_shared<BlockPattern>(neighbours);
}

bool HasField(const Scene& scene, ParameterKind kind) {
  return std::any_of(scene.fields.begin(), scene.fields.end(),
                     [kind](const GridField& field) { return field.kind == kind; });
}

}  // namespace

double BendingTerm::AddForce(double stiffness, const Eigen::VectorXd& positions, Eigen::VectorXd* force) const {
  const double quadratic = energy.AddForce(stiffness, positions, force);
  return curvature == nullptr ? quadratic : quadratic + curvature->AddForce(stiffness, positions, force);
}

void BendingTerm::AddHessian(double stiffness, HessianKind hessian_kind, const Eigen::VectorXd& positions,
                             BlockMatrix* hessian) const {
  energy.AddHessian(stiffness, hessian);
  if (curvature != nullptr) curvature->AddHessian(stiffness, hessian_kind, positions, hessian);
}

ClothModel::ClothModel(const Scene& scene) : ClothModel(scene, scene.mesh, nullptr) {}

ClothModel::ClothModel(const Scene& scene, const Mesh& chosen_on) : ClothModel(scene, chosen_on, nullptr) {}

ClothModel::ClothModel(const Scene& scene, const ClothModel& like) : ClothModel(scene, like.chosen_on(), &like) {}

ClothModel::ClothModel(const Scene& scene, const Mesh& chosen_on, const ClothModel* like)
    : scene_(&scene), chosen_on_(&chosen_on), node_areas_(NodeAreas(scene.mesh)) {
  std::vector<BendingMatrix> bending = MakeBending();
  Eigen::SparseMatrix<double> seams;
  if (!scene.mesh.links.empty()) seams = SeamMatrix(scene.mesh);
  if (like == nullptr) {
    NumberFreeNodes(bending, seams);
    pattern_ = std::make_shared<BlockPattern>(FreeNeighbours(scene.mesh, free_index_, num_free(), bending, seams));
    if (has_contact()) touch_gap_ = scene.touch * ClothSize(scene.mesh);
  } else {
    free_nodes_ = like->free_nodes_;
    free_index_ = like->free_index_;
    touch_gap_ = like->touch_gap_;
    pattern_ = PatternFor(FreeNeighbours(scene.mesh, free_index_, num_free(), bending, seams), like->pattern_);
  }
  if (!scene.mesh.links.empty()) seams_.emplace(scene.mesh, std::move(seams), free_index_, *pattern_);
  if (scene.has_drag()) drag_.emplace(scene);
  for (BendingMatrix& term : bending) {
    bending_terms_.push_back({term.kind, RowOf(term.kind).constant,
                              BendingEnergy(std::move(term.matrix), free_index_, *pattern_),
                              MakeCurvature(std::move(term.moments))});
  }
  Eigen::Matrix3Xd warp;
  const bool has_axes = scene.membrane == MembraneLaw::kOrthotropic;
  if (has_axes) warp = WarpDirections(scene.warp, scene.mesh);
  triangles_ = std::make_shared<const TriangleElements>(
      MakeTriangleElements(scene.mesh, free_index_, *pattern_, has_axes ? &warp : nullptr));
  laplacian_diagonal_ = LaplacianDiagonal(*triangles_, num_nodes());
  membrane_.emplace(scene.membrane, triangles_);
  stretch_.emplace(triangles_);
  if (scene.has_directional_drag()) directional_drag_.emplace(scene, triangles_, free_index_, *pattern_);
  if (scene.has_damping()) damping_.emplace(triangles_);
  if (!scene.pieces.empty()) MakePieces();
}

std::vector<BendingMatrix> ClothModel::MakeBending() {
  const bool varies = !scene_->pieces.empty() || HasField(*scene_, ParameterKind::kBendingStiffness);
  if (!scene_->has_bending() || !varies) return BendingMatrices(*scene_, *chosen_on_);
  std::vector<ParameterKind> kinds = {ParameterKind::kBendingStiffness};
  if (scene_->bending.orthotropic) {
    kinds = {ParameterKind::kWarpBending, ParameterKind::kWeftBending, ParameterKind::kTwistBending};
  }
  const Eigen::VectorXd ones = Eigen::VectorXd::Ones(scene_->mesh.num_faces());
  std::vector<BendingMatrix> bending;
  for (const ParameterKind kind : kinds) {
    weighted_bending_.emplace_back(*scene_, kind, *chosen_on_);
    bending.push_back(weighted_bending_.back().Of(ones));
  }
  return bending;
}

void ClothModel::MakePieces() {
  pieces_ = std::make_unique<const ClothPieces>(*scene_, weighted_bending_);
  const bool has_axes = scene_->membrane == MembraneLaw::kOrthotropic;
  if (PiecesOf(has_axes ? ParameterKind::kWarpStiffness : ParameterKind::kStretchStiffness) == nullptr) return;
  membrane_.emplace(MembraneParts(scene_->membrane, *triangles_, scene_->mesh.face_pieces, scene_->pieces));
}

const BendingEnergy* ClothModel::bending() const {
  const bool isotropic = bending_terms_.size() == 1 && bending_terms_[0].kind == ParameterKind::kBendingStiffness;
  return isotropic ? &bending_terms_[0].energy : nullptr;
}

const Eigen::VectorXd* ClothModel::MassSlopes(ParameterId id) const {
  if (id.kind == ParameterKind::kAddedMass) return &node_areas_;
  if (id.kind != ParameterKind::kDensity) return nullptr;
  const ClothPieces* pieces = PiecesOf(id.kind);
  return pieces != nullptr ? &pieces->areas(id.piece) : &mass_areas();
}

const Eigen::VectorXd& ClothModel::DragAreas(ParameterId id) const {
  const ClothPieces* pieces = PiecesOf(ParameterKind::kDrag);
  return pieces != nullptr ? pieces->areas(id.piece) : drag_->areas();
}

void ClothModel::AddBendingDerivative(ParameterId id, double factor, const Eigen::VectorXd& positions,
                                      Eigen::VectorXd* force) const {
  if (const ClothPieces* pieces = PiecesOf(id.kind)) {
    for (const BendingMatrix& term : pieces->bending(id.piece)) {
      if (term.kind == id.kind) term.AddForce(factor, positions, force);
    }
    return;
  }
  for (const BendingTerm& term : bending_terms_) {
    if (term.kind == id.kind) term.AddForce(factor, positions, force);
  }
}

StrainRateDamping ClothModel::DampingOf(ParameterId id) const {
  if (PiecesOf(id.kind) == nullptr) return *damping_;
  return StrainRateDamping(WeightedTriangles(*triangles_, PieceMask(id.piece, scene_->mesh.face_pieces)));
}

bool ClothModel::SetVariation(const Parameters& parameters) {
  const bool has_fields = parameters.fields == fields_;
  const bool has_pieces =
      pieces_ == nullptr || (parameters.pieces == piece_materials_ && parameters.material == level_);
  if (has_fields && has_pieces) return false;
  fields_ = parameters.fields;
  if (!has_fields) SetFields(fields_.get());
  if (!has_pieces) SetPieces(parameters);
  return true;
}

void ClothModel::SetBending(std::size_t term, const Eigen::VectorXd& weights) {
  bending_terms_[term].energy = BendingEnergy(weighted_bending_[term].Matrix(weights), free_index_, *pattern_);
  bending_terms_[term].curvature = MakeCurvature(weighted_bending_[term].Moments(weights));
}

void ClothModel::SetFields(const std::vector<FieldFactors>* fields) {
  for (std::size_t i = 0; i < scene_->fields.size(); ++i) {
    const ParameterKind kind = scene_->fields[i].kind;
    Eigen::VectorXd factors = Eigen::VectorXd::Ones(scene_->mesh.num_faces());
    if (fields != nullptr) factors = (*fields)[i].log_factors.array().exp();
    if (kind == ParameterKind::kStretchStiffness) {
      const auto weighted = WeightedTriangles(*triangles_, factors);
      membrane_.emplace(scene_->membrane, weighted);
      stretch_.emplace(weighted);
    }
    if (kind == ParameterKind::kDensity) mass_areas_ = WeightedNodeAreas(scene_->mesh, factors);
    if (kind == ParameterKind::kBendingStiffness && !weighted_bending_.empty()) SetBending(0, factors);
  }
}

void ClothModel::SetPieces(const Parameters& parameters) {
  if (parameters.pieces.size() != scene_->pieces.size()) {
    throw std::logic_error("the parameters of a cloth of pieces: expected a material for each");
  }
  level_ = parameters.material;
  piece_materials_ = parameters.pieces;
  membrane_->SetMaterials(piece_materials_);
  const auto weights = [&](ParameterKind kind) { return PieceWeights(parameters, kind, scene_->mesh); };
  if (PiecesOf(ParameterKind::kDensity) != nullptr) {
    mass_areas_ = WeightedNodeAreas(scene_->mesh, weights(ParameterKind::kDensity));
  }
  for (std::size_t i = 0; i < bending_terms_.size(); ++i) {
    if (PiecesOf(bending_terms_[i].kind) != nullptr) SetBending(i, weights(bending_terms_[i].kind));
  }
  if (drag_) drag_->SetAreas(WeightedNodeAreas(scene_->mesh, weights(ParameterKind::kDrag)));
  if (damping_) damping_.emplace(WeightedTriangles(*triangles_, weights(ParameterKind::kDamping)));
}

std::shared_ptr<const RestCurvature> ClothModel::MakeCurvature(std::vector<RestMoment> moments) const {
  if (moments.empty()) return nullptr;
  return std::make_shared<const RestCurvature>(std::move(moments), free_index_, *pattern_);
}

void ClothModel::NumberFreeNodes(const std::vector<BendingMatrix>& bending, const Eigen::SparseMatrix<double>& seams) {
  free_index_.assign(num_nodes(), 0);
  for (const int handle : scene_->handles.nodes) free_index_[handle] = -1;
  std::vector<int> ascending;
  for (int node = 0; node < num_nodes(); ++node) {
    if (free_index_[node] < 0) continue;
    free_index_[node] = static_cast<int>(ascending.size());
    ascending.push_back(node);
  }
  const int num_free = static_cast<int>(ascending.size());
  for (const int k : FillReducingOrder(FreeNeighbours(scene_->mesh, free_index_, num_free, bending, seams))) {
    free_nodes_.push_back(ascending[k]);
  }
  for (int i = 0; i < num_free; ++i) free_index_[free_nodes_[i]] = i;
}

Eigen::VectorXd ClothModel::Gather(const Eigen::VectorXd& all) const {
  Eigen::VectorXd free(3 * num_free());
  for (int i = 0; i < num_free(); ++i) free.segment<3>(3 * i) = all.segment<3>(3 * free_nodes_[i]);
  return free;
}

Eigen::MatrixXd ClothModel::GatherColumns(const Eigen::MatrixXd& all) const {
  Eigen::MatrixXd free(3 * num_free(), all.cols());
  for (int i = 0; i < num_free(); ++i) free.middleRows<3>(3 * i) = all.middleRows<3>(3 * free_nodes_[i]);
  return free;
}

void ClothModel::Scatter(const Eigen::VectorXd& free, Eigen::VectorXd* all) const {
  for (int i = 0; i < num_free(); ++i) all->segment<3>(3 * free_nodes_[i]) = free.segment<3>(3 * i);
}

Eigen::MatrixXd ClothModel::ScatterColumns(const Eigen::MatrixXd& free) const {
  Eigen::MatrixXd all = Eigen::MatrixXd::Zero(3 * num_nodes(), free.cols());
  for (int i = 0; i < num_free(); ++i) all.middleRows<3>(3 * free_nodes_[i]) = free.middleRows<3>(3 * i);
  return all;
}

}  // namespace clothid
