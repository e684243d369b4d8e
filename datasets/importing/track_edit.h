// From the unit, the clock and the frame of reference of another program to those of a scene: m, s, world axes.
#ifndef CLOTHID_DATASETS_IMPORTING_TRACK_EDIT_H_
#define CLOTHID_DATASETS_IMPORTING_TRACK_EDIT_H_

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "datasets/formats/point_tracks.h"
#include "datasets/importing/missing_value.h"

namespace clothid {

// Positions that stand for points not seen become gaps; the others are multiplied by `scale`, then transformed. Times
// come from `times`, one per frame or per number of a sequence, else from `frame_rate`, else from the file; they are
// multiplied by `time_scale`, frames are left out, and the first frame left is put at `start_at`.
struct TrackEdit {
  MissingValues missing;  // in the numbers of the file
  double scale = 1.0;
  Eigen::Isometry3d transform = Eigen::Isometry3d::Identity();  // of positions in m
  Eigen::VectorXd times;                                        // [T] of every frame in the file; empty: not given
  std::string times_name;                                       // for messages: the file of `times`
  Eigen::VectorXd times_since_first;  // [T] see FrameTimes (clock_times.h); empty: `times` less the first of them
  double frame_rate = 0.0;            // Hz; 0: not given
  double time_scale = 1.0;
  std::optional<double> start_at;  // s
  int first_frame = 0;
  int end_frame = std::numeric_limits<int>::max();  // the first one that is left out
  std::vector<int> skipped_frames;                  // between them, left out too; any order
};

struct EditedTracks {
  PointTracks tracks;       // in m and s, with times
  std::vector<int> frames;  // [T] those of the file that were kept
  double time_shift = 0.0;  // s: what `start_at` added to all times
};

// The times of `count` frames at equal intervals from 0 s on. Where the names of their files leave numbers out, so do
// the times: `numbers` are those of PointTracks::frame_numbers. Throws `Error` (kBadData), led by `source`, where more
// numbers are left out than there are: those are no numbers of frames at this rate.
Eigen::VectorXd TimesAtRate(double frame_rate, Eigen::Index count, const std::vector<long long>& numbers,
                            const std::string& source);

// Times [T] given for all numbers of frames where the files leave some out: those of the files; else as they are.
Eigen::VectorXd TimesOfNumbers(const Eigen::VectorXd& times, const std::vector<long long>& numbers);

// Throws `Error`: kUsage for an edit that is out of range, or where neither file nor edit has times; kBadData, led by
// the file of the times, where these do not fit the frames or do not increase. Points that are seen in part are not
// seen where axes turn.
EditedTracks EditTracks(const PointTracks& tracks, const TrackEdit& edit);

}  // namespace clothid

#endif  // CLOTHID_DATASETS_IMPORTING_TRACK_EDIT_H_
