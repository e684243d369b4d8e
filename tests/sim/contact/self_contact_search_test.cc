#include "sim/contact/self_contact_search.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <set>
#include <utility>
#include <vector>

#include "tests/sim/contact/stacked_sheets.h"
#include "tests/sim/property_seeds.h"
#include "tests/sim/random_numbers.h"
#include "tests/sim/sheet_meshes.h"

namespace clothid::self_contact_search_test {
namespace {

using Eigen::Vector3d;

constexpr double kShare = 1e-6;  // of an edge or face, from which on a point is inside

// All features against all, with the definitions of the header taken literally.
class BruteForce {
 public:
  BruteForce(const Mesh& mesh, double thickness, const Eigen::VectorXd& positions, const Eigen::VectorXd& velocities,
             double gap_time, double further_reach)
      : mesh_(mesh),
        x_(positions.reshaped(3, mesh.num_nodes())),
        reach_(1.25 * thickness + further_reach),
        node_reach_(gap_time * velocities.reshaped(3, mesh.num_nodes()).colwise().norm().transpose()) {
    for (int f = 0; f < mesh.num_faces(); ++f) {
      for (int k = 0; k < 3; ++k) edges_.insert(Ascending(std::array{mesh.faces(k, f), mesh.faces((k + 1) % 3, f)}));
    }
    FindNeighbours(thickness);
  }

  std::vector<PairFeatures> Find() {
    for (int p = 0; p < mesh_.num_nodes(); ++p) {
      for (int f = 0; f < mesh_.num_faces(); ++f) TestFace(p, f);
      for (const std::array<int, 2>& edge : edges_) TestSide(p, edge);
      for (int q = 0; q < mesh_.num_nodes(); ++q) TestVertices(p, q);
    }
    for (const std::array<int, 2>& first : edges_) {
      for (const std::array<int, 2>& second : edges_) {
        if (first < second) TestEdges(first, second);
      }
    }
    return {pairs_.begin(), pairs_.end()};
  }

 private:
  template <class Nodes>
  static Nodes Ascending(Nodes nodes) {
    std::sort(nodes.begin(), nodes.end());
    return nodes;
  }

  // Ways at rest by Floyd and Warshall.
  void FindNeighbours(double thickness) {
    const int size = mesh_.num_nodes();
    Eigen::MatrixXd ways = Eigen::MatrixXd::Constant(size, size, 1e9);
    ways.diagonal().setZero();
    const auto join = [&](int a, int b, double length) { ways(a, b) = ways(b, a) = std::min(ways(a, b), length); };
    for (int f = 0; f < mesh_.num_faces(); ++f) {
      for (int k = 0; k < 3; ++k) join(mesh_.faces(k, f), mesh_.faces((k + 1) % 3, f), RestLength(mesh_, f, k));
    }
    for (const SeamLink& link : mesh_.links) {
      for (const int end : link.edge) join(link.node, end, 0.0);
    }
    for (int k = 0; k < size; ++k) {
      for (int i = 0; i < size; ++i) {
        for (int j = 0; j < size; ++j) ways(i, j) = std::min(ways(i, j), ways(i, k) + ways(k, j));
      }
    }
    for (int i = 0; i < size; ++i) {
      for (int j = 0; j < size; ++j) {
        if (ways(i, j) < 2.0 * thickness) joined_.insert({i, j});
      }
    }
  }

  void Add(const std::vector<int>& first, const std::vector<int>& second, double distance, const PairFeatures& pair) {
    double most = 0.0, most_of_second = 0.0;
    for (const int node : first) most = std::max(most, node_reach_[node]);
    for (const int node : second) most_of_second = std::max(most_of_second, node_reach_[node]);
    if (distance == 0.0 || distance > reach_ + most + most_of_second) return;
    for (const int i : first) {
      for (const int j : second) {
        if (joined_.count({i, j}) > 0) return;
      }
    }
    pairs_.insert(pair);
  }

