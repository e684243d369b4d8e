#include "datasets/checking/check_handles.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <set>

namespace clothid {
namespace {

constexpr double kOffHandle = 0.25;  // of the spacing: from here a point is not where its handle is
constexpr double kJump = 0.25;       // of the spacing: less is no jump of a handle
constexpr double kTorn = 1.3;        // distance of two handles over that at rest
constexpr std::size_t kMaxHandlePairs = 200;
constexpr double kLongestShift = 1.0;  // s, between the clocks of handles and points
constexpr int kNumShifts = 200;        // tried on each side

// The point that is measured at a node; -1 where there is none.
int PointAt(const RecordedMotion& motion, int node) {
  for (int p = 0; p < motion.num_points(); ++p) {
    if (motion.points[p].num_nodes == 1 && motion.points[p].nodes[0] == node) return p;
  }
  return -1;
}

// Median distance of points from the path of their handles at times shifted by `shift` s, m; NaN without such points.
double DistanceFromPath(const RecordedMotion& motion, const std::vector<int>& points, double shift) {
  std::vector<double> distances;
  for (int frame = 0; frame < motion.num_frames(); ++frame) {
    const Eigen::VectorXd path = motion.scene.handles.path.At(motion.times[frame] + shift);
    for (std::size_t i = 0; i < points.size(); ++i) {
      if (points[i] < 0) continue;
      const Eigen::Vector3d measured = motion.positions.col(frame).segment<3>(3 * points[i]);
      const Eigen::Vector3d difference = measured - path.segment<3>(3 * static_cast<Eigen::Index>(i));
      if (difference.allFinite()) distances.push_back(difference.norm());
    }
  }
  return Median(std::move(distances));
}

std::string ShiftHint(const RecordedMotion& motion, const std::vector<int>& points, double distance) {
  double best = distance, best_shift = 0.0;
  for (int i = -kNumShifts; i <= kNumShifts; ++i) {
    const double shift = kLongestShift * i / kNumShifts;
    const double shifted = DistanceFromPath(motion, points, shift);
    if (shifted < best) {
      best = shifted;
      best_shift = shift;
    }
  }
  if (!(best < 0.5 * distance)) return "another frame of reference or unit? See motion convert --handle_transform";
  return "they fit best (" + Millimetres(best) + ") where the clock of the handles is " + Rounded(best_shift) +
         " s ahead: motion convert --handle_time_offset";
}

Finding StandingHandles(const CheckedMotion& checked) {
  const RecordedMotion& motion = checked.motion;
  Finding finding;
  finding.what = "handles";
  double farthest = 0.0;
  for (const int node : motion.scene.handles.nodes) {
    const int point = PointAt(motion, node);
    if (point < 0) continue;
    const Eigen::Vector3d start = motion.scene.initial_positions.segment<3>(3 * node);
    const Eigen::VectorXd distances =
        (motion.positions.middleRows<3>(3 * point).colwise() - start).colwise().norm().transpose();
    for (const double distance : distances) farthest = std::isnan(distance) ? farthest : std::max(farthest, distance);
  }
  finding.value = std::to_string(motion.scene.handles.nodes.size()) + " standing still";
  if (farthest > kOffHandle * checked.spacing + checked.noise_floor) {
    finding.value += "; the points there move by " + Millimetres(farthest);
    finding.severity = Severity::kWarning;
    finding.hint = "motion convert --handle_nodes takes their path from the points, --handles from a file";
  }
  return finding;
}

Finding HandlesAgainstPoints(const CheckedMotion& checked) {
  const RecordedMotion& motion = checked.motion;
  Finding finding;
  finding.what = "handles";
  std::vector<int> points;
  for (const int node : motion.scene.handles.nodes) points.push_back(PointAt(motion, node));
  const double distance = DistanceFromPath(motion, points, 0.0);
  finding.value = std::to_string(points.size()) + " moving";
  if (std::isnan(distance)) return finding;
  finding.value += ", the points there are " + Millimetres(distance) + " off (median)";
  if (distance > kOffHandle * checked.spacing + checked.noise_floor) {
    finding.severity = Severity::kWarning;
    finding.hint = ShiftHint(motion, points, distance);
  }
  return finding;
}

Finding HandleJumps(const CheckedMotion& checked) {
  const RecordedMotion& motion = checked.motion;
  const HandlePath& path = motion.scene.handles.path;
  Finding finding;
  finding.what = "jumps of handles";
  finding.value = "none";
  std::set<int> frames;
  std::vector<int> nodes;
  for (std::size_t i = 0; i < motion.scene.handles.nodes.size(); ++i) {
    const std::vector<int> jumps =
        ClothJumps(path.times(), path.positions().middleRows<3>(3 * static_cast<Eigen::Index>(i)),
                   kJump * checked.spacing + checked.noise_floor);
    if (jumps.empty()) continue;
    nodes.push_back(motion.scene.handles.nodes[i]);
    frames.insert(jumps.begin(), jumps.end());
  }
  if (frames.empty()) return finding;
  finding.frames.assign(frames.begin(), frames.end());
  finding.value = "into " + Named("frame", finding.frames) + ", of " + Named("node", nodes);
  finding.severity = Severity::kWarning;
  finding.hint =
      "the simulated cloth is pulled along; identify smooths paths, but a path from the robot or the "
      "gripper is better";
  return finding;
}

// Whether the paths of handles pull the cloth apart.
std::vector<Finding> TornHandles(const CheckedMotion& checked) {
  const RecordedMotion& motion = checked.motion;
  const std::vector<int>& nodes = motion.scene.handles.nodes;
  double worst = 0.0;
  std::string which;
  for (std::size_t i = 0; i < std::min(kMaxHandlePairs, nodes.size()); ++i) {
    for (std::size_t k = 0; k < i; ++k) {
      const double rest =
          (motion.scene.mesh.rest_positions.col(nodes[i]) - motion.scene.mesh.rest_positions.col(nodes[k])).norm();
      const Eigen::MatrixXd& path = motion.scene.handles.path.positions();
      const double farthest =
          (path.middleRows<3>(3 * static_cast<Eigen::Index>(i)) - path.middleRows<3>(3 * static_cast<Eigen::Index>(k)))
              .colwise()
              .norm()
              .maxCoeff();
      if (!(farthest - checked.noise_floor > worst * rest)) continue;
      worst = (farthest - checked.noise_floor) / rest;
      which = std::to_string(nodes[k]) + " and " + std::to_string(nodes[i]);
    }
  }
  if (!(worst > kTorn)) return {};
  Finding finding;
  finding.what = "distance of handles";
  finding.severity = Severity::kWarning;
  finding.value = "of nodes " + which + ": up to " + Rounded(worst) + " times that at rest";
  finding.hint = "the cloth would be torn: wrong nodes, another unit, or a mesh that is too small";
  return {finding};
}

}  // namespace

std::vector<Finding> CheckHandles(const CheckedMotion& checked) {
  const Handles& handles = checked.motion.scene.handles;
  if (handles.nodes.empty()) return {};
  if (handles.path.num_handles() == 0) return {StandingHandles(checked)};
  std::vector<Finding> findings = {HandlesAgainstPoints(checked), HandleJumps(checked)};
  const std::vector<Finding> torn = TornHandles(checked);
  findings.insert(findings.end(), torn.begin(), torn.end());
  return findings;
}

}  // namespace clothid
