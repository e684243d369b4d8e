// What pages show of a recording over time: a 3D replay of the recorded and the predicted cloth, obstacles and handles;
// forces.
#ifndef CLOTHID_IDENTIFY_REPORT_REPORT_REPLAY_H_
#define CLOTHID_IDENTIFY_REPORT_REPORT_REPLAY_H_

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstddef>
#include <nlohmann/json.hpp>

#include "datasets/motion/recorded_motion.h"

namespace clothid {

struct ReplaySource {
  const RecordedMotion* motion = nullptr;
  const Eigen::MatrixXd* predicted = nullptr;      // [3P x T] m; null: a recording by itself
  const Eigen::MatrixXd* nodes = nullptr;          // [3N x T] m of the whole cloth; null: not known
  const Eigen::MatrixXd* point_errors = nullptr;   // [P x T] m, NaN: none; with `predicted`
  const Eigen::MatrixXd* handles = nullptr;        // [3H x T] m where the handles are; null: not shown
  const Eigen::MatrixXd* missing_force = nullptr;  // [N x T] N/m^2, with nodes; null: not shown
  const Eigen::MatrixXd* start = nullptr;          // [3N x 1] m where a simulation starts; null: not shown
  // What the picture is about, m; empty: what is predicted, or else all. Points that are farther off than its diagonal
  // are left out: a single one would coarsen the numbers of all others.
  Eigen::AlignedBox3d middle = {};
};

// Whether point p of `motion` is node p of its mesh, for all nodes.
bool PointsAreNodes(const RecordedMotion& motion);

// The replay of one recording, in at most `max_bytes` of JSON: of a long or large one every k-th frame, of one that is
// too large nothing but a note. Arrays as in identify/report/packed_array.h: "recorded" and "predicted" [frames x P x
// 3], "nodes" [frames x N x 3] where the points are not the nodes, and "errors" [frames x P], bytes q that stand for
// largest 10^(-6 (1 - q/254)), 255 for none, and "missing_force" [frames x N] likewise; "handle_path" [frames x H x 3]
// and "start" [N x 3]. "middle": the two corners of that box. What the source does not have is absent. Obstacles of a
// type that is not known here are named in "notes".
nlohmann::ordered_json ReplayJson(const ReplaySource& source, std::size_t max_bytes);

// The forces at handles: "times", "groups", their number, and "components", of each that was measured {"group" from 1,
// "axis" "x", "y" or "z", "measured", "predicted"}, N; thinned by leaving readings out to about `max_bytes`.
// `predicted` [3G x F] N may be null.
nlohmann::ordered_json ForcesJson(const ForceReadings& forces, const Eigen::MatrixXd* predicted, std::size_t max_bytes);

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_REPORT_REPORT_REPLAY_H_
