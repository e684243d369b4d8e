// What the 3D replay of report.html shows: recorded and predicted cloth over time, obstacles, handles.
#ifndef CLOTHID_IDENTIFY_REPORT_REPORT_REPLAY_H_
#define CLOTHID_IDENTIFY_REPORT_REPORT_REPLAY_H_

#include <Eigen/Core>
#include <cstddef>
#include <nlohmann/json.hpp>

#include "datasets/motion/recorded_motion.h"

namespace clothid {

struct ReplaySource {
  const RecordedMotion* motion = nullptr;
  const Eigen::MatrixXd* predicted = nullptr;     // [3P x T] m
  const Eigen::MatrixXd* nodes = nullptr;         // [3N x T] m of the whole cloth; null: not known
  const Eigen::MatrixXd* point_errors = nullptr;  // [P x T] m, NaN: none
};

// Whether point p of `motion` is node p of its mesh, for all nodes.
bool PointsAreNodes(const RecordedMotion& motion);

// The replay of one recording, in at most `max_bytes` of JSON: of a long or large one every k-th frame, of one that is
// too large nothing but a note. Arrays as in identify/report/packed_array.h: "recorded" and "predicted" [frames x P x
// 3], "nodes" [frames x N x 3] where the points are not the nodes, and "errors" [frames x P], bytes q that stand for
// largest 10^(-6 (1 - q/254)), 255 for none. Obstacles of a type that is not known here are named in "notes".
nlohmann::ordered_json ReplayJson(const ReplaySource& source, std::size_t max_bytes);

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_REPORT_REPORT_REPLAY_H_
