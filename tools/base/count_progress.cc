#include "tools/base/count_progress.h"

#include <chrono>
#include <iomanip>
#include <sstream>
#include <utility>

#include "sim/base/phase_seconds.h"

namespace clothid {
namespace {

// s. Between two lines, on a terminal often enough to look alive; and, where the end is quiet, before the first one.
constexpr double kTerminalInterval = 0.1, kPlainInterval = 10.0, kTerminalPatience = 1.0;

}  // namespace

CountProgress::CountProgress(std::ostream* out, bool is_terminal, const std::string& items, End end,
                             std::function<double()> clock)
    : out_(out),
      is_terminal_(is_terminal),
      items_(items),
      end_(end),
      clock_(clock ? std::move(clock) : SteadySeconds),
      start_(clock_()),
      last_(start_) {}

CountProgress::~CountProgress() {
  if (has_open_line_) *out_ << "\n" << std::flush;
}

bool CountProgress::IsDue(double now, bool is_last) const {
  if (is_last) return end_ == End::kTold || has_open_line_;
  if (is_terminal_ && end_ == End::kQuiet && now - start_ < kTerminalPatience) return false;
  return now - last_ >= (is_terminal_ ? kTerminalInterval : kPlainInterval);
}

void CountProgress::Print(int num_done, int num_items, int num_kept) {
  const double now = clock_();
  if (!IsDue(now, num_done >= num_items)) return;
  last_ = now;
  const double rate = (num_done - num_kept) / (now - start_);
  std::ostringstream line;
  line << items_ << " " << num_done << " of " << num_items << std::setprecision(3) << "  " << rate << " " << items_
       << "/s  " << std::fixed << std::setprecision(0) << (num_items - num_done) / rate << " s left";
  if (!is_terminal_) {
    *out_ << line.str() << "\n" << std::flush;
    return;
  }
  const char kEraseToEnd[] = "\033[K";
  *out_ << "\r" << line.str() << kEraseToEnd << std::flush;
  has_open_line_ = true;
}

}  // namespace clothid
