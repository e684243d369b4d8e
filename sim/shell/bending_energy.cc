#include "sim/shell/bending_energy.h"

#include <Eigen/Geometry>
#include <array>
#include <map>
#include <utility>
#include <vector>

namespace clothid {
namespace {

// The triangles at an edge and which side of them it is: one at the border, two inside.
struct EdgeSides {
  std::vector<int> faces, sides;
};
using EdgeNeighbours = std::map<std::pair<int, int>, EdgeSides>;  // of edges (low, high)

// But for folds, across which nothing bends.
EdgeNeighbours FindEdges(const Mesh& mesh) {
  EdgeNeighbours edges;
  for (int f = 0; f < mesh.num_faces(); ++f) {
    for (int i = 0; i < 3; ++i) {
      const int a = mesh.faces(i, f), b = mesh.faces((i + 1) % 3, f);
      EdgeSides& edge = edges[std::minmax(a, b)];
      edge.faces.push_back(f);
      edge.sides.push_back(i);
    }
  }
  for (const auto& [low, high] : mesh.folds) edges.erase({low, high});
  return edges;
}

// Cotangent of the angle at `apex` between `a` and `b`.
double Cotangent(const Eigen::Vector3d& apex, const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  return (a - apex).dot(b - apex) / (a - apex).cross(b - apex).norm();
}

}  // namespace

std::vector<BendingElement> EdgeBendingElements(const Mesh& mesh) {
  std::vector<BendingElement> elements;
  for (const auto& [edge, beside] : FindEdges(mesh)) {
    if (beside.faces.size() != 2) continue;
    std::array<int, 4> nodes = {edge.first, edge.second, 0, 0};
    std::array<double, 4> weights = {0.0, 0.0, 0.0, 0.0};
    double area = 0.0;
    for (std::size_t side = 0; side < 2; ++side) {
      const int face = beside.faces[side], first = beside.sides[side], last = (first + 1) % 3, tip = (first + 2) % 3;
      nodes[2 + side] = mesh.faces(tip, face);
      const bool rises = mesh.faces(first, face) == edge.first;
      const Eigen::Vector3d x0 = RestCorner(mesh, face, rises ? first : last);
      const Eigen::Vector3d x1 = RestCorner(mesh, face, rises ? last : first);
      const Eigen::Vector3d apex = RestCorner(mesh, face, tip);
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
    elements.push_back({{nodes.begin(), nodes.end()}, beside.faces, std::move(block)});
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
