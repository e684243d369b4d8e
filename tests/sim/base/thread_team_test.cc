// Teams of threads: every task once, in order, however many threads and rounds there are.
#include "sim/base/thread_team.h"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <new>
#include <thread>
#include <vector>

namespace clothid::thread_team_test {
namespace {

TEST(ThreadTeamTest, DoesEveryTaskOnceInEveryRound) {
  for (const int num_threads : {1, 2, 3, 8}) {
    ThreadTeam team(num_threads);
    EXPECT_EQ(team.num_threads(), num_threads);
    for (int round = 0; round < 300; ++round) {
      std::vector<int> counts(round % 20);
      team.Run(static_cast<int>(counts.size()), [&](int task) { ++counts[task]; });
      EXPECT_EQ(counts, std::vector<int>(round % 20, 1));
    }
  }
}

TEST(ThreadTeamTest, SharesTheTasks) {
  ThreadTeam team(2);
  std::atomic<int> num_started{0};
  // Each waits for the other.
  team.Run(2, [&](int) {
    ++num_started;
    while (num_started < 2) std::this_thread::yield();
  });
  EXPECT_EQ(num_started, 2);
}

TEST(ThreadTeamTest, ATaskMayWaitForThoseBeforeIt) {
  ThreadTeam team(4);
  for (int round = 0; round < 100; ++round) {
    std::atomic<int> num_done{0};
    std::vector<int> order(20);
    team.Run(20, [&](int task) {
      while (num_done < task) std::this_thread::yield();
      order[task] = num_done++;
    });
    for (int task = 0; task < 20; ++task) EXPECT_EQ(order[task], task);
  }
}

TEST(ThreadTeamTest, WakesUpAfterASleep) {
  ThreadTeam team(3);
  for (int round = 0; round < 3; ++round) {
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
    std::atomic<int> sum{0};
    team.Run(10, [&](int task) { sum += task; });
    EXPECT_EQ(sum, 45);
  }
}

// On whichever thread the task was: the other one waits for it.
TEST(ThreadTeamTest, WhatATaskThrowsReachesTheCaller) {
  ThreadTeam team(2);
  for (const int culprit : {0, 1}) {
    std::atomic<int> num_started{0}, num_done{0};
    const auto work = [&](int task) {
      ++num_started;
      while (num_started < 2) std::this_thread::yield();
      if (task == culprit) throw std::bad_alloc();
      ++num_done;
    };
    EXPECT_THROW(team.Run(10, work), std::bad_alloc);
    EXPECT_EQ(num_done, 9);
    team.Run(10, [&](int) { ++num_done; });
    EXPECT_EQ(num_done, 19);
  }
}

TEST(ThreadTeamTest, WithoutATeamTasksAreDoneInOrder) {
  std::vector<int> order;
  RunTasks(nullptr, 5, [&](int task) { order.push_back(task); });
  EXPECT_EQ(order, (std::vector<int>{0, 1, 2, 3, 4}));
}

}  // namespace
}  // namespace clothid::thread_team_test
