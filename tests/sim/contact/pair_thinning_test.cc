#include "sim/contact/pair_thinning.h"

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <set>
#include <string>
#include <vector>

#include "sim/contact/self_contact_search.h"
#include "sim/matrix/dense.h"
#include "tests/sim/contact/stacked_sheets.h"
#include "tests/sim/property_seeds.h"
#include "tests/sim/random_numbers.h"

namespace clothid::pair_thinning_test {
namespace {

using Eigen::Vector3d;

constexpr double kThickness = 0.002, kTie = 0.5 * kThickness;

std::vector<ThinningPair> Evaluate(const std::vector<PairFeatures>& features, const Eigen::VectorXd& positions) {
  std::vector<ThinningPair> pairs;
  for (const PairFeatures& pair : features) {
    const PairGeometry geometry = EvaluatePair(pair, positions);
    pairs.push_back({pair, geometry, geometry.distance - kThickness});
  }
  return pairs;
}

// w of every accepted pair in a row over all nodes.
Eigen::MatrixXd Rows(const std::vector<ThinningPair>& pairs, const ThinnedPairs& thinned, int num_nodes) {
  Eigen::MatrixXd rows = Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(thinned.accepted.size()), num_nodes);
  for (std::size_t row = 0; row < thinned.accepted.size(); ++row) {
    const ThinningPair& pair = pairs[thinned.accepted[row].pair];
    for (int k = 0; k < pair.features.num_nodes(); ++k) {
      rows(static_cast<Eigen::Index>(row), pair.features.nodes[k]) = pair.geometry.weights[k];
    }
  }
  return rows;
}

double LeastSingularValue(const Eigen::MatrixXd& rows) {
  return rows.rows() == 0 ? 1.0 : RightSingularVectors(rows.transpose()).values.tail(1)[0];
}

// Every pair is accepted or rejected; slaves are nodes of their pairs, each once, that can follow; and the nodes that
// lead to nobody can be taken away until none is left.
void ExpectSlavesWithoutCircles(const std::vector<ThinningPair>& pairs, const ThinnedPairs& thinned,
                                const std::vector<bool>& can_follow) {
  std::set<int> decided(thinned.rejected.begin(), thinned.rejected.end()), slaves;
  for (const AcceptedPair& accepted : thinned.accepted) {
    decided.insert(accepted.pair);
    const std::array<int, 4>& nodes = pairs[accepted.pair].features.nodes;
    const auto place = std::find(nodes.begin(), nodes.end(), accepted.slave) - nodes.begin();
    ASSERT_LT(place, pairs[accepted.pair].features.num_nodes());
    EXPECT_GT(std::abs(pairs[accepted.pair].geometry.weights[place]), 0.05);
    EXPECT_TRUE(can_follow[accepted.slave]);
    EXPECT_TRUE(slaves.insert(accepted.slave).second);
  }
  EXPECT_EQ(decided.size(), pairs.size());
  EXPECT_EQ(thinned.accepted.size() + thinned.rejected.size(), pairs.size());
  EXPECT_TRUE(std::is_sorted(thinned.rejected.begin(), thinned.rejected.end()));
  for (std::size_t size = slaves.size() + 1; size != slaves.size();) {
    size = slaves.size();
    for (const AcceptedPair& accepted : thinned.accepted) {
      const std::array<int, 4>& nodes = pairs[accepted.pair].features.nodes;
      const bool is_free = std::none_of(nodes.begin(), nodes.end(),
                                        [&](int node) { return node != accepted.slave && slaves.count(node) > 0; });
      if (is_free) slaves.erase(accepted.slave);
    }
  }
  EXPECT_TRUE(slaves.empty());
}

struct Stack {
  std::string name;
  std::vector<SheetOfStack> sheets;

