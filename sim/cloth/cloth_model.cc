#include "sim/cloth/cloth_model.h"

#include <utility>

#include "sim/cloth/bending_patch.h"
#include "sim/matrix/fill_reducing_order.h"

namespace clothid {
namespace {

// Q [N x N] of the law that the scene has.
Eigen::SparseMatrix<double> BendingMatrix(const Scene& scene) {
  if (scene.bending.law == BendingLaw::kEdges) return EdgeBendingMatrix(scene.mesh);
  const BendingPatches patches(scene.mesh, FirstEdges(scene.mesh));
  return patches.Matrix(IsotropicRigidity(1.0, scene.bending.poisson));
}

// Neighbours of each free node: those that share a triangle, and with bending those that have an entry in its matrix.
std::vector<std::vector<int>> FreeNeighbours(const Mesh& mesh, const std::vector<int>& free_index, int num_free,
                                             const Eigen::SparseMatrix<double>& bending_matrix) {
  std::vector<std::vector<int>> neighbours(num_free);
  const auto add = [&](int a, int b) {
    if (a != b && free_index[a] >= 0 && free_index[b] >= 0) neighbours[free_index[a]].push_back(free_index[b]);
  };
  for (int f = 0; f < mesh.num_faces(); ++f) {
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) add(mesh.faces(i, f), mesh.faces(j, f));
    }
  }
  for (int column = 0; column < bending_matrix.outerSize(); ++column) {
    for (Eigen::SparseMatrix<double>::InnerIterator it(bending_matrix, column); it; ++it) {
      add(static_cast<int>(it.row()), static_cast<int>(it.col()));
    }
  }
  return neighbours;
}

}  // namespace

ClothModel::ClothModel(const Scene& scene) : scene_(scene), node_areas_(NodeAreas(scene.mesh)) {
  Eigen::SparseMatrix<double> bending_matrix;  // empty without bending
  if (scene.has_bending()) bending_matrix = BendingMatrix(scene);
  NumberFreeNodes(bending_matrix);
  if (scene.has_drag()) drag_.emplace(scene);
  pattern_ = std::make_shared<BlockPattern>(FreeNeighbours(scene.mesh, free_index_, num_free(), bending_matrix));
  if (scene.has_bending()) bending_.emplace(std::move(bending_matrix), free_index_, *pattern_);
  triangles_ = std::make_shared<const TriangleElements>(MakeTriangleElements(scene.mesh, free_index_, *pattern_));
  laplacian_diagonal_ = LaplacianDiagonal(*triangles_, num_nodes());
  stretch_.emplace(triangles_);
  if (scene.has_damping()) damping_.emplace(triangles_);
  if (has_contact()) touch_gap_ = scene.touch * ClothSize(scene.mesh);
}

void ClothModel::NumberFreeNodes(const Eigen::SparseMatrix<double>& bending_matrix) {
  free_index_.assign(num_nodes(), 0);
  for (const int handle : scene_.handles.nodes) free_index_[handle] = -1;
  std::vector<int> ascending;
  for (int node = 0; node < num_nodes(); ++node) {
    if (free_index_[node] < 0) continue;
    free_index_[node] = static_cast<int>(ascending.size());
    ascending.push_back(node);
  }
  const int num_free = static_cast<int>(ascending.size());
  for (const int k : FillReducingOrder(FreeNeighbours(scene_.mesh, free_index_, num_free, bending_matrix))) {
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
