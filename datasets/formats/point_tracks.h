// Points followed over time as a file of another program holds them: not yet bound to a mesh, a scene or its frame of
// reference.
#ifndef CLOTHID_DATASETS_FORMATS_POINT_TRACKS_H_
#define CLOTHID_DATASETS_FORMATS_POINT_TRACKS_H_

#include <Eigen/Core>
#include <string>
#include <vector>

namespace clothid {

// The most frames that a recording may have.
inline constexpr int kMaxFrames = 10000000;

struct PointTracks {
  std::string name;                 // for messages: the file or folder that it came from
  std::string times_name;           // the same of the times; empty: `name`
  Eigen::VectorXd times;            // [T] s, strictly increasing; empty: the file knows none
  Eigen::MatrixXd positions;        // [3P x T] in the file's own unit; NaN: not seen
  double units_per_metre = 1.0;     // by which the numbers of a file that tells its unit were divided
  std::vector<std::string> labels;  // [P] names of the points; empty: the file has none
  Eigen::Matrix3Xi faces;           // [3 x F] indices of points; empty: the file has none
  // [T] of the frames, from 0 on, of a sequence of files that leaves numbers out: 0, 1, 3 where the third file is
  // missing. Empty: frame i has number i.
  std::vector<long long> frame_numbers;
  double sample_rate = 1.0;  // of a PC2: frames of its animation per sample; some programs write frames per second

  int num_points() const { return static_cast<int>(positions.rows() / 3); }
  int num_frames() const { return static_cast<int>(positions.cols()); }
};

}  // namespace clothid

#endif  // CLOTHID_DATASETS_FORMATS_POINT_TRACKS_H_