  // The point of a face that is nearest to x, by its plane or else its sides.
  double DistanceToFace(const Vector3d& x, int face) const {
    const Vector3d weights = Barycentric(x, face);
    if (weights.minCoeff() >= 0.0) return (x_(Eigen::all, mesh_.faces.col(face)) * weights - x).norm();
    double least = 1e9;
    for (int k = 0; k < 3; ++k) {
      const Vector3d from = x_.col(mesh_.faces(k, face)), along = x_.col(mesh_.faces((k + 1) % 3, face)) - from;
      const double share = std::clamp((x - from).dot(along) / along.squaredNorm(), 0.0, 1.0);
      least = std::min(least, (from + share * along - x).norm());
    }
    return least;
  }

  // The shares of two vectors that come nearest to `x`.
  static Eigen::Vector2d Shares(const Eigen::Matrix<double, 3, 2>& vectors, const Vector3d& x) {
    const Eigen::Matrix2d gram = vectors.transpose() * vectors;
    return gram.inverse() * (vectors.transpose() * x);
  }

  Vector3d Barycentric(const Vector3d& x, int face) const {
    Eigen::Matrix<double, 3, 2> sides;
    for (int k = 0; k < 2; ++k) sides.col(k) = x_.col(mesh_.faces(k + 1, face)) - x_.col(mesh_.faces(0, face));
    const Eigen::Vector2d shares = Shares(sides, x - x_.col(mesh_.faces(0, face)));
    return {1.0 - shares.sum(), shares[0], shares[1]};
  }

  bool Has(int face, int node) const { return (mesh_.faces.col(face).array() == node).any(); }

  // Whether a face that has all of `nodes` has a point nearer to x than `distance`.
  template <class Nodes>
  bool IsNearerInFaceOf(const Nodes& nodes, const Vector3d& x, double distance) const {
    for (int f = 0; f < mesh_.num_faces(); ++f) {
      const bool is_around = std::all_of(nodes.begin(), nodes.end(), [&](int node) { return Has(f, node); });
      if (is_around && DistanceToFace(x, f) < distance * (1.0 - 1e-13)) return true;
    }
    return false;
  }

  void TestFace(int p, int face) {
    const Vector3d weights = Barycentric(x_.col(p), face);
    if (weights.minCoeff() <= kShare) return;
    const std::array<int, 3> nodes =
        Ascending(std::array{mesh_.faces(0, face), mesh_.faces(1, face), mesh_.faces(2, face)});
    const double distance = (x_.col(p) - x_(Eigen::all, mesh_.faces.col(face)) * weights).norm();
    Add({p}, {nodes.begin(), nodes.end()}, distance, {PairKind::kVertexFace, {p, nodes[0], nodes[1], nodes[2]}});
  }

  void TestSide(int p, const std::array<int, 2>& edge) {
    const Vector3d x = x_.col(p), along = x_.col(edge[1]) - x_.col(edge[0]);
    const double share = (x - x_.col(edge[0])).dot(along) / along.squaredNorm();
    const double distance = (x - x_.col(edge[0]) - share * along).norm();
    if (share <= kShare || share >= 1.0 - kShare || IsNearerInFaceOf(edge, x, distance)) return;
    Add({p}, {edge[0], edge[1]}, distance, {PairKind::kVertexEdge, {p, edge[0], edge[1], -1}});
  }

  void TestVertices(int p, int q) {
    const double distance = (x_.col(p) - x_.col(q)).norm();
    if (IsNearerInFaceOf(std::array{q}, x_.col(p), distance)) return;
    Add({p}, {q}, distance, {PairKind::kVertexVertex, {std::min(p, q), std::max(p, q), -1, -1}});
  }

