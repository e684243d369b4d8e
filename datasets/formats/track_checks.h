// What every reader and writer of point tracks asks of them. Internal to datasets/. Messages count frames and points
// from 0.
#ifndef CLOTHID_DATASETS_FORMATS_TRACK_CHECKS_H_
#define CLOTHID_DATASETS_FORMATS_TRACK_CHECKS_H_

#include <cstdint>
#include <string>

#include "datasets/formats/point_tracks.h"

namespace clothid {

// The most that the positions of a file may take in memory: what a motion.bin may hold.
inline constexpr std::uint64_t kMaxTrackBytes = std::uint64_t{1} << 32;

// Throws `Error` (kBadData), prefixed by `source`, unless there are 1 to kMaxNodes (sim/mesh/mesh.h) points, 1 to
// kMaxFrames frames, and the positions fit into kMaxTrackBytes: to be asked before they are allocated.
void CheckTrackSize(const std::string& source, std::uint64_t num_points, std::uint64_t num_frames);

// Throws `Error` (kBadData), prefixed by `source`, unless the times of frames are finite and strictly increasing.
void CheckIncreasing(const std::string& source, const Eigen::VectorXd& times);

// Throws `Error` (kBadData), prefixed by the name of `tracks`, unless its sizes are as above and agree with each other,
// times are finite and strictly increasing, numbers of frames, too, positions finite or NaN, and faces made of its
// points.
void CheckTracks(const PointTracks& tracks);

// Throws `Error` (kUsage) naming `format` unless `tracks` has times, every point is seen in every frame, or the labels
// differ from each other and hold no control characters.
void RequireTimes(const PointTracks& tracks, const std::string& format);
void RequireEveryPoint(const PointTracks& tracks, const std::string& format);
void RequirePlainLabels(const PointTracks& tracks, const std::string& format);

}  // namespace clothid

#endif  // CLOTHID_DATASETS_FORMATS_TRACK_CHECKS_H_
