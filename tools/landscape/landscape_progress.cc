#include "tools/landscape/landscape_progress.h"

#include <iomanip>
#include <sstream>

namespace clothid {
namespace {

using Seconds = std::chrono::duration<double>;

// Between two lines; on a terminal often enough to look alive.
constexpr Seconds kTerminalInterval(0.1), kPlainInterval(10.0);

}  // namespace

LandscapeProgress::LandscapeProgress(std::ostream* out, bool is_terminal) : out_(out), is_terminal_(is_terminal) {}

LandscapeProgress::~LandscapeProgress() {
  if (has_open_line_) *out_ << "\n" << std::flush;
}

void LandscapeProgress::Print(int num_done, int num_cells, int num_kept) {
  const Clock::time_point now = Clock::now();
  if (num_done < num_cells && now - last_ < (is_terminal_ ? kTerminalInterval : kPlainInterval)) return;
  last_ = now;
  const double rate = (num_done - num_kept) / Seconds(now - start_).count();
  std::ostringstream line;
  line << "cells " << num_done << " of " << num_cells << std::setprecision(3) << "  " << rate << " cells/s  "
       << std::fixed << std::setprecision(0) << (num_cells - num_done) / rate << " s left";
  if (!is_terminal_) {
    *out_ << line.str() << "\n" << std::flush;
    return;
  }
  const char kEraseToEnd[] = "\033[K";
  *out_ << "\r" << line.str() << kEraseToEnd << std::flush;
  has_open_line_ = true;
}

}  // namespace clothid
