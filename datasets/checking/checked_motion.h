// A recording with what several findings about it need. Internal to datasets/checking.
#ifndef CLOTHID_DATASETS_CHECKING_CHECKED_MOTION_H_
#define CLOTHID_DATASETS_CHECKING_CHECKED_MOTION_H_

#include <Eigen/Core>
#include <vector>

#include "datasets/checking/track_statistics.h"
#include "datasets/motion/recorded_motion.h"

namespace clothid {

// Up to so many points their order is looked at.
inline constexpr Eigen::Index kMaxOrderPoints = 20000;

// Keeps a reference to the recording.
struct CheckedMotion {
  explicit CheckedMotion(const RecordedMotion& recorded);

  // What is seen of the cloth in a frame [3 x M] m: points of its cloud, at most 1000 of them; those and the tracked
  // points.
  Eigen::Matrix3Xd Cloud(int frame) const;
  Eigen::Matrix3Xd Places(int frame) const;
  // m: less is no jump of a point.
  double point_jump_floor() const;

  const RecordedMotion& motion;
  Eigen::Matrix3Xd rest_points;  // [3 x P] m: the points on the mesh at rest
  std::vector<bool> is_held;     // [P] whether all nodes of a point are handles: it is not compared
  std::vector<PointPair> pairs;  // neighbours; empty where the points are too few or too many to find them
  double spacing = 0.0;          // m: median distance of neighbours at rest; without pairs that of edges of the mesh
  double cloth_size = 0.0;       // m
  bool stands_out = false;       // a cloth so stiff that it does not hang from where it is held
  double median_interval = 0.0;  // s
  NoiseEstimate noise;
  double noise_floor = 0.0;  // m: three times the noise of a coordinate, as the file says or as it is estimated; of
                             // clouds without points as the file says
};

}  // namespace clothid

#endif  // CLOTHID_DATASETS_CHECKING_CHECKED_MOTION_H_
