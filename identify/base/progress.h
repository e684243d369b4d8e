// Progress of a fit for people.
#ifndef CLOTHID_IDENTIFY_BASE_PROGRESS_H_
#define CLOTHID_IDENTIFY_BASE_PROGRESS_H_

#include <functional>
#include <ostream>
#include <string>
#include <vector>

#include "identify/base/evaluation_progress.h"
#include "identify/base/options.h"

namespace clothid {

// On a terminal one line is rewritten, with rate and time left; elsewhere every iteration is a line of its own, without
// the estimate of time. Evaluations that take long, a second on a terminal and ten elsewhere, tell where they are:
//   evaluation 8, reverse sweep: step 120 of 299, about 14 s left; fit: at most 47 iterations and 33 min more
// on a terminal below the line of the iteration, elsewhere when nothing was told for ten seconds. Times are told once
// ten steps and three iterations were timed. A line that is rewritten is cut where the terminal ends; one that stays is
// whole.
class ProgressPrinter {
 public:
  // `out` must outlive the printer. The time left of a fit is that until `max_iterations`, as if they took as long as
  // those so far; a fit converges earlier. `clock`: s, from any origin on; empty: the steady one. `columns`: how wide
  // the terminal is, 0 where that is not known; empty: 0.
  ProgressPrinter(std::ostream* out, bool is_terminal, int max_iterations, std::function<double()> clock = {},
                  std::function<int()> columns = {});
  ~ProgressPrinter();
  ProgressPrinter(const ProgressPrinter&) = delete;
  ProgressPrinter& operator=(const ProgressPrinter&) = delete;

  void Print(const std::vector<std::string>& names, const FitIteration& iteration);
  void Print(const EvaluationProgress& progress);
  // Heads the lines of one fit of several; `start` counts from 0.
  void PrintStart(int start, int num_starts);
  // The length of the plan, before its first stage, and every stage that begins or is skipped.
  void PrintStage(const FitPlan& plan, int stage);
  // No iterations of the fit follow: evaluations from now on are of something else. Whoever writes to `out` next finds
  // a line of their own.
  void EndFit();

 private:
  // What a terminal's last line, still without its end, is about.
  enum class OpenLine { kNone, kIteration, kStep };

  void EndLine();
  void Rewrite(const std::string& line, OpenLine what);
  // `line`, or its begin and "..." where the terminal has no room for it.
  std::string Cut(const std::string& line) const;
  bool IsDue(const EvaluationProgress& progress) const;
  std::string FitLeft() const;

  std::ostream* out_;
  bool is_terminal_;
  int max_iterations_;
  std::function<double()> clock_;
  std::function<int()> columns_;
  OpenLine open_line_ = OpenLine::kNone;
  std::string open_text_;  // of that line, uncut
  double last_output_;     // when, s
  // The fit under way. Iterations without a step were replayed from a journal, and say nothing about those to come.
  bool has_stepped_ = false;    // since the last iteration
  int num_timed_ = 0;           // iterations with steps
  double timed_seconds_ = 0.0;  // that they took
  double last_seconds_ = 0.0;   // of the last iteration, since the start of the fit
  int iterations_left_ = 0;     // at most
};

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_BASE_PROGRESS_H_