  // The sheet of a node.
  int SheetOf(int node) const {
    int sheet = 0;
    for (; node >= sheets[sheet].columns * sheets[sheet].rows; ++sheet)
      node -= sheets[sheet].columns * sheets[sheet].rows;
    return sheet;
  }
};

std::vector<Stack> Stacks() {
  const SheetOfStack base = {9, 9, 0.1, 0.0, {0.0, 0.0}}, turned = {9, 9, 0.1, 0.1745, {0.01, 0.0}};
  const SheetOfStack fine = {14, 14, 0.08, 0.2, {0.02, 0.005}}, coarse = {5, 5, 0.08, 0.2, {0.02, 0.005}};
  return {{"aligned", {base, base}},
          {"shifted", {base, {9, 9, 0.1, 0.0, {0.0037, 0.0025}}}},
          {"shifted along an edge", {base, {9, 9, 0.1, 0.0, {0.00625, 0.0}}}},
          {"turned", {base, turned}},
          {"fine on coarse", {base, fine}},
          {"coarse on fine", {base, coarse}},
          {"three", {base, turned, {9, 9, 0.1, -0.2, {0.0, 0.01}}}},
          {"four", {base, turned, base, {9, 9, 0.1, 0.4, {0.01, 0.0}}}}};
}

// The share of the vertices of `sheet` with a gap of almost 0 to `other` that keep such a pair, as a vertex.
double Coverage(const Stack& stack, int sheet, int other, const std::vector<ThinningPair>& pairs,
                const ThinnedPairs& thinned) {
  const auto vertices = [&](const std::vector<int>& of) {
    std::set<int> result;
    for (const int i : of) {
      const PairFeatures& features = pairs[i].features;
      if (std::abs(pairs[i].gap) > 0.25 * kThickness) continue;
      const int num_vertices = features.kind == PairKind::kVertexVertex ? 2 : 1;
      for (int k = 0; k < num_vertices; ++k) {
        const int opposite = features.nodes[k == 0 ? 1 : 0];
        if (stack.SheetOf(features.nodes[k]) == sheet && stack.SheetOf(opposite) == other) {
          result.insert(features.nodes[k]);
        }
      }
    }
    return static_cast<double>(result.size());
  };
  std::vector<int> accepted, all;
  for (const AcceptedPair& pair : thinned.accepted) accepted.push_back(pair.pair);
  for (std::size_t i = 0; i < pairs.size(); ++i) all.push_back(static_cast<int>(i));
  return vertices(accepted) / vertices(all);
}

TEST(PairThinning, OfLayersLeavesRowsOfFullRankThatKeepThemApart) {
  for (const Stack& stack : Stacks()) {
    const Mesh mesh = StackSheets(stack.sheets, kThickness);
    SelfContactSearch search(mesh, kThickness);
    const std::vector<bool> can_follow(mesh.num_nodes(), true);
    for (const double noise : {0.0, 1e-14, 2e-5, 2e-4}) {
      SCOPED_TRACE(stack.name + ", noise " + std::to_string(noise));
      const Eigen::VectorXd shift = noise * RandomNumbers(1).InCube(3 * mesh.num_nodes());
      const Eigen::VectorXd positions = mesh.rest_positions.reshaped() + shift;
      std::vector<PairFeatures> features;
      search.Find(positions, 0.0 * shift, 0.005, 0.0, &features);
      const std::vector<ThinningPair> pairs = Evaluate(features, positions);
      const ThinnedPairs thinned = ThinPairs(pairs, can_follow, kTie, FollowOrder(mesh));
      ExpectSlavesWithoutCircles(pairs, thinned, can_follow);
      EXPECT_GT(LeastSingularValue(Rows(pairs, thinned, mesh.num_nodes())), 0.03);
      for (int sheet = 0; sheet + 1 < static_cast<int>(stack.sheets.size()); ++sheet) {
        EXPECT_GE(std::max(Coverage(stack, sheet, sheet + 1, pairs, thinned),
                           Coverage(stack, sheet + 1, sheet, pairs, thinned)),
                  0.95);
      }
    }
  }
}

// Were they taken in both directions, a sheet on a sheet could not bend: its vertices would be on straight lines.
TEST(PairThinning, OfTwoLayersLeavesOneOfThemFree) {
  const std::vector<Stack> stacks = Stacks();
  for (const Stack& stack : {stacks[1], stacks[2], stacks[3]}) {
    const Mesh mesh = StackSheets(stack.sheets, kThickness);
    const Eigen::VectorXd positions = mesh.rest_positions.reshaped();
    std::vector<PairFeatures> features;
    SelfContactSearch(mesh, kThickness).Find(positions, 0.0 * positions, 0.005, 0.0, &features);
    const std::vector<ThinningPair> pairs = Evaluate(features, positions);
    const ThinnedPairs thinned = ThinPairs(pairs, std::vector<bool>(mesh.num_nodes(), true), kTie, FollowOrder(mesh));
    int num_slaves_of_other = 0;
    for (const AcceptedPair& accepted : thinned.accepted) {
      const bool is_level = std::abs(pairs[accepted.pair].gap) < 1e-9;
      if (is_level && stack.SheetOf(accepted.slave) != 0) ++num_slaves_of_other;
    }
    EXPECT_LE(num_slaves_of_other, 4) << stack.name;
  }
}

TEST(PairThinning, LetsFineVerticesFollowCoarseFaces) {
  const std::vector<Stack> stacks = Stacks();
  for (const int fine : {0, 1}) {
    const Stack& stack = stacks[fine == 0 ? 5 : 4];
    const Mesh mesh = StackSheets(stack.sheets, kThickness);
    const Eigen::VectorXd positions = mesh.rest_positions.reshaped();
    std::vector<PairFeatures> features;
    SelfContactSearch(mesh, kThickness).Find(positions, 0.0 * positions, 0.005, 0.0, &features);
    const std::vector<ThinningPair> pairs = Evaluate(features, positions);
    const ThinnedPairs thinned = ThinPairs(pairs, std::vector<bool>(mesh.num_nodes(), true), kTie, FollowOrder(mesh));
    EXPECT_EQ(Coverage(stack, fine, 1 - fine, pairs, thinned), 1.0);
  }
}

// Random pairs of random gaps among few nodes.
std::vector<ThinningPair> RandomPairs(RandomNumbers* random, int num_nodes, int count) {
  std::set<PairFeatures> features;
  for (int i = 0; i < count; ++i) {
    PairFeatures pair;
    pair.kind = static_cast<PairKind>(random->Integer(0, 3));
    const std::vector<int> nodes = random->Permutation(num_nodes);
    for (int k = 0; k < pair.num_nodes(); ++k) pair.nodes[k] = nodes[k];
    const int first_of_second = pair.kind == PairKind::kEdgeEdge ? 2 : pair.kind == PairKind::kVertexVertex ? 0 : 1;
    std::sort(pair.nodes.begin() + first_of_second, pair.nodes.begin() + pair.num_nodes());
    features.insert(pair);
  }
  std::vector<ThinningPair> pairs;
  for (const PairFeatures& pair : features) {
    ThinningPair added = {pair, {}, random->Uniform(-2.0, 4.0) * kThickness};
    const int num_first = pair.kind == PairKind::kEdgeEdge ? 2 : 1;
    double sums[] = {0.0, 0.0};
    for (int k = 0; k < pair.num_nodes(); ++k)
      sums[k < num_first] += added.geometry.weights[k] = random->Uniform(0.0, 1.0);
    for (int k = 0; k < pair.num_nodes(); ++k) added.geometry.weights[k] /= k < num_first ? sums[1] : -sums[0];
    added.geometry.normal = random->Direction();
    pairs.push_back(added);
  }
  return pairs;
}

TEST(PairThinning, OfAnyPairsLeavesRowsOfFullRankInAnyOrder) {
  for (const std::uint64_t seed : PropertySeeds(60)) {
    SCOPED_TRACE(seed);
    RandomNumbers random(seed);
    const int num_nodes = random.Integer(5, 30);
    const std::vector<ThinningPair> pairs = RandomPairs(&random, num_nodes, random.Integer(1, 100));
    std::vector<bool> can_follow(num_nodes);
    for (int node = 0; node < num_nodes; ++node) can_follow[node] = random.Chance(0.8);
    const ThinnedPairs thinned = ThinPairs(pairs, can_follow, kTie);
    ExpectSlavesWithoutCircles(pairs, thinned, can_follow);
    EXPECT_GT(LeastSingularValue(Rows(pairs, thinned, num_nodes)), 1e-6);
    // The same in another order.
    const std::vector<int> order = random.Permutation(static_cast<int>(pairs.size()));
    std::vector<ThinningPair> shuffled;
    for (const int i : order) shuffled.push_back(pairs[i]);
    const ThinnedPairs other = ThinPairs(shuffled, can_follow, kTie);
    ASSERT_EQ(other.accepted.size(), thinned.accepted.size());
    for (std::size_t i = 0; i < other.accepted.size(); ++i) {
      EXPECT_EQ(order[other.accepted[i].pair], thinned.accepted[i].pair);
      EXPECT_EQ(other.accepted[i].slave, thinned.accepted[i].slave);
    }
  }
}

ThinningPair VertexAbove(int vertex, std::array<int, 3> face, const Vector3d& weights, double gap) {
  ThinningPair pair;
  pair.features = {PairKind::kVertexFace, {vertex, face[0], face[1], face[2]}};
  pair.geometry.weights << 1.0, -weights;
  pair.gap = gap;
  return pair;
}

TEST(PairThinning, GivesAVertexToTheNearerOfTwoFaces) {
  const std::vector<ThinningPair> pairs = {VertexAbove(0, {1, 2, 3}, {0.2, 0.3, 0.5}, 2.0 * kTie),
                                           VertexAbove(0, {4, 5, 6}, {0.2, 0.3, 0.5}, 0.4 * kTie)};
  const ThinnedPairs thinned = ThinPairs(pairs, std::vector<bool>(7, true), kTie);
  ASSERT_EQ(thinned.accepted.size(), 2);
  EXPECT_EQ(thinned.accepted[0].pair, 1);
  EXPECT_EQ(thinned.accepted[0].slave, 0);
  EXPECT_EQ(thinned.accepted[1].slave, 3);  // the largest weight of the other
}

TEST(PairThinning, LetsTheLargestWeightFollowWhereTheVertexCannot) {
  const std::vector<ThinningPair> pairs = {VertexAbove(0, {1, 2, 3}, {0.5, 0.46, 0.04}, 0.0)};
  std::vector<bool> can_follow = {false, true, true, true};
  EXPECT_EQ(ThinPairs(pairs, can_follow, kTie).accepted.at(0).slave, 1);
  can_follow[1] = false;
  EXPECT_EQ(ThinPairs(pairs, can_follow, kTie).accepted.at(0).slave, 2);
  can_follow[2] = false;
  EXPECT_EQ(ThinPairs(pairs, can_follow, kTie).rejected, std::vector<int>{0});
}

// Node 1 follows a face with node 0 from below, so node 0 does not follow one with node 1 that is above it.
TEST(PairThinning, RejectsWhatWouldFollowItself) {
  std::vector<ThinningPair> pairs = {VertexAbove(0, {1, 2, 3}, {0.4, 0.3, 0.3}, 0.1 * kTie),
                                     VertexAbove(1, {0, 4, 5}, {0.4, 0.3, 0.3}, 0.0)};
  pairs[1].geometry.normal = -pairs[0].geometry.normal;
  std::vector<int> order = {1, 0, 2, 3, 4, 5};
  EXPECT_EQ(ThinPairs(pairs, std::vector<bool>(6, true), kTie).rejected, std::vector<int>{1});
  EXPECT_EQ(ThinPairs(pairs, std::vector<bool>(6, true), kTie, order).rejected, std::vector<int>{0});
  pairs[0].gap = kTie;  // another multiple: the nearer one first
  EXPECT_EQ(ThinPairs(pairs, std::vector<bool>(6, true), kTie).rejected, std::vector<int>{0});
}

}  // namespace
}  // namespace clothid::pair_thinning_test
