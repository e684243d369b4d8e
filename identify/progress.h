// Progress of a fit for people.
#ifndef CLOTHID_IDENTIFY_PROGRESS_H_
#define CLOTHID_IDENTIFY_PROGRESS_H_

#include <ostream>
#include <string>
#include <vector>

#include "identify/options.h"

namespace clothid {

// On a terminal one line is rewritten, with rate and time left; elsewhere every iteration is a line of its own, without
// the estimate of time.
class ProgressPrinter {
 public:
  // `out` must outlive the printer. The time left is that until `max_iterations`; a fit converges earlier.
  ProgressPrinter(std::ostream* out, bool is_terminal, int max_iterations);
  ~ProgressPrinter();
  ProgressPrinter(const ProgressPrinter&) = delete;
  ProgressPrinter& operator=(const ProgressPrinter&) = delete;

  void Print(const std::vector<std::string>& names, const FitIteration& iteration);
  // Heads the lines of one fit of several; `start` counts from 0.
  void PrintStart(int start, int num_starts);

 private:
  void EndLine();

  std::ostream* out_;
  bool is_terminal_;
  int max_iterations_;
  bool has_open_line_ = false;
};

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_PROGRESS_H_