  // From the middle of an edge into the faces beside it.
  std::vector<std::pair<int, Vector3d>> Inward(const std::array<int, 2>& edge) const {
    const Vector3d along = (x_.col(edge[1]) - x_.col(edge[0])).normalized();
    std::vector<std::pair<int, Vector3d>> inward;
    for (int f = 0; f < mesh_.num_faces(); ++f) {
      if (!Has(f, edge[0]) || !Has(f, edge[1])) continue;
      Vector3d into = x_(Eigen::all, mesh_.faces.col(f)).rowwise().mean() - x_.col(edge[0]);
      into -= into.dot(along) * along;
      inward.emplace_back(f, into.normalized());
    }
    return inward;
  }

  static double Angle(const Vector3d& a, const Vector3d& b) { return std::acos(std::clamp(a.dot(b), -1.0, 1.0)); }

  // By how much the angles of `direction` with the faces of an edge are beyond a right one, rad.
  double ConeMargin(const std::array<int, 2>& edge, const Vector3d& direction, const std::array<int, 2>& other) const {
    double margin = 0.5 * M_PI;
    for (const auto& [face, inward] : Inward(edge)) {
      const bool is_joined = Has(face, other[0]) || Has(face, other[1]);
      margin = std::min(margin, Angle(inward, direction.normalized()) - 0.5 * M_PI + (is_joined ? 0.1 : 0.0));
    }
    return margin;
  }

  double ConeWidth(const std::array<int, 2>& edge) const {
    const auto inward = Inward(edge);
    return inward.size() < 2 ? M_PI : M_PI - Angle(inward[0].second, inward[1].second);
  }

  void TestEdges(const std::array<int, 2>& first, const std::array<int, 2>& second) {
    Eigen::Matrix<double, 3, 2> sides;
    sides << x_.col(first[1]) - x_.col(first[0]), x_.col(second[0]) - x_.col(second[1]);
    if (sides.col(0).normalized().cross(sides.col(1).normalized()).squaredNorm() <= 1e-4) return;
    const Eigen::Vector2d shares = Shares(sides, x_.col(second[0]) - x_.col(first[0]));
    if (shares.minCoeff() <= kShare || shares.maxCoeff() >= 1.0 - kShare) return;
    const Vector3d offset = x_.col(first[0]) + sides * shares - x_.col(second[0]);
    const double margin = ConeMargin(first, -offset, second), other_margin = ConeMargin(second, offset, first);
    if (std::min(margin, other_margin) <= 1e-3 || std::max(margin, other_margin) <= 0.05) return;
    const double width = ConeWidth(first), other_width = ConeWidth(second);
    if (std::min(width, other_width) < 1.99e-3 || std::max(width, other_width) < 0.0995) return;
    Add({first[0], first[1]}, {second[0], second[1]}, offset.norm(),
        {PairKind::kEdgeEdge, {first[0], first[1], second[0], second[1]}});
  }

