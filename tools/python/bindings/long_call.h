// Calls that may take long: other threads of Python run meanwhile, and Ctrl-C ends them.
#ifndef CLOTHID_TOOLS_PYTHON_BINDINGS_LONG_CALL_H_
#define CLOTHID_TOOLS_PYTHON_BINDINGS_LONG_CALL_H_

#include <atomic>
#include <functional>

namespace clothid {

// Runs `work` on a thread of its own, without the interpreter's lock, and waits for it. Meanwhile the calling thread
// lets Python handle its signals 50 times a second. Where a handler raises, as that of Ctrl-C does, `cancel` turns
// true, and what was raised is raised here once `work` has come back. What `work` throws is thrown here. It may call
// Python with the lock (py::gil_scoped_acquire).
void RunInterruptibly(const std::function<void(const std::atomic<bool>& cancel)>& work);
// The same, with a `cancel` that others may set, too.
void RunInterruptibly(const std::function<void()>& work, std::atomic<bool>* cancel);

}  // namespace clothid

#endif  // CLOTHID_TOOLS_PYTHON_BINDINGS_LONG_CALL_H_
