#include "identify/base/program_start.h"

#include <signal.h>

#include <initializer_list>

namespace clothid {
namespace {

void Change(int how) {
  sigset_t signals;
  sigemptyset(&signals);
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) sigaddset(&signals, signal);
  pthread_sigmask(how, &signals, nullptr);
}

// Before any library is set up: functions of this section come first, in programs; libraries may have none.
[[maybe_unused]] void Block(int, char**, char**) { Change(SIG_BLOCK); }
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)  // which are libraries themselves
[[gnu::section(".preinit_array"), gnu::used]] void (*const block)(int, char**, char**) = Block;
#endif

// After all of them.
[[gnu::constructor]] void Unblock() { Change(SIG_UNBLOCK); }

}  // namespace

void KeepSignalsFromLibraries() {}

}  // namespace clothid
