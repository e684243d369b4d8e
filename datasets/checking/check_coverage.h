// Findings about the times of a recording, and about which points were seen at them.
#ifndef CLOTHID_DATASETS_CHECKING_CHECK_COVERAGE_H_
#define CLOTHID_DATASETS_CHECKING_CHECK_COVERAGE_H_

#include <Eigen/Core>
#include <string>
#include <vector>

#include "datasets/checking/checked_motion.h"
#include "datasets/checking/finding.h"

namespace clothid {

// Frame rate, gaps, missing points; frames, points and places that are copies of others, where there are any.
std::vector<Finding> CheckCoverage(const CheckedMotion& checked);
// Frame rate and gaps alone, for clouds without tracked points.
std::vector<Finding> CheckTimes(const CheckedMotion& checked);
// The places, the same to the last bit in several frames or of several points, in which points are far from their
// neighbours: what a program writes for points that were not seen. Of points at rest nothing is said, nor of a single
// one that is off in `repeated_frames` (ascending).
std::vector<Finding> CheckRepeatedPlaces(const CheckedMotion& checked, const std::vector<int>& repeated_frames);
// Where a path with the positions [3P x K] m of points at `times` [K >= 2] s is not known although they move, in words:
// "0.5 s from 0.6 s on, all after its end at 1.2 s". Empty where it is known.
std::string UnknownTimes(const CheckedMotion& checked, const Eigen::VectorXd& times, const Eigen::MatrixXd& positions);
// Whether the path of the handles is known all the time; for handles that move. Empty where it is.
std::vector<Finding> CheckPathTimes(const CheckedMotion& checked);
// The time step of the scene against the frame rate.
Finding CheckTimeStep(const CheckedMotion& checked);

}  // namespace clothid

#endif  // CLOTHID_DATASETS_CHECKING_CHECK_COVERAGE_H_
