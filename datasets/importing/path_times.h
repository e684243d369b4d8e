// The times of paths from files against the frames of a recording. Internal to datasets/importing.
#ifndef CLOTHID_DATASETS_IMPORTING_PATH_TIMES_H_
#define CLOTHID_DATASETS_IMPORTING_PATH_TIMES_H_

#include <Eigen/Core>
#include <string>

namespace clothid {

// Throws `Error` (kBadData), led by `source`: a path is known at times `known` [K] s, and frames are at `times` [T] s
// on the same clock; expected `expected`.
[[noreturn]] void FailOfClock(const Eigen::VectorXd& known, const Eigen::VectorXd& times, const std::string& source,
                              const std::string& expected);

// Throws as above where a frame lies outside of `known` by more than its longest interval: a wrong clock. One time
// alone is that of what stands still.
void ExpectCovered(const Eigen::VectorXd& known, const Eigen::VectorXd& times, const std::string& source);

// Throws as above for three times or more that no clock in s can have: 500 s and more from one to the next, by the
// median. They look like those of one in us or ns.
void ExpectSeconds(const Eigen::VectorXd& times, const std::string& source);

// `count` knots from `first` on.
struct KnotRange {
  Eigen::Index first = 0, count = 0;
};

// The knots that a path depends on at `times`: those between the first and the last, and two on either side, for slopes
// are those of parabolas through three.
KnotRange NeededKnots(const Eigen::VectorXd& knots, const Eigen::VectorXd& times);

}  // namespace clothid

#endif  // CLOTHID_DATASETS_IMPORTING_PATH_TIMES_H_
