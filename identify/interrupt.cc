#include "identify/interrupt.h"

#include <csignal>

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
  std::signal(SIGINT, HandleSignal);
  std::signal(SIGTERM, HandleSignal);
  return interrupted;
}

}  // namespace clothid
