// A recording as it stands in a file, before its numbers are given a meaning.
#ifndef CLOTHID_DATASETS_MOTION_MOTION_TENSORS_H_
#define CLOTHID_DATASETS_MOTION_MOTION_TENSORS_H_

#include <Eigen/Core>
#include <string>
#include <string_view>
#include <vector>

#include "datasets/motion/force_readings.h"
#include "sim/mesh/mesh.h"
#include "sim/scene/obstacle_json.h"

namespace clothid {

inline constexpr std::string_view kSequencePrefix = "sequence.";  // of the names of tensors

// The tensors and strings of a motion file (datasets/motion/motion_file.h).
struct MotionTensors {
  Eigen::VectorXd times;         // [T]
  Eigen::MatrixXd positions;     // [3P x T]
  bool single_precision = true;  // positions are stored as F32
  Mesh mesh;
  std::vector<int> node_index;           // [P] or empty
  std::vector<int> face_index;           // [P] or empty
  Eigen::Matrix3Xd barycentric;          // [3 x P] or empty
  std::vector<int> point_kind;           // [P] of PointKind, or empty: all are material
  std::vector<int> handle_index;         // [H] or empty
  Eigen::MatrixXd handle_positions;      // [3H x T], [3H x K] or empty
  Eigen::VectorXd handle_times;          // [K], or empty: the times of the frames
  Eigen::VectorXd sigma;                 // [P] or empty
  std::vector<Eigen::Matrix3Xd> clouds;  // [T] or empty
  bool single_precision_clouds = true;   // they are stored as F32
  double cloud_sigma = 0.0;              // 0: not known
  ForceReadings forces;                  // or empty
  RecordedSequences sequences;           // or empty
  std::string scene_text;
  std::string provenance;
};

}  // namespace clothid

#endif  // CLOTHID_DATASETS_MOTION_MOTION_TENSORS_H_
