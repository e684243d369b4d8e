#include "identify/report/cloud_points.h"

#include <algorithm>
#include <limits>
#include <vector>

namespace clothid {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

int FreeNode(const Scene& scene) {
  int node = 0;
  const std::vector<int>& handles = scene.handles.nodes;
  while (std::find(handles.begin(), handles.end(), node) != handles.end()) ++node;
  return node;
}

}  // namespace

RecordedMotion CloudsAsPoints(const RecordedMotion& motion) {
  Eigen::Index largest = 0;
  for (const Eigen::Matrix3Xd& cloud : motion.clouds) largest = std::max(largest, cloud.cols());
  RecordedMotion shown = motion;
  shown.clouds.clear();
  shown.sigma.resize(0);
  ObservedPoint point;
  point.nodes[0] = FreeNode(motion.scene);
  for (ObservedPoint& own : shown.points) own.kind = PointKind::kMaterial;
  shown.points.resize(motion.points.size() + static_cast<std::size_t>(largest), point);
  shown.positions = Eigen::MatrixXd::Constant(3 * shown.num_points(), motion.num_frames(), kNaN);
  shown.positions.topRows(3 * motion.num_points()) = motion.positions;
  for (int frame = 0; frame < motion.num_frames() && !motion.clouds.empty(); ++frame) {
    const Eigen::Matrix3Xd& cloud = motion.clouds[static_cast<std::size_t>(frame)];
    shown.positions.col(frame).segment(3 * motion.num_points(), cloud.size()) = cloud.reshaped();
  }
  return shown;
}

Eigen::MatrixXd ClosestPoints(const Observation& observation, const Eigen::MatrixXd& predicted) {
  const CloudObservation& clouds = observation.clouds();
  const auto is_untracked = [](const SeenSurfacePoint& point) { return point.tracked < 0; };
  Eigen::Index largest = 0;
  for (int frame = 0; frame < observation.num_frames(); ++frame) {
    const std::vector<SeenSurfacePoint>& seen = clouds.points(frame);
    largest = std::max<Eigen::Index>(largest, std::count_if(seen.begin(), seen.end(), is_untracked));
  }
  const Eigen::Index num_tracked = 3 * observation.num_points();
  Eigen::MatrixXd points = Eigen::MatrixXd::Constant(num_tracked + 3 * largest, observation.num_frames(), kNaN);
  points.topRows(num_tracked) = predicted.topRows(num_tracked);
  for (int frame = 0; frame < observation.num_frames(); ++frame) {
    const Eigen::VectorXd nodes = predicted.col(frame).tail(3 * observation.num_nodes());
    const Eigen::Matrix3Xd closest = clouds.ClosestPoints(frame, nodes);
    for (Eigen::Index i = 0; i < closest.cols(); ++i) {
      const int tracked = clouds.points(frame)[static_cast<std::size_t>(i)].tracked;
      points.col(frame).segment<3>(tracked < 0 ? num_tracked + 3 * i : 3 * tracked) = closest.col(i);
    }
  }
  return points;
}

}  // namespace clothid