  const Mesh& mesh_;
  Eigen::Matrix3Xd x_;
  double reach_;
  Eigen::VectorXd node_reach_;
  std::set<std::array<int, 2>> edges_, joined_;
  std::set<PairFeatures> pairs_;
};

int CountKind(const std::vector<PairFeatures>& pairs, PairKind kind) {
  return static_cast<int>(
      std::count_if(pairs.begin(), pairs.end(), [kind](const PairFeatures& pair) { return pair.kind == kind; }));
}

std::vector<PairFeatures> FindAtRest(const Mesh& mesh, double thickness, const Eigen::VectorXd& positions) {
  std::vector<PairFeatures> pairs;
  SelfContactSearch(mesh, thickness).Find(positions, Eigen::VectorXd::Zero(positions.size()), 0.01, 0.0, &pairs);
  return pairs;
}

TEST(SelfContactSearch, FindsTheLocalMinimaOfAllFeatures) {
  std::array<int, 4> num_of_kind = {0, 0, 0, 0};
  for (const std::uint64_t seed : PropertySeeds(12)) {
    RandomNumbers random(seed);
    GridOptions grid;
    grid.nodes = {random.Integer(3, 8), random.Integer(3, 8)};
    Mesh mesh = MakeSheet(kSheetKinds[seed % 4], grid);
    for (int i = random.Integer(0, 2); i > 0; --i) {
      const int face = random.Integer(0, mesh.num_faces() - 1);
      mesh.links.push_back({random.Integer(0, mesh.num_nodes() - 1), {mesh.faces(0, face), mesh.faces(1, face)}});
    }
    const double thickness = random.Uniform(0.005, 0.06), reach = random.Uniform(0.0, 0.1);
    SelfContactSearch search(mesh, thickness);
    for (int trial = 0; trial < 3; ++trial) {
      // From a wavy sheet to one that is crumpled beyond recognition.
      const Eigen::VectorXd positions =
          mesh.rest_positions.reshaped() + random.Uniform(0.01, 0.2) * random.InCube(3 * mesh.num_nodes());
      const Eigen::VectorXd velocities = random.InCube(3 * mesh.num_nodes());
      std::vector<PairFeatures> pairs;
      search.Find(positions, velocities, 0.02, reach, &pairs);
      EXPECT_EQ(pairs, BruteForce(mesh, thickness, positions, velocities, 0.02, reach).Find()) << "seed " << seed;
      for (const PairFeatures& pair : pairs) ++num_of_kind[static_cast<int>(pair.kind)];
    }
  }
  for (const int count : num_of_kind) EXPECT_GT(count, 20);
}

// A strip of 41 by 5 nodes, 1 m long, whose second half lies 2 cm above the first, not quite node on node.
TEST(SelfContactSearch, OfAFoldedStripGivesEveryVertexTheFaceOppositeToIt) {
  GridOptions grid;
  grid.nodes = {41, 5};
  grid.size = {1.0, 0.1};
  const Mesh mesh = MakeGrid(grid);
  const double radius = 0.01, fold_start = 0.4, fold_end = fold_start + M_PI * radius;
  Eigen::VectorXd positions = mesh.rest_positions.reshaped();
  int num_upper = 0;
  for (int i = 0; i < mesh.num_nodes(); ++i) {
    const double along = positions[3 * i];
    if (along <= fold_start) continue;
    const double angle = std::min((along - fold_start) / radius, M_PI);
    positions[3 * i] = fold_start + radius * std::sin(angle) - std::max(0.0, along - fold_end);
    positions[3 * i + 2] = radius - radius * std::cos(angle);
    num_upper += along > fold_end && positions[3 * i] > 0.0 ? 1 : 0;
  }
  const std::vector<PairFeatures> pairs = FindAtRest(mesh, 0.02, positions);
  EXPECT_EQ(CountKind(pairs, PairKind::kEdgeEdge), 0);
  std::set<int> upper;
  for (const PairFeatures& pair : pairs) {
    const PairGeometry geometry = EvaluatePair(pair, positions);
    EXPECT_LT(geometry.distance, 0.0251);
    if (pair.kind != PairKind::kVertexVertex && positions[3 * pair.nodes[0] + 2] == 2.0 * radius &&
        std::abs(geometry.normal[2] - 1.0) < 1e-9) {
      upper.insert(pair.nodes[0]);
      EXPECT_NEAR(geometry.distance, 2.0 * radius, 1e-12);
    }
  }
  // Those beside the fold may be its neighbours at rest.
  EXPECT_GE(static_cast<int>(upper.size()), num_upper - 10);
  EXPECT_GT(num_upper, 60);
}

TEST(SelfContactSearch, OfFlatLayersHasNoPairOfEdgesWhereverTheyLie) {
  RandomNumbers random(2);
  for (int trial = 0; trial < 20; ++trial) {
    const Mesh mesh = StackSheets(
        {{8, 7, 0.1, 0.0, {0.0, 0.0}}, {random.Integer(4, 10), 6, 0.08, random.Uniform(-3.0, 3.0), {0.03, 0.03}}},
        0.002);
    const std::vector<PairFeatures> pairs = FindAtRest(mesh, 0.002, mesh.rest_positions.reshaped());
    EXPECT_EQ(CountKind(pairs, PairKind::kEdgeEdge), 0);
    EXPECT_GT(CountKind(pairs, PairKind::kVertexFace), 5);
  }
}

// Rounding does not choose what a vertex above a vertex is paired with.
TEST(SelfContactSearch, PairsVerticesOfAlignedLayersOnce) {
  RandomNumbers random(5);
  const Mesh mesh = StackSheets({{8, 7, 0.1, 0.3, {0.0, 0.0}}, {8, 7, 0.1, 0.3, {0.0, 0.0}}}, 0.002);
  const Eigen::VectorXd positions = mesh.rest_positions.reshaped() + 1e-14 * random.InCube(3 * mesh.num_nodes());
  const std::vector<PairFeatures> pairs = FindAtRest(mesh, 0.002, positions);
  ASSERT_EQ(pairs.size(), 56);
  for (int i = 0; i < 56; ++i) EXPECT_EQ(pairs[i].nodes, (std::array{i, i + 56, -1, -1}));
}

TEST(SelfContactSearch, LeavesOutWhatLinksJoin) {
  Mesh mesh = StackSheets({{5, 5, 0.1, 0.0, {0.0, 0.0}}, {5, 5, 0.1, 0.0, {0.0, 0.0}}}, 0.002);
  mesh.links.push_back({12, {37, 38}, 0.3, 1.0, 0.0});
  const std::vector<PairFeatures> pairs = FindAtRest(mesh, 0.002, mesh.rest_positions.reshaped());
  EXPECT_EQ(pairs.size(), 24);
  for (const PairFeatures& pair : pairs) EXPECT_NE(pair.nodes[0], 12);
}

TEST(SelfContactSearch, LeavesOutPointsAtTheSamePlace) {
  const Mesh mesh = StackSheets({{5, 5, 0.1, 0.0, {0.0, 0.0}}, {5, 5, 0.1, 0.0, {0.0, 0.0}}}, 0.0);
  EXPECT_TRUE(FindAtRest(mesh, 0.002, mesh.rest_positions.reshaped()).empty());
}

TEST(SelfContactSearch, ReachesAsFarAsBothSidesMove) {
  const Mesh mesh = StackSheets({{5, 5, 0.1, 0.0, {0.0, 0.0}}, {5, 5, 0.1, 0.0, {0.0, 0.0}}}, 0.005);
  const Eigen::VectorXd positions = mesh.rest_positions.reshaped();
  SelfContactSearch search(mesh, 0.002);
  // 5 mm are reached by 2.5 mm, 1 mm and (0.1 m/s + 0.05 m/s) times the time.
  Eigen::VectorXd velocities = Eigen::VectorXd::Zero(positions.size());
  for (int i = 0; i < mesh.num_nodes(); ++i) velocities[3 * i] = i < 25 ? 0.1 : -0.05;
  std::vector<PairFeatures> pairs;
  search.Find(positions, velocities, 0.00999, 0.001, &pairs);
  EXPECT_TRUE(pairs.empty());
  search.Find(positions, velocities, 0.01001, 0.001, &pairs);
  EXPECT_EQ(pairs.size(), 25);
  search.Find(positions, velocities, 0.01001, 0.0009, &pairs);
  EXPECT_TRUE(pairs.empty());
}

TEST(SelfContactSearch, FindsAsManyPairsPerNodeInLargerStacks) {
  for (const int nodes : {10, 20, 40}) {
    const Mesh mesh = StackSheets({{nodes, nodes, 0.1, 0.0, {0.0, 0.0}}, {nodes, nodes, 0.1, 0.1, {0.01, 0.0}}}, 0.001);
    const std::vector<PairFeatures> pairs = FindAtRest(mesh, 0.001, mesh.rest_positions.reshaped());
    EXPECT_LT(static_cast<double>(pairs.size()), 1.1 * mesh.num_nodes());
    EXPECT_GT(static_cast<double>(pairs.size()), 0.7 * mesh.num_nodes());
  }
}

}  // namespace
}  // namespace clothid::self_contact_search_test
