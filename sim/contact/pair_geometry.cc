#include "sim/contact/pair_geometry.h"

#include <Eigen/LU>

namespace clothid {
namespace {

// w_0 and W of a kind; of W the last columns are zero where it has fewer.
struct WeightMap {
  Eigen::Vector4d constant = Eigen::Vector4d::Zero();                       // w_0
  Eigen::Matrix<double, 4, 2> slope = Eigen::Matrix<double, 4, 2>::Zero();  // W
  int num_unknowns = 0;                                                     // of beta
};

WeightMap WeightsOf(PairKind kind) {
  WeightMap map;
  map.constant << 1.0, -1.0, 0.0, 0.0;
  switch (kind) {
    case PairKind::kVertexVertex:
      break;
    case PairKind::kVertexEdge:
      map.slope.col(0) << 0.0, 1.0, -1.0, 0.0;
      map.num_unknowns = 1;
      break;
    case PairKind::kVertexFace:
      map.slope << 0.0, 0.0, 1.0, 1.0, -1.0, 0.0, 0.0, -1.0;
      map.num_unknowns = 2;
      break;
    case PairKind::kEdgeEdge:
      map.constant << 1.0, 0.0, -1.0, 0.0;
      map.slope << -1.0, 0.0, 1.0, 0.0, 0.0, 1.0, 0.0, -1.0;
      map.num_unknowns = 2;
      break;
  }
  return map;
}

// (T^T T)^-1; zero beyond the unknowns that there are.
Eigen::Matrix2d InverseGram(const Eigen::Matrix<double, 3, 2>& tangents, int num_unknowns) {
  Eigen::Matrix2d inverse = Eigen::Matrix2d::Zero();
  if (num_unknowns == 1) inverse(0, 0) = 1.0 / tangents.col(0).squaredNorm();
  if (num_unknowns == 2) inverse = (tangents.transpose() * tangents).inverse();
  return inverse;
}

// The closest points of a pair.
struct ClosestPoints {
  ClosestPoints(const PairFeatures& pair, const Eigen::VectorXd& positions) : map(WeightsOf(pair.kind)) {
    for (int i = 0; i < pair.num_nodes(); ++i) nodes.col(i) = positions.segment<3>(3 * pair.nodes[i]);
    tangents = nodes * map.slope;
    inverse_gram = InverseGram(tangents, map.num_unknowns);
    weights = map.constant - map.slope * (inverse_gram * (tangents.transpose() * (nodes * map.constant)));
    offset = nodes * weights;
  }

  WeightMap map;
  Eigen::Matrix<double, 3, 4> nodes = Eigen::Matrix<double, 3, 4>::Zero();  // X
  Eigen::Matrix<double, 3, 2> tangents;                                     // T
  Eigen::Matrix2d inverse_gram;
  Eigen::Vector4d weights;  // w
  Eigen::Vector3d offset;   // e
};

}  // namespace

int PairFeatures::num_nodes() const {
  switch (kind) {
    case PairKind::kVertexVertex:
      return 2;
    case PairKind::kVertexEdge:
      return 3;
    case PairKind::kVertexFace:
    case PairKind::kEdgeEdge:
      break;
  }
  return 4;
}

PairGeometry EvaluatePair(const PairFeatures& pair, const Eigen::VectorXd& positions) {
  const ClosestPoints points(pair, positions);
  const double distance = points.offset.norm();
  return {points.weights, points.offset / distance, distance};
}

PairGeometryGradient DifferentiatePair(const PairFeatures& pair, const Eigen::VectorXd& positions) {
  const ClosestPoints points(pair, positions);
  const double distance = points.offset.norm();
  const Eigen::Vector3d normal = points.offset / distance;
  PairGeometryGradient gradient;
  for (int i = 0; i < pair.num_nodes(); ++i) {
    for (int axis = 0; axis < 3; ++axis) {
      const int column = 3 * i + axis;
      // dX has a one in (axis, i) alone.
      const Eigen::Vector2d change = points.map.slope.row(i).transpose() * points.offset[axis] +
                                     points.tangents.row(axis).transpose() * points.weights[i];
      gradient.weights.col(column) = -(points.map.slope * (points.inverse_gram * change));
      Eigen::Vector3d offset_change = points.nodes * gradient.weights.col(column);
      offset_change[axis] += points.weights[i];
      gradient.distance(column) = normal[axis] * points.weights[i];
      gradient.normal.col(column) = (offset_change - normal.dot(offset_change) * normal) / distance;
    }
  }
  return gradient;
}

}  // namespace clothid
