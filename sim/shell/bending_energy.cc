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

namespace {

// The weights of a triangle in the angle at an edge of it, of the edge's nodes and of its apex.
struct HingeSide {
  double first, last, apex;
  double area;
};

HingeSide SideOf(const Eigen::Vector3d& first, const Eigen::Vector3d& last, const Eigen::Vector3d& apex) {
  const double at_first = Cotangent(first, last, apex), at_last = Cotangent(last, first, apex);
  return {at_last, at_first, -(at_first + at_last), 0.5 * (last - first).cross(apex - first).norm()};
}

// Of the edge `side` of a triangle, which leaves it along `sign` times the slope with that number. The apex of the
// mirrored triangle is x_apex' = (1 - s) x_start + s x_end - height d, so that the weights of the nodes are those of
// the triangle and of what it has mirrored.
BendingElement ClampedElement(const Mesh& mesh, int face, int side, int slope, double sign) {
  const Eigen::Vector3d start = RestCorner(mesh, face, side), end = RestCorner(mesh, face, (side + 1) % 3);
  const Eigen::Vector3d apex = RestCorner(mesh, face, (side + 2) % 3), along = end - start;
  const double share = (apex - start).dot(along) / along.squaredNorm();
  const HingeSide own = SideOf(start, end, apex);
  const Eigen::Vector4d weights(2.0 * own.first + (1.0 - share) * own.apex, 2.0 * own.last + share * own.apex, own.apex,
                                -sign * own.apex * 2.0 * own.area / along.norm());
  return {{mesh.faces(side, face), mesh.faces((side + 1) % 3, face), mesh.faces((side + 2) % 3, face)},
          {face},
          {slope},
          3.0 / own.area * weights * weights.transpose()};
}

}  // namespace

std::vector<BendingElement> EdgeBendingElements(const Mesh& mesh, const std::vector<ClampedEdge>& clamped) {
  std::vector<BendingElement> elements;
  EdgeNeighbours edges = FindEdges(mesh);
  for (std::size_t i = 0; i < clamped.size(); ++i) {
    const auto found = edges.find(std::minmax(clamped[i].nodes[0], clamped[i].nodes[1]));
    if (found == edges.end()) continue;
    for (std::size_t k = 0; k < found->second.faces.size(); ++k) {
      const int face = found->second.faces[k];
      elements.push_back(ClampedElement(mesh, face, found->second.sides[k], static_cast<int>(i),
                                        face == clamped[i].face ? 1.0 : -1.0));
    }
    edges.erase(found);
  }
  for (const auto& [edge, beside] : edges) {
    if (beside.faces.size() != 2) continue;
    std::array<int, 4> nodes = {edge.first, edge.second, 0, 0};
    std::array<double, 4> weights = {0.0, 0.0, 0.0, 0.0};
    double area = 0.0;
    for (std::size_t k = 0; k < 2; ++k) {
      const int face = beside.faces[k], side = beside.sides[k];
      nodes[2 + k] = mesh.faces((side + 2) % 3, face);
      const int next = (side + 1) % 3;
      const bool rises = mesh.faces(side, face) == edge.first;
      const HingeSide own = SideOf(RestCorner(mesh, face, rises ? side : next),
                                   RestCorner(mesh, face, rises ? next : side), RestCorner(mesh, face, (side + 2) % 3));
      weights[0] += own.first;
      weights[1] += own.last;
      weights[2 + k] = own.apex;
      area += own.area;
    }
    Eigen::MatrixXd block(4, 4);
    for (int i = 0; i < 4; ++i) {
      for (int j = 0; j < 4; ++j) block(i, j) = 3.0 / area * weights[i] * weights[j];
    }
    elements.push_back({{nodes.begin(), nodes.end()}, beside.faces, {}, std::move(block)});
  }
  return elements;
}

Eigen::SparseMatrix<double> EdgeBendingMatrix(const Mesh& mesh, const std::vector<ClampedEdge>& clamped) {
  std::vector<Eigen::Triplet<double>> triplets;
  for (const BendingElement& element : EdgeBendingElements(mesh, clamped)) {
    const auto num_nodes = static_cast<Eigen::Index>(element.nodes.size());
    for (Eigen::Index i = 0; i < num_nodes; ++i) {
      for (Eigen::Index j = 0; j < num_nodes; ++j) {
        triplets.emplace_back(element.nodes[static_cast<std::size_t>(i)], element.nodes[static_cast<std::size_t>(j)],
                              element.block(i, j));
      }
    }
  }
  Eigen::SparseMatrix<double> matrix(mesh.num_nodes(), mesh.num_nodes());
  matrix.setFromTriplets(triplets.begin(), triplets.end());
  return matrix;
}

SlopeBending SumOfSlopes(const std::vector<BendingElement>& elements, int num_nodes, int num_slopes,
                         const std::function<double(const BendingElement& element)>& weight) {
  std::vector<Eigen::Triplet<double>> by_nodes, own;
  for (const BendingElement& element : elements) {
    const auto first = static_cast<Eigen::Index>(element.nodes.size());
    for (std::size_t k = 0; k < element.slopes.size(); ++k) {
      const auto column = (weight(element) * element.block.col(first + static_cast<Eigen::Index>(k))).eval();
      for (std::size_t i = 0; i < element.nodes.size(); ++i) {
        by_nodes.emplace_back(element.nodes[i], element.slopes[k], column[static_cast<Eigen::Index>(i)]);
      }
      for (std::size_t i = 0; i < element.slopes.size(); ++i) {
        own.emplace_back(element.slopes[i], element.slopes[k], column[first + static_cast<Eigen::Index>(i)]);
      }
    }
  }
  SlopeBending sum{Eigen::SparseMatrix<double>(num_nodes, num_slopes),
                   Eigen::SparseMatrix<double>(num_slopes, num_slopes)};
  sum.by_nodes.setFromTriplets(by_nodes.begin(), by_nodes.end());
  sum.own.setFromTriplets(own.begin(), own.end());
  return sum;
}

double SlopeBending::AddForce(double stiffness, const Eigen::VectorXd& positions, const Eigen::VectorXd& slopes,
                              Eigen::VectorXd* force) const {
  const auto d = slopes.reshaped(3, own.cols()), x = positions.reshaped(3, by_nodes.rows());
  const Eigen::Matrix3Xd on_nodes = d * by_nodes.transpose(), on_slopes = d * own;
  force->reshaped(3, by_nodes.rows()) -= stiffness * on_nodes;
  return on_nodes.cwiseProduct(x).sum() + 0.5 * on_slopes.cwiseProduct(d).sum();
}

void SlopeBending::AddSlopeForce(double stiffness, const Eigen::VectorXd& positions, const Eigen::VectorXd& slopes,
                                 Eigen::VectorXd* moment) const {
  const auto d = slopes.reshaped(3, own.cols()), x = positions.reshaped(3, by_nodes.rows());
  moment->reshaped(3, own.cols()) -= stiffness * (x * by_nodes + d * own);
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

void BendingEnergy::AddHessian(double stiffness, BlockMatrix* hessian, ThreadTeam* team) const {
  ForColumns(hessian->pattern(), team, [&](const BlockColumns& columns) {
    for (size_t i = 0; i < positions_.size(); ++i) {
      if (!columns.have(positions_[i])) continue;
      double* diagonal = hessian->values.data() + positions_[i].start;
      for (int c = 0; c < 3; ++c) diagonal[c * (positions_[i].stride + 1)] += stiffness * entries_[i];
    }
  });
}

}  // namespace clothid
