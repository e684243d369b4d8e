// Distances to an open cloth against all of its triangles, and their derivatives against finite differences.
#include "datasets/observation/cloth_surface.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <random>
#include <string>
#include <vector>

#include "sim/mesh/mesh.h"

namespace clothid::cloth_surface_test {
namespace {

using Eigen::Vector3d;
using Eigen::VectorXd;

Mesh SheetMesh() {
  GridOptions grid;
  grid.nodes = {6, 5};
  grid.size = {1.0, 0.8};
  return MakeGrid(grid);
}

// A crumpled sheet: its inner edges and vertices are convex, concave and saddles.
VectorXd Crumpled(const Mesh& mesh) {
  std::mt19937 generator(3);
  std::uniform_real_distribution<double> uniform(-0.07, 0.07);
  VectorXd nodes = mesh.rest_positions.reshaped();
  for (double& coordinate : nodes) coordinate += uniform(generator);
  return nodes;
}

std::vector<Vector3d> PointsAround(int count) {
  std::mt19937 generator(5);
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  std::vector<Vector3d> points(count);
  for (Vector3d& q : points) {
    q << 1.4 * uniform(generator) - 0.2, 1.2 * uniform(generator) - 0.2, 0.6 * uniform(generator) - 0.3;
  }
  return points;
}

double DistanceToSegment(const Vector3d& q, const Vector3d& from, const Vector3d& to) {
  const double along = std::clamp((q - from).dot(to - from) / (to - from).squaredNorm(), 0.0, 1.0);
  return (q - from - along * (to - from)).norm();
}

double DistanceToTriangle(const Vector3d& q, const Vector3d& a, const Vector3d& b, const Vector3d& c) {
  const Vector3d normal = (b - a).cross(c - a).normalized();
  const bool is_above = normal.dot((b - a).cross(q - a)) > 0.0 && normal.dot((c - b).cross(q - b)) > 0.0 &&
                        normal.dot((a - c).cross(q - c)) > 0.0;
  if (is_above) return std::abs(normal.dot(q - a));
  return std::min({DistanceToSegment(q, a, b), DistanceToSegment(q, b, c), DistanceToSegment(q, c, a)});
}

double DistanceToAll(const Vector3d& q, const Mesh& mesh, const VectorXd& nodes) {
  const auto corner = [&](int k, int face) -> Vector3d { return nodes.segment<3>(3 * mesh.faces(k, face)); };
  double distance = std::numeric_limits<double>::infinity();
  for (int f = 0; f < mesh.num_faces(); ++f) {
    distance = std::min(distance, DistanceToTriangle(q, corner(0, f), corner(1, f), corner(2, f)));
  }
  return distance;
}

TEST(ClothSurfaceTest, DistanceIsThatToTheNearestTriangle) {
  const Mesh mesh = SheetMesh();
  const VectorXd nodes = Crumpled(mesh);
  const ClothSurface surface(ClothTopology(mesh.faces, mesh.num_nodes()), nodes);
  for (const Vector3d& q : PointsAround(2000)) {
    const SurfaceDistance found = surface.Measure(q, 0.0);
    EXPECT_NEAR(std::abs(found.distance), DistanceToAll(q, mesh, nodes), 1e-12);
    EXPECT_NEAR((q - found.closest).norm(), std::abs(found.distance), 1e-12);
    Vector3d closest = Vector3d::Zero();
    for (int k = 0; k < found.num_nodes; ++k) closest += found.weights[k] * nodes.segment<3>(3 * found.nodes[k]);
    EXPECT_LT((closest - found.closest).norm(), 1e-12);
    EXPECT_NEAR(found.weights.sum(), 1.0, 1e-12);
  }
}

// Faces, inner edges and vertices, borders; within and beyond the allowance.
TEST(ClothSurfaceTest, DerivativeIsThatOfFiniteDifferences) {
  const Mesh mesh = SheetMesh();
  const ClothTopology topology(mesh.faces, mesh.num_nodes());
  const VectorXd nodes = Crumpled(mesh);
  const double step = 1e-6;
  std::mt19937 generator(9);
  std::normal_distribution<double> normal(0.0, 1.0);
  std::map<std::string, int> num_checked;
  for (const double allowance : {0.0, 0.05}) {
    for (const Vector3d& q : PointsAround(1500)) {
      VectorXd direction(nodes.size());
      for (double& coordinate : direction) coordinate = normal(generator);
      const SurfaceDistance at = ClothSurface(topology, nodes).Measure(q, allowance),
                            above = ClothSurface(topology, nodes + step * direction).Measure(q, allowance),
                            below = ClothSurface(topology, nodes - step * direction).Measure(q, allowance);
      if (above.nodes != at.nodes || below.nodes != at.nodes || above.num_nodes != at.num_nodes) continue;
      double derivative = 0.0;
      for (int k = 0; k < at.num_nodes; ++k) {
        derivative += at.gradient.col(k).dot(direction.segment<3>(3 * at.nodes[k]));
      }
      EXPECT_NEAR(derivative, (above.distance - below.distance) / (2.0 * step), 1e-6 * direction.norm())
          << q.transpose();
      const bool is_beyond = std::abs((q - at.closest).norm() - std::abs(at.distance)) > 1e-9;
      const bool is_border = at.num_nodes == 3 && at.weights.minCoeff() == 0.0;
      ++num_checked[std::to_string(at.num_nodes) + (is_border ? " at a border" : "") +
                    (is_beyond ? ", less the allowance" : "")];
    }
  }
  for (const char* kind : {"1", "2", "3", "3 at a border", "3 at a border, less the allowance"}) {
    EXPECT_GT(num_checked[kind], 10) << kind;
  }
}

// Columns: what `offset` and `weights` change along `direction` of all nodes.
Eigen::Matrix<double, 3, 2> ChangeOf(const SurfaceOffset& at, const VectorXd& direction) {
  Eigen::Matrix<double, 3, 2> change = Eigen::Matrix<double, 3, 2>::Zero();
  for (int k = 0; k < at.num_nodes; ++k) {
    const Vector3d own = direction.segment<3>(3 * at.nodes[k]);
    change.col(0) += at.offset_gradient.middleCols<3>(3 * k) * own;
    change.col(1) += at.weight_gradient.middleCols<3>(3 * k) * own;
  }
  return change;
}

// Faces, inner edges and vertices, borders within and beyond the allowance; and the border itself.
TEST(ClothSurfaceTest, OffsetsAreDistancesAndHaveTheirDerivatives) {
  const Mesh mesh = SheetMesh();
  const ClothTopology topology(mesh.faces, mesh.num_nodes());
  const VectorXd nodes = Crumpled(mesh);
  const double step = 1e-6;
  std::mt19937 generator(9);
  std::normal_distribution<double> normal(0.0, 1.0);
  std::map<std::string, int> num_checked;
  for (const double allowance : {0.0, 0.05, -1.0}) {
    for (const Vector3d& q : PointsAround(1500)) {
      VectorXd direction(nodes.size());
      for (double& coordinate : direction) coordinate = normal(generator);
      const auto offset_at = [&](const VectorXd& places) {
        const ClothSurface surface(topology, places);
        return allowance < 0.0 ? surface.OffsetToBorder(q) : surface.Offset(q, allowance);
      };
      const SurfaceOffset at = offset_at(nodes), above = offset_at(nodes + step * direction),
                          below = offset_at(nodes - step * direction);
      const ClothSurface surface(topology, nodes);
      if (allowance >= 0.0) {
        EXPECT_NEAR(at.offset.norm(), std::abs(surface.Measure(q, allowance).distance), 1e-12);
      } else {
        EXPECT_NEAR((q - at.offset - surface.MeasureToBorder(q).closest).norm(), 0.0, 1e-12);
      }
      EXPECT_NEAR(at.weights.sum(), 1.0, 1e-12);
      const bool is_vertex = at.weights.maxCoeff() == 1.0;
      if (above.nodes != at.nodes || below.nodes != at.nodes || above.num_nodes != at.num_nodes ||
          below.num_nodes != at.num_nodes || is_vertex != (above.weights.maxCoeff() == 1.0) ||
          is_vertex != (below.weights.maxCoeff() == 1.0)) {
        continue;
      }
      const Eigen::Matrix<double, 3, 2> change = ChangeOf(at, direction);
      const double scale = 1e-6 * direction.norm();
      EXPECT_LT((change.col(0) - (above.offset - below.offset) / (2.0 * step)).norm(), scale) << q.transpose();
      EXPECT_LT((change.col(1) - (above.weights - below.weights) / (2.0 * step)).norm(), 10.0 * scale) << q.transpose();
      const bool is_beside = allowance >= 0.0 && at.num_nodes == 3 && at.weights.minCoeff() == 0.0;
      const bool is_far = (q - surface.Measure(q, 0.0).closest).norm() > at.offset.norm() + 1e-9;
      ++num_checked[(allowance < 0.0 ? "to the border " : "") + std::to_string(at.num_nodes) +
                    (is_beside ? " beside" : "") + (is_beside && is_far ? ", allowed" : "")];
    }
  }
  for (const char* kind : {"1", "2", "3", "3 beside", "3 beside, allowed", "to the border 1", "to the border 2"}) {
    EXPECT_GT(num_checked[kind], 10) << kind;
  }
}

// Above a dome, where no two parts of the cloth are equally near, and beyond its border.
TEST(ClothSurfaceTest, OffsetsAreContinuous) {
  const Mesh mesh = SheetMesh();
  VectorXd nodes = mesh.rest_positions.reshaped();
  for (int i = 0; i < mesh.num_nodes(); ++i) nodes[3 * i + 2] -= 0.3 * nodes.segment<2>(3 * i).squaredNorm();
  const ClothSurface surface(ClothTopology(mesh.faces, mesh.num_nodes()), nodes);
  const auto foot = [&](const SurfaceOffset& at) {
    Vector3d sum = Vector3d::Zero();
    for (int k = 0; k < at.num_nodes; ++k) sum += at.weights[k] * nodes.segment<3>(3 * at.nodes[k]);
    return sum;
  };
  const double step = 1e-5;
  SurfaceOffset last = surface.Offset({0.5, 0.6, 0.02}, 0.05);
  for (double y = 0.6; y > -0.3; y -= step) {
    const SurfaceOffset at = surface.Offset({0.5, y, 0.02}, 0.05);
    EXPECT_LT((at.offset - last.offset).norm(), 3.0 * step) << y;
    EXPECT_LT((foot(at) - foot(last)).norm(), 3.0 * step) << y;
    last = at;
  }
}

TEST(ClothSurfaceTest, SidesAndBordersOfAFlatSheet) {
  const Mesh mesh = SheetMesh();
  const ClothSurface surface(ClothTopology(mesh.faces, mesh.num_nodes()), mesh.rest_positions.reshaped());
  const double allowance = 0.05;
  EXPECT_NEAR(surface.Measure({0.43, 0.31, 0.02}, allowance).distance, 0.02, 1e-15);
  EXPECT_NEAR(surface.Measure({0.43, 0.31, -0.02}, allowance).distance, -0.02, 1e-15);
  EXPECT_NEAR(surface.Measure({0.43, -0.04, -0.02}, allowance).distance, -0.02, 1e-15);
  EXPECT_NEAR(surface.Measure({0.43, -0.08, -0.04}, allowance).distance, -0.05, 1e-15);
  EXPECT_NEAR(surface.Measure({1.04, 0.83, 0.0}, 0.0).distance, 0.05, 1e-15);
  EXPECT_NEAR(surface.Measure({1.04, 0.83, 0.0}, allowance).distance, 0.0, 1e-15);
  // Above nodes and on them.
  EXPECT_NEAR(surface.Measure({0.2, 0.2, 0.03}, allowance).distance, 0.03, 1e-15);
  const SurfaceDistance on = surface.Measure({0.2, 0.2, 0.0}, allowance);
  EXPECT_EQ(on.distance, 0.0);
  EXPECT_NEAR(on.gradient.rowwise().sum().z(), -1.0, 1e-15);
}

// Of points about the border, inside and outside, at its edges and corners, on both sides of the cloth.
TEST(ClothSurfaceTest, DistanceToTheBorderHasItsDerivative) {
  const Mesh mesh = SheetMesh();
  const ClothTopology topology(mesh.faces, mesh.num_nodes());
  ASSERT_TRUE(topology.has_border());
  const VectorXd nodes = Crumpled(mesh);
  const double step = 1e-6;
  std::mt19937 generator(9);
  std::normal_distribution<double> normal(0.0, 1.0);
  std::map<std::string, int> num_checked;
  for (const Vector3d& q : PointsAround(1500)) {
    VectorXd direction(nodes.size());
    for (double& coordinate : direction) coordinate = normal(generator);
    const SurfaceDistance at = ClothSurface(topology, nodes).MeasureToBorder(q),
                          above = ClothSurface(topology, nodes + step * direction).MeasureToBorder(q),
                          below = ClothSurface(topology, nodes - step * direction).MeasureToBorder(q);
    if (above.nodes != at.nodes || below.nodes != at.nodes || at.distance * above.distance * below.distance == 0.0) {
      continue;
    }
    const bool is_vertex = at.weights.maxCoeff() == 1.0;
    if (is_vertex != (above.weights.maxCoeff() == 1.0) || is_vertex != (below.weights.maxCoeff() == 1.0)) continue;
    double derivative = 0.0;
    for (int k = 0; k < 3; ++k) derivative += at.gradient.col(k).dot(direction.segment<3>(3 * at.nodes[k]));
    EXPECT_NEAR(derivative, (above.distance - below.distance) / (2.0 * step), 1e-6 * direction.norm()) << q.transpose();
    ++num_checked[std::string(is_vertex ? "vertex" : "edge") + (at.distance > 0.0 ? ", beyond" : ", within")];
  }
  for (const char* kind : {"vertex, beyond", "edge, beyond", "edge, within"}) EXPECT_GT(num_checked[kind], 10) << kind;
}

TEST(ClothSurfaceTest, DistanceToTheBorderIsAlongTheCloth) {
  const Mesh mesh = SheetMesh();
  const ClothSurface surface(ClothTopology(mesh.faces, mesh.num_nodes()), mesh.rest_positions.reshaped());
  EXPECT_NEAR(surface.MeasureToBorder({0.43, -0.02, 0.1}).distance, 0.02, 1e-15);
  EXPECT_NEAR(surface.MeasureToBorder({0.43, 0.02, -0.1}).distance, -0.02, 1e-15);
  EXPECT_NEAR(surface.MeasureToBorder({1.03, 0.84, 0.2}).distance, 0.05, 1e-15);  // at a corner
  const SurfaceDistance above = surface.MeasureToBorder({0.4, 0.0, 0.03});        // above a node
  EXPECT_NEAR(above.distance, 0.0, 1e-15);
  EXPECT_TRUE(above.gradient.allFinite());
  EXPECT_NEAR(above.gradient.rowwise().sum().y(), 1.0, 1e-12);
  // A closed mesh has none.
  Eigen::Matrix3Xi tetrahedron(3, 4);
  tetrahedron << 0, 0, 0, 1, 1, 2, 3, 2, 2, 3, 1, 3;
  EXPECT_FALSE(ClothTopology(tetrahedron, 4).has_border());
}

TEST(ClothSurfaceTest, DistanceIsContinuousAcrossBorderAndAllowance) {
  const Mesh mesh = SheetMesh();
  const ClothSurface surface(ClothTopology(mesh.faces, mesh.num_nodes()), Crumpled(mesh));
  const double step = 1e-5;
  double last = surface.Measure({0.5, 0.4, 0.3}, 0.05).distance;
  for (double y = 0.4; y > -0.3; y -= step) {
    const double distance = surface.Measure({0.5, y, 0.3}, 0.05).distance;
    EXPECT_LT(std::abs(distance - last), 1.5 * step) << y;
    last = distance;
  }
}

}  // namespace
}  // namespace clothid::cloth_surface_test
