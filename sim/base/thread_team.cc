#include "sim/base/thread_team.h"

#include <chrono>
#include <utility>

namespace clothid {
namespace {

// How long a thread looks for the next round before it sleeps: to be woken takes some tens of microseconds.
constexpr std::chrono::microseconds kPatience{200};

}  // namespace

ThreadTeam::ThreadTeam(int num_threads) {
  try {
    for (int i = 1; i < num_threads; ++i) others_.emplace_back([this] { WaitAndWork(); });
  } catch (...) {
    Stop();
    throw;
  }
}

ThreadTeam::~ThreadTeam() { Stop(); }

void ThreadTeam::Stop() {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    stops_ = true;
  }
  wakes_.notify_all();
  for (std::thread& other : others_) other.join();
}

void ThreadTeam::Run(int num_tasks, const std::function<void(int task)>& work) {
  if (num_tasks <= 0) return;
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    num_tasks_ = static_cast<std::uint32_t>(num_tasks);
    work_ = &work;
    num_done_.store(0, std::memory_order_relaxed);
    const std::uint64_t round = (tickets_.load(std::memory_order_relaxed) >> 32) + 1;
    tickets_.store(round << 32 | num_tasks_, std::memory_order_release);
  }
  wakes_.notify_all();
  Work();
  while (num_done_.load(std::memory_order_acquire) != num_tasks_) std::this_thread::yield();
  if (failure_) std::rethrow_exception(std::exchange(failure_, nullptr));
}

void ThreadTeam::Work() {
  std::uint64_t tickets = tickets_.load(std::memory_order_acquire);
  while (NumLeft(tickets) > 0) {
    if (!tickets_.compare_exchange_weak(tickets, tickets - 1, std::memory_order_acq_rel)) continue;
    try {
      (*work_)(static_cast<int>(num_tasks_ - NumLeft(tickets)));
    } catch (...) {
      const std::lock_guard<std::mutex> lock(mutex_);
      if (!failure_) failure_ = std::current_exception();
    }
    num_done_.fetch_add(1, std::memory_order_release);
    tickets = tickets_.load(std::memory_order_acquire);
  }
}

void ThreadTeam::WaitAndWork() {
  while (!stops_) {
    const auto end = std::chrono::steady_clock::now() + kPatience;
    while (!HasTasks() && !stops_ && std::chrono::steady_clock::now() < end) std::this_thread::yield();
    if (!HasTasks()) {
      std::unique_lock<std::mutex> lock(mutex_);
      wakes_.wait(lock, [this] { return stops_ || HasTasks(); });
    }
    Work();
  }
}

}  // namespace clothid
