#include "sim/shell/triangle_element.h"

#include <Eigen/Dense>
#include <algorithm>
#include <array>

namespace clothid {
namespace {

// The corners of face `face`, 0 to 2: free nodes first and in their order.
std::array<int, 3> SortedCorners(const Mesh& mesh, const std::vector<int>& free_index, int face) {
  std::array<int, 3> corners = {0, 1, 2};
  const auto order = [&](int corner) {
    const int index = free_index[mesh.faces(corner, face)];
    return index < 0 ? std::numeric_limits<int>::max() : index;
  };
  std::sort(corners.begin(), corners.end(), [&](int a, int b) { return order(a) < order(b); });
  return corners;
}

// The columns of `gradients`, in the axes of `ShapeGradientsOf`, in axes of which the first is `axis`.
Eigen::Matrix2d InAxes(const Eigen::Matrix2d& gradients, const Eigen::Vector3d& axis, const Eigen::Vector3d& e1,
                       const Eigen::Vector3d& e2) {
  const Eigen::Vector3d first = e1.normalized(), second = (e2 - e2.dot(first) * first).normalized();
  const double cosine = axis.dot(first), sine = axis.dot(second);
  return Eigen::Matrix2d{{cosine, sine}, {-sine, cosine}} * gradients;
}

// [g_1 g_2] of a triangle with the edges `e1` and `e2` from its first corner.
Eigen::Matrix2d ShapeGradientsOf(const Eigen::Vector3d& e1, const Eigen::Vector3d& e2) {
  // Rest edges in the triangle's own plane; rows of the inverse are the gradients of nodes 1 and 2.
  const double length = e1.norm();
  Eigen::Matrix2d edges;
  edges << length, e1.dot(e2) / length, 0.0, e1.cross(e2).norm() / length;
  return edges.inverse().transpose();
}

BlockPosition PairPosition(const BlockPattern& pattern, int row, int column) {
  if (column < 0) return {};
  return pattern.Find(row < 0 ? column : row, column);
}

}  // namespace

TriangleElements MakeTriangleElements(const Mesh& mesh, const std::vector<int>& free_index, const BlockPattern& pattern,
                                      const Eigen::Matrix3Xd* first_axes) {
  const int num_batches = (mesh.num_faces() + kLanes - 1) / kLanes;
  const int last_face = mesh.num_faces() - 1;
  TriangleElements triangles(num_batches);
  for (int f = 0; f < num_batches * kLanes; ++f) {
    TriangleBatch& batch = triangles[f / kLanes];
    const int lane = f % kLanes;
    const bool fills = f > last_face;
    const int face = std::min(f, last_face);
    const std::array<int, 3> corners = SortedCorners(mesh, free_index, face);
    const std::array<int, 3> nodes = {mesh.faces(corners[0], face), mesh.faces(corners[1], face),
                                      mesh.faces(corners[2], face)};
    const Eigen::Vector3d origin = RestCorner(mesh, face, corners[0]);
    const Eigen::Vector3d e1 = RestCorner(mesh, face, corners[1]) - origin;
    const Eigen::Vector3d e2 = RestCorner(mesh, face, corners[2]) - origin;
    Eigen::Matrix2d gradients = ShapeGradientsOf(e1, e2);
    if (first_axes != nullptr) gradients = InAxes(gradients, first_axes->col(face), e1, e2);
    batch.area[lane] = fills ? 0.0 : 0.5 * e1.cross(e2).norm();
    for (int i = 0; i < 3; ++i) batch.rows[i][lane] = 3 * nodes[i];
    for (int i = 0; i < 2; ++i) {
      for (int k = 0; k < 2; ++k) batch.shape_gradients[i][k][lane] = gradients(k, i);
    }
    for (int pair = 0; pair < 3 && !fills; ++pair) {
      const int row = free_index[nodes[kCornerPairs[pair][0]]], column = free_index[nodes[kCornerPairs[pair][1]]];
      batch.blocks[pair][lane] = PairPosition(pattern, row, column);
    }
  }
  return triangles;
}

Eigen::SparseMatrix<double> LaplacianMatrix(const TriangleElements& triangles, int num_nodes) {
  std::vector<Eigen::Triplet<double>> triplets;
  for (const TriangleBatch& batch : triangles) {
    for (int lane = 0; lane < kLanes; ++lane) {
      const ShapeGradients g = AllShapeGradients(batch, lane);
      for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 3; ++j) {
          const double product = g.corner[i][0] * g.corner[j][0] + g.corner[i][1] * g.corner[j][1];
          triplets.emplace_back(batch.rows[i][lane] / 3, batch.rows[j][lane] / 3, batch.area[lane] * product);
        }
      }
    }
  }
  Eigen::SparseMatrix<double> matrix(num_nodes, num_nodes);
  matrix.setFromTriplets(triplets.begin(), triplets.end());
  return matrix;
}

