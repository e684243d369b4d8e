// How good a fit is, frame by frame and point by point, and what limits it.
#ifndef CLOTHID_IDENTIFY_REPORT_FIT_QUALITY_H_
#define CLOTHID_IDENTIFY_REPORT_FIT_QUALITY_H_

#include <Eigen/Core>
#include <string>
#include <vector>

#include "datasets/motion/recorded_motion.h"
#include "datasets/observation/observation.h"
#include "identify/verdict/verdict.h"

namespace clothid {

// Distances |predicted - measured| [P x T] m over the coordinates of `observation`; a partly seen point counts by the
// coordinates that were seen, NaN where none was or the point has no residual.
Eigen::MatrixXd PointErrors(const Observation& observation, const RecordedMotion& motion,
                            const Eigen::MatrixXd& predicted);

// The root mean square of those that are not NaN; NaN where there is none.
double RootMeanSquare(const Eigen::VectorXd& errors);

// Of every column of `PointErrors` [T] m.
Eigen::VectorXd FrameErrors(const Eigen::MatrixXd& point_errors);

// Differences predicted - measured of one axis.
struct ResidualHistogram {
  std::vector<int> counts;  // of equal bins from -range to range
  int num_beyond = 0;       // outside of them
  double mean = 0.0;        // m; NaN where nothing was seen
  double deviation = 0.0;   // m, the standard deviation; NaN where nothing was seen
};

// Whether simulations of this recording start from its first frame: what is left of an error there tells nothing.
bool StartsAtFirstFrame(const RecordedMotion& motion);

// One histogram per axis, of `num_bins` bins from -range to range (m), without the first frame where
// `StartsAtFirstFrame`.
std::vector<ResidualHistogram> ResidualHistograms(const Observation& observation, const RecordedMotion& motion,
                                                  const Eigen::MatrixXd& predicted, double range, int num_bins);

// What keeps the error from being smaller, a sentence each: the noise that the recording states against what remains,
// the share of the error that lasts from frame to frame, points not seen, substeps. Recordings by observation, in
// order.
std::vector<std::string> FitLimits(const FitSummary& summary, const std::vector<RecordedMotion>& motions,
                                   const std::vector<Observation>& observations);

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_REPORT_FIT_QUALITY_H_
