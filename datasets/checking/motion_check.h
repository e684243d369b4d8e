// What is known of a recording before any fit: whether its time, its points, its unit, its frame of reference and its
// scene can be what they are said to be. Nothing is simulated.
#ifndef CLOTHID_DATASETS_CHECKING_MOTION_CHECK_H_
#define CLOTHID_DATASETS_CHECKING_MOTION_CHECK_H_

#include <string>
#include <vector>

#include "datasets/checking/finding.h"
#include "datasets/motion/recorded_motion.h"

namespace clothid {

// In this order, where they apply: frame rate, gaps, missing points, repeated frames, points and places, noise, order
// of points, jumps of the cloth, jumps of points, edge lengths, places of points, first frame, start velocity, size and
// place of clouds, handles, jumps and distance and start and path of handles, start, contact, self-contact, direction
// of gravity, held points, fall, swing, energy, size of the cloth, gravity, density, time step. After a problem what it
// makes void is left out. Findings that are rare are listed only where they are not ok. For `motion check` the paths of
// handles are read without smoothing; the jumps of smoothed ones are small.
std::vector<Finding> CheckMotion(const RecordedMotion& motion);

// The gravest among them.
Severity Worst(const std::vector<Finding>& findings);

// A table for people, a line per finding and one per hint; and {"schema": "clothid.check/1", "file", "verdict",
// "findings": [{"what", "verdict", "value", "hint", "frames", "points"}]}, in which severities are called verdicts.
std::string FindingsTable(const std::vector<Finding>& findings);
std::string FindingsJson(const std::vector<Finding>& findings, const std::string& file);

}  // namespace clothid

#endif  // CLOTHID_DATASETS_CHECKING_MOTION_CHECK_H_
