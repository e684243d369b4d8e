// The order of elimination is one, and a good one.
#include "sim/matrix/fill_reducing_order.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <memory>
#include <thread>
#include <vector>

#include "sim/matrix/cholesky.h"

namespace clothid::fill_reducing_order_test {
namespace {

// A hub and its neighbours: eliminated first the hub would join all of them, last it joins none.
TEST(FillReducingOrderTest, IsAPermutationThatReducesFill) {
  constexpr int kNodes = 100;
  std::vector<std::vector<int>> hub_first(kNodes), renumbered(kNodes);
  for (int node = 1; node < kNodes; ++node) {
    hub_first[0].push_back(node);
    hub_first[node].push_back(0);
  }
  const std::vector<int> order = FillReducingOrder(hub_first);
  std::vector<int> index(kNodes, -1);
  for (int k = 0; k < kNodes; ++k) index[order[k]] = k;
  ASSERT_EQ(std::count(index.begin(), index.end(), -1), 0);
  for (int node = 0; node < kNodes; ++node) {
    for (const int neighbour : hub_first[node]) renumbered[index[node]].push_back(index[neighbour]);
  }
  const auto factor_bytes = [](const std::vector<std::vector<int>>& neighbours) {
    BlockMatrix identity(std::make_shared<BlockPattern>(neighbours));
    for (int i = 0; i < kNodes; ++i) identity.block(identity.pattern().Find(i, i)).setIdentity();
    return CholeskySolver(identity.shared_pattern()).Factor(identity.values)->bytes();
  };
  EXPECT_LT(10 * factor_bytes(renumbered), factor_bytes(hub_first));
}

// METIS shares a random sequence among threads.
TEST(FillReducingOrderTest, IsTheSameInEveryThread) {
  constexpr int kSide = 40;
  std::vector<std::vector<int>> grid(kSide * kSide);
  for (int node = 0; node < kSide * kSide; ++node) {
    const int column = node % kSide;
    for (int other : {node - kSide, node - 1, node + 1, node + kSide}) {
      const bool is_across = other == node - 1 ? column > 0 : other == node + 1 ? column + 1 < kSide : true;
      if (other >= 0 && other < kSide * kSide && is_across) grid[node].push_back(other);
    }
  }
  const std::vector<int> expected = FillReducingOrder(grid);
  std::atomic<int> num_wrong{0};
  std::vector<std::thread> threads;
  for (int t = 0; t < 3; ++t) {
    threads.emplace_back([&] {
      for (int i = 0; i < 20; ++i) num_wrong += FillReducingOrder(grid) != expected;
    });
  }
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(num_wrong, 0);
}

}  // namespace
}  // namespace clothid::fill_reducing_order_test