Eigen::VectorXd LaplacianDiagonal(const TriangleElements& triangles, int num_nodes) {
  Eigen::VectorXd diagonal = Eigen::VectorXd::Zero(num_nodes);
  for (const TriangleBatch& batch : triangles) {
    for (int lane = 0; lane < kLanes; ++lane) {
      const ShapeGradients g = AllShapeGradients(batch, lane);
      for (int i = 0; i < 3; ++i) {
        const double(&corner)[2] = g.corner[i];
        diagonal[batch.rows[i][lane] / 3] += batch.area[lane] * (corner[0] * corner[0] + corner[1] * corner[1]);
      }
    }
  }
  return diagonal;
}

void GatherCorners(const TriangleBatch& batch, const double* all, CornerVectors* corners) {
  for (int i = 0; i < 3; ++i) {
    for (int lane = 0; lane < kLanes; ++lane) {
      const double* entry = all + batch.rows[i][lane];
      for (int c = 0; c < 3; ++c) corners->values[i][c][lane] = entry[c];
    }
  }
}

void AddCorners(const TriangleBatch& batch, const CornerVectors& corners, double* all) {
  for (int i = 0; i < 3; ++i) {
    for (int lane = 0; lane < kLanes; ++lane) {
      double* entry = all + batch.rows[i][lane];
      for (int c = 0; c < 3; ++c) entry[c] += corners.values[i][c][lane];
    }
  }
}

void AddCornerProducts(const TriangleBatch& batch, const CornerVectors& corners, const Eigen::MatrixXd& columns,
                       Eigen::Index first, Eigen::Ref<Eigen::MatrixXd> products) {
  const int num_lanes = static_cast<int>(std::min<Eigen::Index>(kLanes, products.rows() - first));
  CornerVectors y;
  for (Eigen::Index c = 0; c < columns.cols(); ++c) {
    GatherCorners(batch, columns.col(c).data(), &y);
    for (int i = 0; i < 3; ++i) {
      for (int axis = 0; axis < 3; ++axis) {
        for (int lane = 0; lane < num_lanes; ++lane) {
          products(first + lane, c) += corners.values[i][axis][lane] * y.values[i][axis][lane];
        }
      }
    }
  }
}

bool HasBlocksIn(const TriangleBatch& batch, const BlockColumns& columns) {
  for (const auto& lanes : batch.blocks) {
    for (const BlockPosition& position : lanes) {
      if (columns.have(position)) return true;
    }
  }
  return false;
}

void AddBlocks(const TriangleBatch& batch, const CornerBlocks& blocks, const BlockColumns& columns,
               BlockMatrix* hessian) {
  for (int pair = 0; pair < 3; ++pair) {
    for (int lane = 0; lane < kLanes; ++lane) {
      const BlockPosition position = batch.blocks[pair][lane];
      if (!columns.have(position)) continue;
      double* column = hessian->values.data() + position.start;
      for (int c = 0; c < 3; ++c, column += position.stride) {
        for (int r = 0; r < 3; ++r) column[r] += blocks.values[pair][3 * c + r][lane];
      }
    }
  }
}

}  // namespace clothid
