#include "sim/geometry/box_tree.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <vector>

#include "tests/sim/random_numbers.h"

namespace clothid::box_tree_test {
namespace {

using Eigen::Vector3d;
using Box = BoxTree::Box;

Box RandomBox(RandomNumbers* random, double size) {
  const Vector3d centre = random->InCube(3), half = size * (random->InCube(3).array().abs());
  return {centre - half, centre + half};
}

std::vector<Box> RandomBoxes(RandomNumbers* random, int count) {
  std::vector<Box> boxes;
  for (int i = 0; i < count; ++i) boxes.push_back(RandomBox(random, 0.2));
  return boxes;
}

std::vector<int> Overlaps(const BoxTree& tree, const Box& box) {
  std::vector<int> items;
  tree.VisitOverlaps(box, [&](int item) { items.push_back(item); });
  return items;
}

std::vector<int> BruteForceOverlaps(const std::vector<Box>& boxes, const Box& box) {
  std::vector<int> items;
  for (std::size_t i = 0; i < boxes.size(); ++i) {
    if (boxes[i].intersects(box)) items.push_back(static_cast<int>(i));
  }
  return items;
}

std::vector<std::array<int, 2>> Pairs(const BoxTree& tree) {
  std::vector<std::array<int, 2>> pairs;
  tree.VisitPairs([&](int a, int b) { pairs.push_back({a, b}); });
  std::sort(pairs.begin(), pairs.end());
  return pairs;
}

std::vector<std::array<int, 2>> BruteForcePairs(const std::vector<Box>& boxes) {
  std::vector<std::array<int, 2>> pairs;
  for (int a = 0; a < static_cast<int>(boxes.size()); ++a) {
    for (int b = a + 1; b < static_cast<int>(boxes.size()); ++b) {
      if (boxes[a].intersects(boxes[b])) pairs.push_back({a, b});
    }
  }
  return pairs;
}

// Also: every item at most once, and the same order at every call.
void ExpectBruteForce(const BoxTree& tree, const std::vector<Box>& boxes, RandomNumbers* random) {
  for (int query = 0; query < 30; ++query) {
    const Box box = RandomBox(random, 0.5);
    std::vector<int> items = Overlaps(tree, box);
    EXPECT_EQ(items, Overlaps(tree, box));
    std::sort(items.begin(), items.end());
    EXPECT_EQ(items, BruteForceOverlaps(boxes, box));
  }
  EXPECT_EQ(Pairs(tree), BruteForcePairs(boxes));
}

TEST(BoxTree, FindsWhatEveryBoxTellsBeforeAndAfterItemsMove) {
  for (const int count : {1, 2, 5, 17, 300}) {
    RandomNumbers random(static_cast<std::uint64_t>(count));
    std::vector<Box> boxes = RandomBoxes(&random, count);
    BoxTree tree(boxes);
    ASSERT_EQ(tree.num_items(), count);
    ExpectBruteForce(tree, boxes, &random);
    boxes = RandomBoxes(&random, count);
    tree.Refit(boxes);
    ExpectBruteForce(tree, boxes, &random);
  }
}

TEST(BoxTree, OverlapsNothingWhereItHasNoItemsOrEmptyOnes) {
  const Box everything(Vector3d::Constant(-1e9), Vector3d::Constant(1e9));
  EXPECT_TRUE(Overlaps(BoxTree(), everything).empty());
  EXPECT_TRUE(Overlaps(BoxTree(std::vector<Box>()), everything).empty());
  BoxTree tree({Box(Vector3d::Zero()), Box(Vector3d::Ones())});
  tree.Refit({Box(), Box(Vector3d::Ones())});
  EXPECT_EQ(Overlaps(tree, everything), std::vector<int>{1});
  EXPECT_TRUE(Overlaps(tree, Box()).empty());
}

TEST(BoxTree, CountsTouchingAsOverlapping) {
  const BoxTree tree({Box(Vector3d::Zero(), Vector3d::Ones())});
  EXPECT_EQ(Overlaps(tree, Box(Vector3d(1.0, 0.5, 0.5), Vector3d(2.0, 0.5, 0.5))), std::vector<int>{0});
}

TEST(BoxTree, IsHalvedWhereAllCentresAreTheSame) {
  const std::vector<Box> boxes(1000, Box(Vector3d::Zero(), Vector3d::Ones()));
  EXPECT_EQ(Overlaps(BoxTree(boxes), boxes[0]).size(), boxes.size());
}

// What is gathered leads a walk to the items with a value of at least 90, and to few others.
TEST(BoxTree, GathersValuesByWhichPartsAreLeftOut) {
  std::vector<Box> boxes;
  std::vector<double> values;
  for (int i = 0; i < 1000; ++i) {
    boxes.emplace_back(Vector3d(i, 0.0, 0.0));
    values.push_back(i % 100);
  }
  const BoxTree tree(boxes);
  std::vector<double> most;
  tree.Gather(
      values, [](double* value, double other) { *value = std::max(*value, other); }, &most);
  EXPECT_EQ(most[0], 99.0);
  int num_visited = 0, num_found = 0;
  const Box everything(Vector3d::Constant(-1e9), Vector3d::Constant(1e9));
  tree.VisitOverlaps(
      everything, [&](int node) { return most[node] >= 90.0; },
      [&](int item) {
        ++num_visited;
        num_found += values[item] >= 90.0 ? 1 : 0;
      });
  EXPECT_EQ(num_found, 100);
  EXPECT_LT(num_visited, 200);
}

}  // namespace
}  // namespace clothid::box_tree_test
