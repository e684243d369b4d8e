// Progress of a scan for people.
#ifndef CLOTHID_TOOLS_LANDSCAPE_LANDSCAPE_PROGRESS_H_
#define CLOTHID_TOOLS_LANDSCAPE_LANDSCAPE_PROGRESS_H_

#include <chrono>
#include <ostream>

namespace clothid {

// "cells 12 of 33  4.1 cells/s  5 s left". On a terminal one line is rewritten; elsewhere there is a line of its own
// now and then. The last cell is always told of.
class LandscapeProgress {
 public:
  // `out` must outlive the progress. The rate counts from here.
  LandscapeProgress(std::ostream* out, bool is_terminal);
  ~LandscapeProgress();
  LandscapeProgress(const LandscapeProgress&) = delete;
  LandscapeProgress& operator=(const LandscapeProgress&) = delete;

  // `num_done` of `num_cells` are done, `num_kept` of them by earlier runs.
  void Print(int num_done, int num_cells, int num_kept);

 private:
  using Clock = std::chrono::steady_clock;

  std::ostream* out_;
  bool is_terminal_;
  bool has_open_line_ = false;
  Clock::time_point start_ = Clock::now(), last_ = start_;
};

}  // namespace clothid

#endif  // CLOTHID_TOOLS_LANDSCAPE_LANDSCAPE_PROGRESS_H_
