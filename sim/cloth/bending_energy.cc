#include "sim/cloth/bending_energy.h"

#include <Eigen/Geometry>
#include <array>
#include <map>
#include <utility>
#include <vector>

namespace clothid {
namespace {

// The triangles at an edge and their nodes opposite to it: one at the border, two inside.
struct OppositeNodes {
  std::vector<int> nodes, faces;
};
using EdgeNeighbours = std::map<std::pair<int, int>, OppositeNodes>;  // of edges (low, high)

EdgeNeighbours FindOppositeNodes(const Mesh& mesh) {
  EdgeNeighbours opposite;
  for (int f = 0; f < mesh.num_faces(); ++f) {
    for (int i = 0; i < 3; ++i) {
      const int a = mesh.faces(i, f), b = mesh.faces((i + 1) % 3, f);
      OppositeNodes& edge = opposite[std::minmax(a, b)];
      edge.nodes.push_back(mesh.faces((i + 2) % 3, f));
      edge.faces.push_back(f);
    }
  }
  return opposite;
}

// Cotangent of the angle at `apex` between `a` and `b`.
double Cotangent(const Eigen::Vector3d& apex, const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  return (a - apex).dot(b - apex) / (a - apex).cross(b - apex).norm();
}

}  // namespace

std::vector<BendingElement> EdgeBendingElements(const Mesh& mesh) {
  const auto position = [&mesh](int node) -> Eigen::Vector3d { return mesh.rest_positions.col(node); };
  std::vector<BendingElement> elements;
  for (const auto& [edge, opposite] : FindOppositeNodes(mesh)) {
    if (opposite.faces.size() != 2) continue;
    const std::array<int, 4> nodes = {edge.first, edge.second, opposite.nodes[0], opposite.nodes[1]};
    const Eigen::Vector3d x0 = position(nodes[0]), x1 = position(nodes[1]);
    std::array<double, 4> weights = {0.0, 0.0, 0.0, 0.0};
    double area = 0.0;
    for (int side = 0; side < 2; ++side) {
      const Eigen::Vector3d apex = position(nodes[2 + side]);
      const double at_0 = Cotangent(x0, x1, apex), at_1 = Cotangent(x1, x0, apex);
      weights[0] += at_1;
      weights[1] += at_0;
      weights[2 + side] = -(at_0 + at_1);
      area += 0.5 * (x1 - x0).cross(apex - x0).norm();
    }
    Eigen::MatrixXd block(4, 4);
    for (int i = 0; i < 4; ++i) {
      for (int j = 0; j < 4; ++j) block(i, j) = 3.0 / area * weights[i] * weights[j];
    }
    elements.push_back({{nodes.begin(), nodes.end()}, opposite.faces, std::move(block)});
  }
  return elements;
}

Eigen::SparseMatrix<double> EdgeBendingMatrix(const Mesh& mesh) {
  std::vector<Eigen::Triplet<double>> triplets;
  for (const BendingElement& element : EdgeBendingElements(mesh)) {
    for (int i = 0; i < 4; ++i) {
      for (int j = 0; j < 4; ++j) triplets.emplace_back(element.nodes[i], element.nodes[j], element.block(i, j));
    }
  }
  Eigen::SparseMatrix<double> matrix(mesh.num_nodes(), mesh.num_nodes());
  matrix.setFromTriplets(triplets.begin(), triplets.end());
  return matrix;
}

BendingEnergy::BendingEnergy(Eigen::SparseMatrix<double> matrix, const std::vector<int>& free_index,
                             const BlockPattern& pattern)
    : matrix_(std::move(matrix)), diagonal_(matrix_.diagonal()) {
  for (int node = 0; node < matrix_.outerSize(); ++node) {
    const int column = free_index[node];
    if (column < 0) continue;
    for (Eigen::SparseMatrix<double>::InnerIterator it(matrix_, node); it; ++it) {
      const int row = free_index[it.row()];
      if (row >= 0 && row <= column) continue;
      positions_.push_back(pattern.Find(row < 0 ? column : row, column));
      entries_.push_back(it.value());
    }
  }
}

double BendingEnergy::AddForce(double stiffness, const Eigen::VectorXd& positions, Eigen::VectorXd* force) const {
  double energy = 0.0;
  for (int node = 0; node < matrix_.outerSize(); ++node) {
    Eigen::Vector3d product = Eigen::Vector3d::Zero();  // (Q x) of the node, Q symmetric
    for (Eigen::SparseMatrix<double>::InnerIterator it(matrix_, node); it; ++it) {
      product += it.value() * positions.segment<3>(3 * it.row());
    }
    force->segment<3>(3 * node) -= stiffness * product;
    energy += 0.5 * product.dot(positions.segment<3>(3 * node));
  }
  return energy;
}

void BendingEnergy::AddHessian(double stiffness, BlockMatrix* hessian) const {
  for (size_t i = 0; i < positions_.size(); ++i) {
    double* diagonal = hessian->values.data() + positions_[i].start;
    for (int c = 0; c < 3; ++c) diagonal[c * (positions_[i].stride + 1)] += stiffness * entries_[i];
  }
}

}  // namespace clothid
