// What programs do with signals.
#include "sim/base/program.h"

#include <gtest/gtest.h>
#include <signal.h>
#include <unistd.h>

#include <cstdlib>
#include <thread>

namespace clothid::program_test {
namespace {

void SendAndWait(int signal) {
  kill(getpid(), signal);
  while (!IsInterrupted()) std::this_thread::yield();
}

class CatchInterruptsTest : public testing::Test {
 protected:
  CatchInterruptsTest() { testing::FLAGS_gtest_death_test_style = "threadsafe"; }
};

TEST_F(CatchInterruptsTest, TheFirstSignalSetsTheFlagAndTheSecondEndsTheProcess) {
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) {
    const auto interrupt_twice = [signal] {
      if (&CatchInterrupts() != &CatchInterrupts() || IsInterrupted()) _exit(1);
      SendAndWait(signal);
      kill(getpid(), signal);
      sleep(60);
      _exit(2);
    };
    EXPECT_EXIT(interrupt_twice(), testing::KilledBySignal(signal), "");
  }
}

// As METIS has one for a while. Without threads that libraries made before (identify/base/command_line.cc).
TEST_F(CatchInterruptsTest, HandlersOfOthersAreNotCalled) {
  setenv("OPENBLAS_NUM_THREADS", "1", /*overwrite=*/1);
  const auto with_another_handler = [] {
    CatchInterrupts();
    signal(SIGTERM, [](int) { _exit(1); });
    std::thread([] { SendAndWait(SIGTERM); }).join();
    _exit(0);
  };
  EXPECT_EXIT(with_another_handler(), testing::ExitedWithCode(0), "");
}

TEST_F(CatchInterruptsTest, WhatIsIgnoredStaysIgnored) {
  const auto with_nohup = [] {
    signal(SIGHUP, SIG_IGN);
    CatchInterrupts();
    kill(getpid(), SIGHUP);
    if (IsInterrupted()) _exit(1);
    SendAndWait(SIGTERM);
    _exit(0);
  };
  EXPECT_EXIT(with_nohup(), testing::ExitedWithCode(0), "");
}

}  // namespace
}  // namespace clothid::program_test
