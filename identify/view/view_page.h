// A recording as a page by itself that any browser opens, without a fit.
#ifndef CLOTHID_IDENTIFY_VIEW_VIEW_PAGE_H_
#define CLOTHID_IDENTIFY_VIEW_VIEW_PAGE_H_

#include <string>

#include "datasets/motion/recorded_motion.h"

namespace clothid {

// The text of view.html: the replay of `motion` with its handles, their path, the obstacles and the start of a
// simulation, forces and wind over time, and what `CheckMotion` finds, with the frames that it names. The page is like
// that of a fit (identify/report/report_page.h): one file below kMaxReportBytes that asks no server for anything, in
// which names are shown and never run. As for `CheckMotion`, the paths of handles should be read without smoothing.
// `is_simulated`: the page is about the scene of `motion`, which was simulated to look at it.
std::string ViewHtml(const RecordedMotion& motion, bool is_simulated = false);

// For programs, before they work long. Throws `Error`: kUsage, naming `flag`, unless `path` ends in ".html" or is a
// device or a pipe, kIo where it cannot be written, as far as can be told beforehand.
void CheckPageOutput(const std::string& flag, const std::string& path);

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_VIEW_VIEW_PAGE_H_
