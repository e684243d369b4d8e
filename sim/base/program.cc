#include "sim/base/program.h"

#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <iostream>
#include <new>
#include <system_error>
#include <thread>

#include "sim/base/error.h"

namespace clothid {
namespace {

// A signal handler can reach nothing but a global.
std::atomic<bool> interrupted{false};

// For threads that were there before and do not block signals. The second signal ends the process once this returns.
extern "C" void HandleSignal(int signal) {
  if (!interrupted.exchange(true)) return;
  std::signal(signal, SIG_DFL);
  std::raise(signal);
}

void WaitForSignals(const sigset_t& signals) {
  int signal = 0;
  do {
    sigwait(&signals, &signal);
  } while (!interrupted.exchange(true));
  std::signal(signal, SIG_DFL);
  pthread_sigmask(SIG_UNBLOCK, &signals, nullptr);
  std::raise(signal);
}

// One thread waits for the signals, and all that come after block them: whatever handlers a library has for a while,
// none is called. METIS has one for SIGTERM while it orders nodes, and jumps with it out of whichever thread it is in.
bool StartCatching() {
  sigset_t signals;
  sigemptyset(&signals);
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) {
    if (std::signal(signal, HandleSignal) == SIG_IGN) {
      std::signal(signal, SIG_IGN);
    } else {
      sigaddset(&signals, signal);
    }
  }
  pthread_sigmask(SIG_BLOCK, &signals, nullptr);
  try {
    std::thread(WaitForSignals, signals).detach();
  } catch (const std::system_error&) {  // no more threads: the handler remains
    pthread_sigmask(SIG_UNBLOCK, &signals, nullptr);
  }
  return true;
}

}  // namespace

const std::atomic<bool>& CatchInterrupts() {
  [[maybe_unused]] static const bool is_catching = StartCatching();
  return interrupted;
}

bool IsInterrupted() { return interrupted.load(); }

void CatchFileSizeLimit() { std::signal(SIGXFSZ, SIG_IGN); }

int ReportErrors(const std::string& name, const std::function<int()>& work) {
  try {
    return work();
  } catch (const Error& error) {
    std::cerr << name << ": " << error.what() << "\n";
    return ExitCodeOf(error.kind());
  } catch (const std::bad_alloc&) {
    std::cerr << name << ": memory ran out\n";
    return kExitInternal;
  } catch (const std::exception& error) {
    std::cerr << name << ": internal error: " << error.what() << "\n";
    return kExitInternal;
  }
}

int FinishOutput(const std::string& name, int exit_code) {
  errno = 0;
  if (std::cout.flush()) return exit_code;
  std::cerr << name << ": standard output: cannot be written" << (errno != 0 ? ": " : "")
            << (errno != 0 ? std::strerror(errno) : "") << "\n";
  return exit_code == kExitInterrupted ? exit_code : kExitUsageOrIo;
}

void EndProcess(int exit_code) {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  std::exit(exit_code);
#else
  std::fflush(nullptr);
  std::_Exit(exit_code);
#endif
}

}  // namespace clothid
