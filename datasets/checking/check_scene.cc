#include "datasets/checking/check_scene.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <set>

namespace clothid {
namespace {

constexpr double kTouching = 1e-3;             // of the cloth's size: a gap that counts as contact
constexpr double kDeep = 0.05;                 // of the cloth's size: no point of a cloth is so deep in an obstacle
constexpr double kSideways = 60.0;             // degrees
constexpr double kRadian = 57.29577951308232;  // degrees

// The obstacle that is nearest to a place, and how near.
double GapAt(const Scene& scene, const Eigen::Vector3d& place) {
  double gap = std::numeric_limits<double>::infinity();
  for (const SceneObstacle& obstacle : scene.obstacles) {
    gap = std::min(gap, obstacle.shape->Closest(place).gap - obstacle.contact_distance);
  }
  return gap;
}

Finding CheckStart(const CheckedMotion& checked) {
  const Scene& scene = checked.motion.scene;
  Finding finding;
  finding.what = "start";
  double deepest = 0.0;
  std::vector<int> nodes;
  const double tolerance = kTouching * checked.cloth_size;
  for (int node = 0; node < scene.mesh.num_nodes(); ++node) {
    const double gap = GapAt(scene, scene.initial_positions.segment<3>(3 * node));
    if (gap < -tolerance) nodes.push_back(node);
    deepest = std::max(deepest, -gap);
  }
  finding.value = "no node inside an obstacle";
  if (nodes.empty()) return finding;
  finding.value = Named("node", nodes) + " inside an obstacle, up to " + Millimetres(deepest);
  finding.severity = deepest > tolerance + checked.noise_floor ? Severity::kWarning : Severity::kNote;
  finding.hint = finding.severity == Severity::kNote
                     ? "no more than the noise; the simulation pushes them out at the depenetration speed"
                     : "the simulation pushes them out; check frame of reference, contact distance and obstacles";
  return finding;
}

Finding CheckTouch(const CheckedMotion& checked, bool* touches) {
  const RecordedMotion& motion = checked.motion;
  Finding finding;
  finding.what = "contact";
  double least = std::numeric_limits<double>::infinity();
  std::vector<int> touching, deep;
  for (int frame = 0; frame < motion.num_frames(); ++frame) {
    double gap = std::numeric_limits<double>::infinity();
    for (int p = 0; p < motion.num_points(); ++p) {
      const Eigen::Vector3d place = motion.positions.col(frame).segment<3>(3 * p);
      if (place.allFinite()) gap = std::min(gap, GapAt(motion.scene, place));
    }
    if (gap <= kTouching * checked.cloth_size + checked.noise_floor) touching.push_back(frame);
    if (gap < -kDeep * checked.cloth_size - checked.noise_floor) deep.push_back(frame);
    least = std::min(least, gap);
  }
  *touches = !touching.empty();
  finding.value = "least gap " + Millimetres(least) + ", in contact in " + std::to_string(touching.size()) + " of " +
                  std::to_string(motion.num_frames()) + " frames";
  if (touching.empty()) {
    finding.severity = Severity::kWarning;
    finding.hint = "the cloth touches nothing: friction cannot be told from this recording";
  } else if (!deep.empty()) {
    finding.frames = deep;
    finding.severity = Severity::kWarning;
    finding.hint = "points are deep inside an obstacle in " + Named("frame", deep) +
                   ": check frame of reference, unit and obstacles";
  }
  return finding;
}

// Mean of the points that are no handles and seen in a frame, minus that of the handles; NaN where none is.
Eigen::Vector3d HangDirection(const RecordedMotion& motion, int frame, const std::set<int>& handles) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  int count = 0;
  for (int p = 0; p < motion.num_points(); ++p) {
    const Eigen::Vector3d place = motion.positions.col(frame).segment<3>(3 * p);
    const bool is_handle = motion.points[p].num_nodes == 1 && handles.count(motion.points[p].nodes[0]) > 0;
    if (is_handle || !place.allFinite()) continue;
    sum += place;
    ++count;
  }
  const Handles& held = motion.scene.handles;
  const Eigen::VectorXd path = held.path.num_handles() > 0 ? held.path.At(motion.times[frame]) : Eigen::VectorXd();
  Eigen::Vector3d top = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < held.nodes.size(); ++i) {
    top += path.size() > 0 ? path.segment<3>(3 * static_cast<Eigen::Index>(i))
                           : motion.scene.initial_positions.segment<3>(3 * held.nodes[i]);
  }
  return sum / count - top / static_cast<double>(held.nodes.size());
}

}  // namespace

std::vector<Finding> CheckContact(const CheckedMotion& checked, bool* touches) {
  Finding contact;
  contact.what = "contact";
  contact.value = "no obstacles: friction has no meaning";
  if (checked.motion.scene.obstacles.empty()) return {contact};
  contact = CheckTouch(checked, touches);
  return {CheckStart(checked), contact};
}

std::vector<Finding> CheckGravity(const CheckedMotion& checked) {
  const RecordedMotion& motion = checked.motion;
  const Handles& handles = motion.scene.handles;
  if (handles.nodes.empty() || motion.scene.gravity.isZero(0.0)) return {};
  const std::set<int> held(handles.nodes.begin(), handles.nodes.end());
  Eigen::Vector3d hangs = Eigen::Vector3d::Zero();
  for (int frame = 0; frame < motion.num_frames(); ++frame) {
    const Eigen::Vector3d direction = HangDirection(motion, frame, held);
    if (direction.allFinite()) hangs += direction;
  }
  if (!(hangs.norm() > 0.0)) return {};
  const double angle =
      kRadian * std::acos(std::clamp(hangs.normalized().dot(motion.scene.gravity.normalized()), -1.0, 1.0));
  Finding finding;
  finding.what = "direction of gravity";
  finding.value = "the cloth hangs " + Rounded(angle) + " degrees off it, on average";
  if (angle > kSideways) {
    finding.severity = Severity::kWarning;
    finding.hint = "another frame of reference, such as a camera's? See motion convert --transform";
  }
  return {finding};
}

}  // namespace clothid
