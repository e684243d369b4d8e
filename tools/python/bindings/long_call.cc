#include "tools/python/bindings/long_call.h"

#include <pybind11/pybind11.h>

#include <chrono>
#include <condition_variable>
#include <exception>
#include <mutex>
#include <optional>
#include <thread>

namespace clothid {
namespace {

namespace py = pybind11;

constexpr std::chrono::milliseconds kBetweenSignals(20);

// What Python raises while it handles its signals, with the lock for that long.
std::optional<py::error_already_set> HandleSignals() {
  const py::gil_scoped_acquire lock;
  if (PyErr_CheckSignals() == 0) return std::nullopt;
  return py::error_already_set();
}

}  // namespace

void RunInterruptibly(const std::function<void(const std::atomic<bool>& cancel)>& work) {
  std::atomic<bool> cancel{false};
  RunInterruptibly([&] { work(cancel); }, &cancel);
}

void RunInterruptibly(const std::function<void()>& work, std::atomic<bool>* cancel) {
  std::exception_ptr failure;
  std::optional<py::error_already_set> raised;
  {
    const py::gil_scoped_release release;
    std::mutex mutex;
    std::condition_variable ended;
    bool has_ended = false;
    std::thread worker([&] {
      try {
        work();
      } catch (...) {
        failure = std::current_exception();
      }
      const std::lock_guard<std::mutex> lock(mutex);
      has_ended = true;
      ended.notify_one();
    });
    std::unique_lock<std::mutex> lock(mutex);
    while (!ended.wait_for(lock, kBetweenSignals, [&] { return has_ended; })) {
      if (raised) continue;
      lock.unlock();
      raised = HandleSignals();
      if (raised) cancel->store(true);
      lock.lock();
    }
    lock.unlock();
    worker.join();
  }
  if (raised) throw *raised;
  if (failure) std::rethrow_exception(failure);
}

}  // namespace clothid
