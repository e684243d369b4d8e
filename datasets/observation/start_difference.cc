#include "datasets/observation/start_difference.h"

#include <algorithm>
#include <cmath>

#include "sim/mesh/mesh.h"

namespace clothid {
namespace {

constexpr double kNoticeable = 0.02;  // of the cloth's size
constexpr double kLarge = 0.1;
constexpr double kBeyondNoise = 2.0;

bool IsHeld(const Scene& scene, const ObservedPoint& point) {
  const std::vector<int>& handles = scene.handles.nodes;
  return std::all_of(point.nodes, point.nodes + point.num_nodes,
                     [&](int node) { return std::find(handles.begin(), handles.end(), node) != handles.end(); });
}

Eigen::VectorXd PointsOf(const RecordedMotion& motion, const Eigen::VectorXd& nodes) {
  Eigen::VectorXd points = Eigen::VectorXd::Zero(3 * motion.num_points());
  for (int p = 0; p < motion.num_points(); ++p) {
    const ObservedPoint& point = motion.points[p];
    for (int k = 0; k < point.num_nodes; ++k) {
      points.segment<3>(3 * p) += point.weights[k] * nodes.segment<3>(3 * point.nodes[k]);
    }
  }
  return points;
}

}  // namespace

bool StartDifference::is_noticeable() const { return rms > kNoticeable * cloth_size && !(rms <= kBeyondNoise * noise); }

bool StartDifference::is_large() const { return is_noticeable() && rms > kLarge * cloth_size; }

std::optional<StartDifference> DifferenceAtStart(const RecordedMotion& motion, const Eigen::VectorXd& predicted) {
  if (motion.start_source != StartSource::kScene || motion.num_frames() == 0) return std::nullopt;
  if (!(std::abs(motion.times[0] - motion.scene.start_time) <= 0.5 * motion.scene.time_step)) return std::nullopt;
  double squares = 0.0, noise_squares = 0.0, count = 0.0;
  for (int p = 0; p < motion.num_points(); ++p) {
    if (motion.points[p].kind != PointKind::kMaterial || IsHeld(motion.scene, motion.points[p])) continue;
    for (int axis = 0; axis < 3; ++axis) {
      const double measured = motion.positions(3 * p + axis, 0);
      if (std::isnan(measured)) continue;
      squares += std::pow(predicted[3 * p + axis] - measured, 2);
      if (motion.sigma.size() > 0) noise_squares += motion.sigma[p] * motion.sigma[p];
      count += 1.0;
    }
  }
  if (count == 0.0) return std::nullopt;
  StartDifference difference;
  difference.rms = std::sqrt(3.0 * squares / count);
  if (motion.sigma.size() > 0) difference.noise = std::sqrt(3.0 * noise_squares / count);
  difference.cloth_size = ClothSize(motion.scene.mesh);
  return difference;
}

std::optional<StartDifference> DifferenceAtStart(const RecordedMotion& motion) {
  if (motion.scene.initial_positions.size() != 3 * motion.scene.mesh.num_nodes()) return std::nullopt;
  return DifferenceAtStart(motion, PointsOf(motion, motion.scene.initial_positions));
}

}  // namespace clothid
