#include "identify/progress.h"

#include <iomanip>
#include <sstream>

namespace clothid {

ProgressPrinter::ProgressPrinter(std::ostream* out, bool is_terminal, int max_iterations)
    : out_(out), is_terminal_(is_terminal), max_iterations_(max_iterations) {}

ProgressPrinter::~ProgressPrinter() { EndLine(); }

void ProgressPrinter::EndLine() {
  if (has_open_line_) *out_ << "\n" << std::flush;
  has_open_line_ = false;
}

void ProgressPrinter::PrintStart(int start, int num_starts) {
  EndLine();
  *out_ << "start " << start + 1 << " of " << num_starts << "\n" << std::flush;
}

void ProgressPrinter::Print(const std::vector<std::string>& names, const FitIteration& iteration) {
  std::ostringstream line;
  line << "iteration " << iteration.iteration << "  cost " << std::setprecision(6) << iteration.cost;
  for (std::size_t i = 0; i < names.size(); ++i) line << "  " << names[i] << " " << iteration.values[i];
  line << "  rollouts " << iteration.rollouts;
  if (!is_terminal_) {
    *out_ << line.str() << "\n" << std::flush;
    return;
  }
  if (iteration.iteration > 0) {
    const double seconds_each = iteration.seconds / iteration.iteration;
    line << std::setprecision(2) << "  " << seconds_each << " s/iteration, at most " << std::setprecision(3)
         << seconds_each * (max_iterations_ - iteration.iteration) << " s left";
  }
  const char kEraseToEnd[] = "\033[K";
  *out_ << "\r" << line.str() << kEraseToEnd << std::flush;
  has_open_line_ = true;
}

}  // namespace clothid
