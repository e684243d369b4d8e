#include "sim/base/program.h"

#include <cerrno>
#include <csignal>
#include <cstring>
#include <exception>
#include <iostream>
#include <new>

#include "sim/base/error.h"

namespace clothid {
namespace {

// A signal handler can reach nothing but a global.
std::atomic<bool> interrupted{false};

extern "C" void HandleSignal(int signal) {
  interrupted.store(true);
  std::signal(signal, SIG_DFL);
}

}  // namespace

const std::atomic<bool>& CatchInterrupts() {
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) {
    if (std::signal(signal, HandleSignal) == SIG_IGN) std::signal(signal, SIG_IGN);
  }
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

}  // namespace clothid
