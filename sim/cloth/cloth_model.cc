#include "sim/cloth/cloth_model.h"

#include <algorithm>
#include <stdexcept>
#include <utility>

#include "sim/force/damping_term.h"
#include "sim/force/directional_drag.h"
#include "sim/force/membrane.h"
#include "sim/force/pressure_term.h"
#include "sim/force/seam_term.h"
#include "sim/matrix/fill_reducing_order.h"
#include "sim/scene/warp.h"

namespace clothid {
namespace {

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

}  // namespace

ClothModel::ClothModel(const Scene& scene) : ClothModel(scene, scene.mesh, nullptr) {}

ClothModel::ClothModel(const Scene& scene, const Mesh& chosen_on) : ClothModel(scene, chosen_on, nullptr) {}

ClothModel::ClothModel(const Scene& scene, const ClothModel& like) : ClothModel(scene, like.chosen_on(), &like) {}

ClothModel::ClothModel(const Scene& scene, const Mesh& chosen_on, const ClothModel* like)
    : scene_(&scene), chosen_on_(&chosen_on), nodes_(scene) {
  BendingMatrices bending = MakeBendingMatrices(scene, chosen_on);
  Eigen::SparseMatrix<double> seams;
  if (!scene.mesh.links.empty()) seams = SeamMatrix(scene.mesh);
  if (like == nullptr) {
    NumberFreeNodes(bending.matrices, seams);
    pattern_ =
        std::make_shared<BlockPattern>(FreeNeighbours(scene.mesh, free_index_, num_free(), bending.matrices, seams));
    if (has_contact()) touch_gap_ = scene.touch * ClothSize(scene.mesh);
  } else {
    free_nodes_ = like->free_nodes_;
    free_index_ = like->free_index_;
    touch_gap_ = like->touch_gap_;
    pattern_ = PatternFor(FreeNeighbours(scene.mesh, free_index_, num_free(), bending.matrices, seams), like->pattern_);
  }
  Eigen::Matrix3Xd warp;
  const bool has_axes = scene.membrane != MembraneLaw::kArap;
  if (has_axes) warp = WarpDirections(scene.warp, scene.mesh);
  triangles_ = std::make_shared<const TriangleElements>(
      MakeTriangleElements(scene.mesh, free_index_, *pattern_, has_axes ? &warp : nullptr));
  laplacian_diagonal_ = LaplacianDiagonal(*triangles_, num_nodes());
  stretch_.emplace(triangles_);
  MakeForces(std::move(bending), std::move(seams));
}

// The one place that lists them.
void ClothModel::MakeForces(BendingMatrices bending, Eigen::SparseMatrix<double> seams) {
  const Scene& scene = *scene_;
  const Mesh& mesh = scene.mesh;
  const std::vector<int> one;
  const ParameterKind stiffness =
      scene.membrane == MembraneLaw::kArap ? ParameterKind::kStretchStiffness : ParameterKind::kWarpStiffness;
  const bool has_pieces = scene.has_of_pieces(stiffness);
  forces_.Add(std::make_unique<MembraneTerm>(scene.membrane, triangles_, has_pieces ? mesh.face_pieces : one,
                                             has_pieces ? scene.pieces : std::vector<Material>()));
  for (std::size_t i = 0; i < bending.matrices.size(); ++i) {
    forces_.Add(MakeBendingTerm(&bending, i, scene, free_index_, *pattern_));
  }
  if (!mesh.links.empty()) {
    forces_.Add(std::make_unique<SeamTerm>(SeamEnergy(mesh, std::move(seams), free_index_, *pattern_)));
  }
  if (scene.has_directional_drag()) {
    forces_.Add(std::make_unique<DirectionalDrag>(scene.air_law, RestPlaces(mesh.rest_positions, node_areas()),
                                                  triangles_, free_index_, *pattern_));
  }
  if (scene.has_term(ParameterKind::kPressure)) forces_.Add(std::make_unique<PressureTerm>(mesh.faces));
  if (scene.has_damping()) {
    forces_.Add(std::make_unique<DampingTerm>(triangles_, scene.pieces.empty() ? one : mesh.face_pieces));
  }
}

const BendingEnergy* ClothModel::bending() const {
  const auto* const first = forces_.Find<BendingTerm>();
  return first != nullptr && first->kind() == ParameterKind::kBendingStiffness ? &first->energy() : nullptr;
}

bool ClothModel::SetVariation(const Parameters& parameters) {
  const bool has_fields = parameters.fields == fields_;
  const bool has_pieces =
      scene_->pieces.empty() || (parameters.pieces == piece_materials_ && parameters.material == level_);
  if (has_fields && has_pieces) return false;
  if (!has_pieces && parameters.pieces.size() != scene_->pieces.size()) {
    throw std::logic_error("the parameters of a cloth of pieces: expected a material for each");
  }
  fields_ = parameters.fields;
  if (!has_pieces) {
    level_ = parameters.material;
    piece_materials_ = parameters.pieces;
  }
  const ForceVariation variation{*scene_, parameters, !has_fields, !has_pieces, free_index_, *pattern_};
  nodes_.SetVariation(variation, scene_->mesh);
  forces_.SetVariation(variation);
  if (const auto factors = variation.FieldOf(ParameterKind::kStretchStiffness)) {
    stretch_.emplace(WeightedTriangles(*triangles_, *factors));
  }
  return true;
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

Eigen::MatrixXd ClothModel::GatherHandles(const Eigen::MatrixXd& all) const {
  const std::vector<int>& nodes = scene_->handles.nodes;
  const auto num_handles = static_cast<Eigen::Index>(nodes.size());
  Eigen::MatrixXd held(3 * num_handles, all.cols());
  for (Eigen::Index i = 0; i < num_handles; ++i) held.middleRows<3>(3 * i) = all.middleRows<3>(3 * nodes[i]);
  return held;
}

Eigen::MatrixXd ClothModel::ScatterHandles(const Eigen::MatrixXd& held) const {
  const std::vector<int>& nodes = scene_->handles.nodes;
  Eigen::MatrixXd all = Eigen::MatrixXd::Zero(3 * num_nodes(), held.cols());
  for (Eigen::Index i = 0; 3 * i < held.rows(); ++i) all.middleRows<3>(3 * nodes[i]) = held.middleRows<3>(3 * i);
  return all;
}

}  // namespace clothid
