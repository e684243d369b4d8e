// Independent tasks side by side.
#ifndef CLOTHID_IDENTIFY_BASE_PARALLEL_FOR_H_
#define CLOTHID_IDENTIFY_BASE_PARALLEL_FOR_H_

#include <functional>

namespace clothid {

// A bound for flags: no machine has as many cores.
inline constexpr int kMaxThreads = 4096;

// Calls work(i) for every i in [0, num_tasks) on up to `num_threads` threads. After each of them done(i, n) follows, n
// the number of tasks done so far: never two at a time. `done` may be empty. Rethrows what a task has thrown once all
// threads have ended.
void ParallelFor(int num_tasks, int num_threads, const std::function<void(int task)>& work,
                 const std::function<void(int task, int num_done)>& done = {});

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_BASE_PARALLEL_FOR_H_
