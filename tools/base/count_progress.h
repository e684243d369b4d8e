// Progress of work that is a number of like items, for people.
#ifndef CLOTHID_TOOLS_BASE_COUNT_PROGRESS_H_
#define CLOTHID_TOOLS_BASE_COUNT_PROGRESS_H_

#include <functional>
#include <ostream>
#include <string>

namespace clothid {

// "cells 12 of 33  4.1 cells/s  5 s left". On a terminal one line is rewritten; elsewhere there is a line of its own
// now and then.
class CountProgress {
 public:
  enum class End {
    kTold,   // the last item is always told of
    kQuiet,  // work that takes less than a second on a terminal, ten elsewhere, is not told of at all
  };

  // `items` names them ("cells"). `out` must outlive the progress. The rate counts from here. `clock`: s, from any
  // origin on; empty: the steady one.
  CountProgress(std::ostream* out, bool is_terminal, const std::string& items, End end,
                std::function<double()> clock = {});
  ~CountProgress();
  CountProgress(const CountProgress&) = delete;
  CountProgress& operator=(const CountProgress&) = delete;

  // `num_done` of `num_items` are done, `num_kept` of them by earlier runs.
  void Print(int num_done, int num_items, int num_kept = 0);

 private:
  bool IsDue(double now, bool is_last) const;

  std::ostream* out_;
  bool is_terminal_;
  std::string items_;
  End end_;
  std::function<double()> clock_;
  bool has_open_line_ = false;
  double start_, last_;  // s
};

}  // namespace clothid

#endif  // CLOTHID_TOOLS_BASE_COUNT_PROGRESS_H_
