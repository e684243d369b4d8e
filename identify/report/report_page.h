// report.html: a fit as a page by itself that any browser opens.
#ifndef CLOTHID_IDENTIFY_REPORT_REPORT_PAGE_H_
#define CLOTHID_IDENTIFY_REPORT_REPORT_PAGE_H_

#include <cstddef>
#include <string>
#include <vector>

#include "datasets/motion/recorded_motion.h"
#include "identify/fit/fit.h"
#include "identify/verdict/verdict.h"

namespace clothid {

// What a page stays below, whatever the size of the recordings.
inline constexpr std::size_t kMaxReportBytes = 5000000;

// The text of report.html: verdict, estimates with intervals, what limits the fit, convergence, residuals, repetitions,
// profiles, landscapes, fields, provenance, and a 3D replay of every recording. One file: the plotting library is
// inside, with its licences, no address of a server is asked for anything, and its Content-Security-Policy lets no
// browser do so. Whatever names hold is shown, never run. The same on repeated runs but for the seconds, which all
// stand under keys "seconds". The fit must have an estimate; `checks.predicted_nodes` may be empty. Throws `Error`
// where `Observation` does.
std::string ReportHtml(const FitSummary& summary, const FitChecks& checks, const std::vector<RecordedMotion>& motions);

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_REPORT_REPORT_PAGE_H_
