// Measured data with its scene.
#ifndef CLOTHID_DATASETS_MOTION_RECORDED_MOTION_H_
#define CLOTHID_DATASETS_MOTION_RECORDED_MOTION_H_

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "datasets/motion/force_readings.h"
#include "sim/scene/scene.h"

namespace clothid {

// What is known of where an observed point lies on the cloth. The numbers are those of files.
enum class PointKind {
  kMaterial = 0,  // it is the same point of the cloth in all frames
  kSurface = 1,   // it lies on the cloth, in every frame somewhere else
  kBorder = 2,    // it lies on the border of the cloth, likewise
};

// An observed point: a mesh node, or a point on a triangle. predicted = sum_k weights[k] x[nodes[k]]. Of a point that
// is not material that is no more than about where it lies: it is compared with the surface
// (datasets/observation/cloud_observation.h).
struct ObservedPoint {
  int num_nodes = 1;  // 1 (a node) or 3 (barycentric)
  int nodes[3] = {0, 0, 0};
  double weights[3] = {1.0, 0.0, 0.0};
  PointKind kind = PointKind::kMaterial;
};

// Where a recording's sigma comes from.
enum class SigmaSource {
  kUnknown,    // nobody knows it: residuals are whitened by a guess (datasets/observation/observation.h)
  kRecorded,   // the recording
  kGiven,      // the user
  kEstimated,  // the recording's own scatter in time (datasets/motion/noise_estimate.h)
};

// Where the start of a rollout comes from.
enum class StartSource {
  kScene,       // `initial` of the scene
  kFirstFrame,  // the first frame
  kSmoothed,    // the first frames, made a shape that the cloth can have (datasets/motion/start_state.h)
  kRest,        // nobody knows it exactly: as smoothed, and a fit estimates the positions; released at rest
  kMoving,      // the same, and the velocities with them
  kEstimated,   // asks for one of these two: kMoving, unless the first frames show no velocity; no recording has it
};

// Whether a fit estimates the start (costs/start/unknown_start.h).
inline bool IsUnknown(StartSource source) {
  return source == StartSource::kRest || source == StartSource::kMoving || source == StartSource::kEstimated;
}

// What was measured of handles whose place is not known exactly: their measured positions less the path that the scene
// has of them.
struct HandleMeasurements {
  Eigen::VectorXd times;       // [K] s
  Eigen::MatrixXd deviations;  // [3H x K] m, in the order of the scene's handles; NaN: not seen
  Eigen::VectorXd sigma;       // [H] m, standard deviation of a coordinate

  bool is_empty() const { return sigma.size() == 0; }
};

struct RecordedMotion {
  std::string name;                   // for messages: the file it came from
  Eigen::VectorXd times;              // [T] s, strictly increasing
  Eigen::MatrixXd positions;          // [3P x T] m; NaN: not seen
  std::vector<ObservedPoint> points;  // [P]
  Eigen::VectorXd sigma;              // [P] m, standard deviation of a coordinate; empty: not known
  // [T], or empty: unordered points of the cloth's surface seen in every frame [3 x M_i] m, beside the tracked ones
  // (of which there may be none).
  std::vector<Eigen::Matrix3Xd> clouds;
  double cloud_sigma = 0.0;  // m, standard deviation of a coordinate of theirs; 0: not known
  ForceReadings forces;      // or empty
  // m, of the measured points as they were before some of them were held out; absent: none were.
  std::optional<Eigen::Vector3d> centroid;
  Scene scene;  // with mesh, start state and duration of this recording
  SigmaSource sigma_source = SigmaSource::kUnknown;
  StartSource start_source = StartSource::kScene;
  HandleMeasurements handle_measurements;  // of an unknown start alone; empty: the path of the handles is exact
  std::string scene_text;  // the JSON that the scene was read from, with the surfaces of obstacles in it
  std::string provenance;
  std::string sha256;  // of the file

  int num_frames() const { return static_cast<int>(times.size()); }
  int num_points() const { return static_cast<int>(points.size()); }
};

}  // namespace clothid

#endif  // CLOTHID_DATASETS_MOTION_RECORDED_MOTION_H_
