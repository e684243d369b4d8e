#include "identify/base/parallel_for.h"

#include <algorithm>
#include <atomic>
#include <future>
#include <mutex>
#include <vector>

namespace clothid {

void ParallelFor(int num_tasks, int num_threads, const std::function<void(int task)>& work,
                 const std::function<void(int task, int num_done)>& done) {
  std::atomic<int> next{0};
  std::mutex report;
  int num_done = 0;
  const auto run = [&] {
    for (int task = next++; task < num_tasks; task = next++) {
      work(task);
      const std::lock_guard<std::mutex> lock(report);
      ++num_done;
      if (done) done(task, num_done);
    }
  };
  std::vector<std::future<void>> workers;
  for (int t = 1; t < std::min(num_threads, num_tasks); ++t) workers.push_back(std::async(std::launch::async, run));
  run();  // whatever it throws leaves once the futures have waited for their threads
  for (std::future<void>& worker : workers) worker.get();
}

}  // namespace clothid
