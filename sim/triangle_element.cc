#include "sim/triangle_element.h"

#include <Eigen/Dense>

namespace clothid {

TriangleElements MakeTriangleElements(const Mesh& mesh, const std::vector<int>& free_index,
                                      const BlockPattern& pattern) {
  TriangleElements triangles(mesh.num_faces());
  for (int f = 0; f < mesh.num_faces(); ++f) {
    TriangleElement& triangle = triangles[f];
    for (int i = 0; i < 3; ++i) triangle.nodes[i] = mesh.faces(i, f);
    const Eigen::Vector3d e1 = mesh.rest_positions.col(triangle.nodes[1]) - mesh.rest_positions.col(triangle.nodes[0]);
    const Eigen::Vector3d e2 = mesh.rest_positions.col(triangle.nodes[2]) - mesh.rest_positions.col(triangle.nodes[0]);
    const double doubled_area = e1.cross(e2).norm();
    triangle.area = 0.5 * doubled_area;
    // Rest edges in the triangle's own plane; rows of the inverse are the gradients of nodes 1 and 2.
    const double length = e1.norm();
    Eigen::Matrix2d edges;
    edges << length, e1.dot(e2) / length, 0.0, doubled_area / length;
    const Eigen::Matrix2d inverse = edges.inverse();
    triangle.shape_gradients.col(1) = inverse.row(0).transpose();
    triangle.shape_gradients.col(2) = inverse.row(1).transpose();
    triangle.shape_gradients.col(0) = -triangle.shape_gradients.col(1) - triangle.shape_gradients.col(2);
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) {
        const int row = free_index[triangle.nodes[i]], column = free_index[triangle.nodes[j]];
        if (row >= 0 && column >= 0) triangle.blocks[i][j] = pattern.Find(row, column);
      }
    }
  }
  return triangles;
}

Eigen::VectorXd LaplacianDiagonal(const TriangleElements& triangles, int num_nodes) {
  Eigen::VectorXd diagonal = Eigen::VectorXd::Zero(num_nodes);
  for (const TriangleElement& triangle : triangles) {
    for (int i = 0; i < 3; ++i) {
      diagonal[triangle.nodes[i]] += triangle.area * triangle.shape_gradients.col(i).squaredNorm();
    }
  }
  return diagonal;
}

}  // namespace clothid
