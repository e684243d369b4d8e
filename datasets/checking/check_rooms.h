// The parts of datasets/checking/motion_check.h, one function per finding or group of them. Internal to datasets/.
#ifndef CLOTHID_DATASETS_CHECKING_CHECK_ROOMS_H_
#define CLOTHID_DATASETS_CHECKING_CHECK_ROOMS_H_

#include <Eigen/Core>
#include <string>
#include <vector>

#include "datasets/checking/motion_check.h"
#include "datasets/checking/track_statistics.h"

namespace clothid {

// What several findings need. Keeps a reference to the recording.
struct CheckedMotion {
  explicit CheckedMotion(const RecordedMotion& recorded);

  const RecordedMotion& motion;
  Eigen::Matrix3Xd rest_points;  // [3 x P] m: the points on the mesh at rest
  std::vector<PointPair> pairs;  // neighbours; empty where the points are too few or too many to find them
  double spacing = 0.0;          // m: median distance of neighbours at rest; without pairs that of edges of the mesh
  double cloth_size = 0.0;       // m
  double median_interval = 0.0;  // s
  NoiseEstimate noise;
  double noise_floor = 0.0;  // m: three times the noise of a coordinate, as the file says or as it is estimated
};

// Times and what was seen: frame rate, gaps, missing points.
std::vector<Finding> CheckCoverage(const CheckedMotion& checked);
// All that can be said of clouds without tracked points: frame rate, gaps, time step.
std::vector<Finding> CheckTimes(const CheckedMotion& checked);

// Noise, order of points, jumps of the cloth and of points, edge lengths.
Finding CheckNoise(const CheckedMotion& checked);
Finding CheckOrder(const CheckedMotion& checked);
// `left_out`: frames that are known to be wrong.
std::vector<Finding> CheckJumps(const CheckedMotion& checked, const std::vector<int>& left_out);
Finding CheckEdges(const CheckedMotion& checked);

// The scene against the points; each may have nothing to say.
std::vector<Finding> CheckHandles(const CheckedMotion& checked);
std::vector<Finding> CheckContact(const CheckedMotion& checked, bool* touches);  // the start, and what is touched
std::vector<Finding> CheckGravity(const CheckedMotion& checked);                 // where nothing is touched
Finding CheckTimeStep(const CheckedMotion& checked);

// For values and hints: three digits; a length in mm; "frames 3, 7, .. (12 of them)", with "frame" for one.
std::string Rounded(double value);
std::string Millimetres(double length);
std::string Named(const std::string& what, const std::vector<int>& numbers);

}  // namespace clothid

#endif  // CLOTHID_DATASETS_CHECKING_CHECK_ROOMS_H_
