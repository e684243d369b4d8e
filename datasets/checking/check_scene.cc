// Findings about the scene of a recording against its points: handles, obstacles, gravity, time step.
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <set>

#include "datasets/checking/check_rooms.h"

namespace clothid {
namespace {

constexpr double kOffHandle = 0.25;  // of the spacing: from here a point is not where its handle is
constexpr double kJump = 0.25;       // of the spacing: less is no jump of a handle
constexpr double kTorn = 1.3;        // distance of two handles over that at rest
constexpr std::size_t kMaxHandlePairs = 200;
constexpr double kLongestShift = 1.0;          // s, between the clocks of handles and points
constexpr int kNumShifts = 200;                // tried on each side
constexpr double kTouching = 1e-3;             // of the cloth's size: a gap that counts as contact
constexpr double kDeep = 0.05;                 // of the cloth's size: no point of a cloth is so deep in an obstacle
constexpr double kSideways = 60.0;             // degrees
constexpr double kRadian = 57.29577951308232;  // degrees
constexpr double kManySteps = 100.0;           // per frame

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

std::vector<Finding> CheckHandles(const CheckedMotion& checked) {
  const Handles& handles = checked.motion.scene.handles;
  if (handles.nodes.empty()) return {};
  if (handles.path.num_handles() == 0) return {StandingHandles(checked)};
  std::vector<Finding> findings = {HandlesAgainstPoints(checked), HandleJumps(checked)};
  const std::vector<Finding> torn = TornHandles(checked);
  findings.insert(findings.end(), torn.begin(), torn.end());
  return findings;
}

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

Finding CheckTimeStep(const CheckedMotion& checked) {
  const Scene& scene = checked.motion.scene;
  Finding finding;
  finding.what = "time step";
  const double steps = checked.median_interval / scene.time_step;
  finding.value = Rounded(steps) + " steps of " + Rounded(1e3 * scene.time_step) + " ms per frame, " +
                  std::to_string(scene.num_steps()) + " in all";
  if (steps < 0.99) {
    finding.severity = Severity::kWarning;
    finding.hint =
        "several frames within one step are compared with a straight line; a smaller time step in the scene "
        "shows what they say";
  } else if (steps > kManySteps) {
    finding.severity = Severity::kNote;
    finding.hint = "a time step that is larger makes fits faster; identify --check_step says what it costs";
  }
  return finding;
}

}  // namespace clothid
