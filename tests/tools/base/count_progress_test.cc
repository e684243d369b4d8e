// What a terminal and a log are told of long work, and of short work.
#include "tools/base/count_progress.h"

#include <gtest/gtest.h>

#include <sstream>
#include <string>

namespace clothid::count_progress_test {
namespace {

using End = CountProgress::End;

// Ten items of `seconds` each.
std::string Told(bool is_terminal, End end, double seconds) {
  std::ostringstream out;
  double now = 5.0;
  {
    CountProgress progress(&out, is_terminal, "steps", end, [&] { return now; });
    for (int i = 1; i <= 10; ++i) {
      now += seconds;
      progress.Print(i, 10);
    }
  }
  return out.str();
}

TEST(CountProgressTest, ALogGetsALineInTenSeconds) {
  EXPECT_EQ(Told(false, End::kQuiet, 4.0),
            "steps 3 of 10  0.25 steps/s  28 s left\n"
            "steps 6 of 10  0.25 steps/s  16 s left\n"
            "steps 9 of 10  0.25 steps/s  4 s left\n");
  EXPECT_EQ(Told(false, End::kTold, 4.0), Told(false, End::kQuiet, 4.0) + "steps 10 of 10  0.25 steps/s  0 s left\n");
}

TEST(CountProgressTest, ATerminalGetsOneLineThatIsRewritten) {
  EXPECT_EQ(Told(true, End::kQuiet, 0.4),
            "\rsteps 3 of 10  2.5 steps/s  3 s left\033[K\rsteps 4 of 10  2.5 steps/s  2 s left\033[K"
            "\rsteps 5 of 10  2.5 steps/s  2 s left\033[K\rsteps 6 of 10  2.5 steps/s  2 s left\033[K"
            "\rsteps 7 of 10  2.5 steps/s  1 s left\033[K\rsteps 8 of 10  2.5 steps/s  1 s left\033[K"
            "\rsteps 9 of 10  2.5 steps/s  0 s left\033[K\rsteps 10 of 10  2.5 steps/s  0 s left\033[K\n");
}

TEST(CountProgressTest, ShortWorkIsQuietWhereItIsToBe) {
  EXPECT_EQ(Told(true, End::kQuiet, 0.09), "");
  EXPECT_EQ(Told(false, End::kQuiet, 0.9), "");
  EXPECT_EQ(Told(false, End::kTold, 0.5), "steps 10 of 10  2 steps/s  0 s left\n");
}

TEST(CountProgressTest, WhatWasDoneBeforeDoesNotCountForTheRate) {
  std::ostringstream out;
  double now = 0.0;
  CountProgress progress(&out, false, "cells", End::kTold, [&] { return now; });
  now = 20.0;
  progress.Print(60, 100, 50);
  EXPECT_EQ(out.str(), "cells 60 of 100  0.5 cells/s  80 s left\n");
}

}  // namespace
}  // namespace clothid::count_progress_test
