#include "datasets/observation/surface_offset.h"

#include <cmath>

#include "sim/geometry/triangle_tree.h"

namespace clothid {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using NodeColumns = SurfaceOffset::NodeColumns;

// g_k in column k, 1/m.
Matrix3d BarycentricGradients(const SearchTriangle& triangle) {
  Matrix3d gradients;
  gradients << -triangle.gradients[0] - triangle.gradients[1], triangle.gradients[0], triangle.gradients[1];
  return gradients;
}

// dn.
NodeColumns NormalGradient(const SearchTriangle& triangle) {
  const Matrix3d gradients = BarycentricGradients(triangle);
  NodeColumns result;
  for (int k = 0; k < 3; ++k) result.middleCols<3>(3 * k) = -gradients.col(k) * triangle.normal.transpose();
  return result;
}

}  // namespace

SurfaceOffset OffsetToFace(const SearchTriangle& triangle, const Vector3d& q) {
  const Vector3d& n = triangle.normal;
  const Matrix3d gradients = BarycentricGradients(triangle);
  const double height = n.dot(q - triangle.corners[0]);
  SurfaceOffset result;
  result.num_nodes = 3;
  result.nodes = {0, 1, 2};
  result.weights = triangle.Barycentric(q);
  result.offset = height * n;
  result.offset_gradient = height * NormalGradient(triangle);
  for (int i = 0; i < 3; ++i) {
    result.offset_gradient.middleCols<3>(3 * i) -= result.weights[i] * n * n.transpose();
    result.weight_gradient.middleCols<3>(3 * i) =
        gradients.transpose() * (height * gradients.col(i) * n.transpose() - result.weights[i] * Matrix3d::Identity());
  }
  return result;
}

SurfaceOffset OffsetToEdge(const Vector3d& start, const Vector3d& end, const Vector3d& q) {
  const Vector3d edge = end - start, from_start = q - start;
  const double squared = edge.squaredNorm(), share = edge.dot(from_start) / squared;
  SurfaceOffset result;
  result.num_nodes = 2;
  result.nodes = {0, 1, 0};
  result.weights << 1.0 - share, share, 0.0;
  result.offset = from_start - share * edge;
  result.weight_gradient.row(1).segment<3>(0) = ((2.0 * share - 1.0) * edge - from_start).transpose() / squared;
  result.weight_gradient.row(1).segment<3>(3) = (from_start - 2.0 * share * edge).transpose() / squared;
  result.weight_gradient.row(0) = -result.weight_gradient.row(1);
  result.offset_gradient = -edge * result.weight_gradient.row(1);
  for (int k = 0; k < 2; ++k) {
    result.offset_gradient.middleCols<3>(3 * k).diagonal().array() -= result.weights[k];
  }
  return result;
}

SurfaceOffset OffsetToVertex(const Vector3d& vertex, const Vector3d& q) {
  SurfaceOffset result;
  result.num_nodes = 1;
  result.weights = Vector3d::UnitX();
  result.offset = q - vertex;
  result.offset_gradient.leftCols<3>() = -Matrix3d::Identity();
  return result;
}

SurfaceOffset OffsetBesideFace(const SearchTriangle& triangle, double allowance, SurfaceOffset to_border) {
  SurfaceOffset result;
  result.num_nodes = 3;
  result.nodes = {0, 1, 2};
  NodeColumns whole = NodeColumns::Zero();  // of q - c
  for (int i = 0; i < to_border.num_nodes; ++i) {
    const int k = to_border.nodes[i];
    result.weights[k] = to_border.weights[i];
    whole.middleCols<3>(3 * k) = to_border.offset_gradient.middleCols<3>(3 * i);
    for (int j = 0; j < to_border.num_nodes; ++j) {
      result.weight_gradient.block<1, 3>(k, 3 * to_border.nodes[j]) = to_border.weight_gradient.block<1, 3>(i, 3 * j);
    }
  }
  const Vector3d& n = triangle.normal;
  const NodeColumns normals = NormalGradient(triangle);
  const double height = n.dot(to_border.offset);
  result.offset = height * n;
  result.offset_gradient =
      height * normals + n * (n.transpose() * whole + to_border.offset.transpose() * normals).eval();
  const Vector3d along = to_border.offset - result.offset;
  const double length = along.norm();
  if (!(length > allowance)) return result;
  const NodeColumns change = whole - result.offset_gradient;
  result.offset += (1.0 - allowance / length) * along;
  result.offset_gradient +=
      (1.0 - allowance / length) * change + allowance / std::pow(length, 3) * along * (along.transpose() * change);
  return result;
}

}  // namespace clothid
