// A recording as a page by itself that any browser opens, without a fit.
#ifndef CLOTHID_IDENTIFY_VIEW_VIEW_PAGE_H_
#define CLOTHID_IDENTIFY_VIEW_VIEW_PAGE_H_

#include <Eigen/Core>
#include <string>
#include <utility>
#include <vector>

#include "datasets/motion/recorded_motion.h"

namespace clothid {

// The text of view.html: the replay of `motion` with its handles, their path, the obstacles and the start of a
// simulation, forces and wind over time, and what `CheckMotion` finds, with the frames that it names. The page is like
// that of a fit (identify/report/report_page.h): one file below kMaxReportBytes that asks no server for anything, in
// which names are shown and never run. As for `CheckMotion`, the paths of handles should be read without smoothing.
// `is_simulated`: the page is about the scene of `motion`, which was simulated to look at it.
std::string ViewHtml(const RecordedMotion& motion, bool is_simulated = false);

// Lines over time, each of its own name.
struct ViewChart {
  std::string name, unit;
  Eigen::VectorXd times;                                       // [T] s
  std::vector<std::pair<std::string, Eigen::VectorXd>> lines;  // [T] each; NaN is a gap
};

// What is shown of a prediction beside its median.
struct PredictionView {
  std::string status;                   // a few words: until when it is worth something
  std::vector<std::string> facts;       // a line each: what was drawn, what dominates
  std::vector<Eigen::MatrixXd> cloths;  // [3N x T] m of some draws, of the scene's nodes in the frames of the median
  std::vector<ViewChart> charts;
};

// The page of a prediction with the median `median`, whose frames are nodes, like the page above: the nodes of all
// cloths are points in the replay, charts take the place of findings.
std::string PredictionHtml(RecordedMotion median, const PredictionView& view);

// For programs, before they work long. Throws `Error`: kUsage, naming `flag`, unless `path` ends in ".html" or is a
// device or a pipe, kIo where it cannot be written, as far as can be told beforehand.
void CheckPageOutput(const std::string& flag, const std::string& path);

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_VIEW_VIEW_PAGE_H_
