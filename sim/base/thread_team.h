// Threads that share the work of one caller, in rounds of a fraction of a millisecond.
#ifndef CLOTHID_SIM_BASE_THREAD_TEAM_H_
#define CLOTHID_SIM_BASE_THREAD_TEAM_H_

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <exception>
#include <functional>
#include <mutex>
#include <thread>
#include <vector>

namespace clothid {

class ThreadTeam {
 public:
  // The caller of `Run` and num_threads - 1 others, which wait from now on. Throws `std::system_error` where the system
  // has no more threads.
  explicit ThreadTeam(int num_threads);
  ~ThreadTeam();
  ThreadTeam(const ThreadTeam&) = delete;
  ThreadTeam& operator=(const ThreadTeam&) = delete;

  int num_threads() const { return 1 + static_cast<int>(others_.size()); }

  // Calls work(i) for every i in [0, num_tasks), whoever is free the next one, and returns when all are done. So a task
  // may wait for what tasks before it do. Then rethrows what the first of those that failed has thrown: a task that
  // others wait for must tell them before it throws. For one caller at a time.
  void Run(int num_tasks, const std::function<void(int task)>& work);

 private:
  void Work();  // until no task is left
  void WaitAndWork();
  bool HasTasks() const { return NumLeft(tickets_.load(std::memory_order_acquire)) > 0; }
  static std::uint32_t NumLeft(std::uint64_t tickets) { return static_cast<std::uint32_t>(tickets); }
  void Stop();

  // The number of the round, and in the lower half how many of its tasks are left. Who takes one has seen both, and
  // the round does not end before that task, so what follows is that of the round.
  std::atomic<std::uint64_t> tickets_{0};
  std::uint32_t num_tasks_ = 0;
  const std::function<void(int task)>* work_ = nullptr;
  std::atomic<std::uint32_t> num_done_{0};

  std::atomic<bool> stops_{false};
  std::mutex mutex_;
  std::condition_variable wakes_;
  std::vector<std::thread> others_;
  std::exception_ptr failure_;  // of the round
};

// The same without a team, in order.
inline void RunTasks(ThreadTeam* team, int num_tasks, const std::function<void(int task)>& work) {
  if (team != nullptr) {
    team->Run(num_tasks, work);
  } else {
    for (int task = 0; task < num_tasks; ++task) work(task);
  }
}

}  // namespace clothid

#endif  // CLOTHID_SIM_BASE_THREAD_TEAM_H_
