#include "datasets/checking/check_handles.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include "datasets/checking/check_coverage.h"
#include "datasets/checking/finding_words.h"

namespace clothid {
namespace {

constexpr double kOffHandle = 0.25;   // of the spacing: from here a point is not where its handle is
constexpr double kHandleJump = 0.25;  // of the spacing: less is no jump of a handle
constexpr double kTorn = 1.3;         // distance of two handles over that at rest
constexpr double kPairNoise = 2.0;    // times the noise floor: the farthest of many pairs over many frames
constexpr std::size_t kMaxHandlePairs = 200;
constexpr double kLongestShift = 1.0;  // s, between the clocks of handles and points
constexpr int kNumShifts = 200;        // tried on each side
constexpr int kMaxComparedFrames = 200;
constexpr std::size_t kMaxComparedHandles = 50;
constexpr double kLate = 0.5;        // of the interval between frames: less is left to --fit time_offset
constexpr double kFitsBetter = 0.7;  // at another clock, over the distance at this one
constexpr double kNotable = 0.05;    // of the spacing: a smaller distance is no matter

// The point that is measured at a node; -1 where there is none.
int PointAt(const RecordedMotion& motion, int node) {
  for (int p = 0; p < motion.num_points(); ++p) {
    if (motion.points[p].num_nodes == 1 && motion.points[p].nodes[0] == node) return p;
  }
  return -1;
}

// The frames in which handles are compared with points: not all of a long recording.
std::vector<int> ComparedFrames(const RecordedMotion& motion) {
  const int stride = 1 + (motion.num_frames() - 1) / kMaxComparedFrames;
  std::vector<int> frames;
  for (int frame = 0; frame < motion.num_frames(); frame += stride) frames.push_back(frame);
  return frames;
}

// How far point `points[i]` is from handle i in every compared frame, at times of the path shifted by `shift` s
// [handles x frames] m; NaN where it is not seen.
Eigen::MatrixXd DistancesFromPath(const RecordedMotion& motion, const std::vector<int>& points, double shift) {
  const std::vector<int> frames = ComparedFrames(motion);
  Eigen::MatrixXd distances(static_cast<Eigen::Index>(points.size()), static_cast<Eigen::Index>(frames.size()));
  distances.setConstant(std::numeric_limits<double>::quiet_NaN());
  for (std::size_t k = 0; k < frames.size(); ++k) {
    const Eigen::VectorXd path = motion.scene.handles.path.At(motion.times[frames[k]] + shift);
    for (std::size_t i = 0; i < points.size(); ++i) {
      if (points[i] < 0) continue;
      const Eigen::Vector3d measured = motion.positions.col(frames[k]).segment<3>(3 * points[i]);
      distances(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(k)) =
          (measured - path.segment<3>(3 * static_cast<Eigen::Index>(i))).norm();
    }
  }
  return distances;
}

// By how much the clock of the path is ahead where the points fit it best, s, and how well they do.
struct BestShift {
  double shift = 0.0;
  double distance = 0.0;  // m, median
};

BestShift FindShift(const RecordedMotion& motion, std::vector<int> points, double distance) {
  const std::size_t stride = 1 + points.size() / kMaxComparedHandles;
  for (std::size_t i = 0; i < points.size(); ++i) points[i] = i % stride == 0 ? points[i] : -1;
  BestShift best = {0.0, distance};
  for (int i = -kNumShifts; i <= kNumShifts; ++i) {
    const double shift = kLongestShift * i / kNumShifts;
    const double shifted = Median(DistancesFromPath(motion, points, shift).reshaped());
    if (shifted < best.distance) best = {shift, shifted};
  }
  return best;
}

std::string ClockHint(const BestShift& best) {
  return "they fit best (" + Millimetres(best.distance) + ") where the clock of the handles is " + Rounded(best.shift) +
         " s ahead: motion convert --handle_time_offset";
}

// Another handle's path that the points of some handles follow; empty where there is none.
std::string OrderHint(const RecordedMotion& motion, const std::vector<int>& points, const std::vector<std::size_t>& off,
                      double distance) {
  const std::vector<int>& nodes = motion.scene.handles.nodes;
  std::string words;
  for (const std::size_t i :
       std::vector<std::size_t>(off.begin(), off.begin() + std::min<std::size_t>(2, off.size()))) {
    const std::vector<int> same(points.size(), points[i]);
    const Eigen::MatrixXd distances = DistancesFromPath(motion, same, 0.0);
    for (std::size_t k = 0; k < nodes.size(); ++k) {
      if (!(Median(distances.row(static_cast<Eigen::Index>(k)).transpose()) < 0.3 * distance)) continue;
      words += (words.empty() ? "" : ", ") +
               ("that of node " + std::to_string(nodes[i]) + " follows the path of node " + std::to_string(nodes[k]));
      break;
    }
  }
  return words.empty() ? words : words + ": another order of the handles?";
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
  const Eigen::MatrixXd distances = DistancesFromPath(motion, points, 0.0);
  const double distance = Median(distances.reshaped());
  finding.value = std::to_string(points.size()) + " moving";
  if (std::isnan(distance)) return finding;
  finding.value += ", the points there are " + Millimetres(distance) + " off (median)";
  double farthest = 0.0;
  std::vector<std::size_t> off;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const double of_handle = Median(distances.row(static_cast<Eigen::Index>(i)).transpose());
    if (!(of_handle > kOffHandle * checked.spacing + checked.noise_floor)) continue;
    farthest = std::max(farthest, of_handle);
    off.push_back(i);
    finding.points.push_back(points[i]);
  }
  if (off.empty() && distance <= kNotable * checked.spacing) return finding;
  const BestShift best = FindShift(motion, points, distance);
  const bool is_late =
      std::abs(best.shift) >= kLate * checked.median_interval && best.distance < kFitsBetter * distance;
  if (off.empty() && !is_late) return finding;
  finding.severity = Severity::kWarning;
  finding.hint = ClockHint(best);
  if (off.empty() || best.distance < 0.5 * distance) return finding;
  if (off.size() < points.size()) {
    finding.value += ", " + std::to_string(off.size()) + " of them up to " + Millimetres(farthest);
  }
  finding.hint = OrderHint(motion, points, off, farthest);
  if (finding.hint.empty()) finding.hint = "another frame of reference or unit? See motion convert --handle_transform";
  return finding;
}

// Whether the path puts handles at the start where the cloth beside them is.
std::vector<Finding> HandlesAgainstStart(const CheckedMotion& checked) {
  const Scene& scene = checked.motion.scene;
  const std::set<int> held(scene.handles.nodes.begin(), scene.handles.nodes.end());
  std::set<int> torn;
  int num_others = 0, num_torn_others = 0;  // edges that are not beside handles
  double worst = 0.0;
  for (int face = 0; face < scene.mesh.num_faces(); ++face) {
    for (int k = 0; k < 3; ++k) {
      const int a = scene.mesh.faces(k, face), b = scene.mesh.faces((k + 1) % 3, face);
      const double rest = RestLength(scene.mesh, face, k);
      const double start =
          (scene.initial_positions.segment<3>(3 * a) - scene.initial_positions.segment<3>(3 * b)).norm();
      const bool is_torn = start - kPairNoise * checked.noise_floor > kTorn * rest;
      if (held.count(a) == held.count(b)) {
        ++num_others;
        num_torn_others += is_torn;
        continue;
      }
      if (!is_torn) continue;
      worst = std::max(worst, start / rest);
      torn.insert(held.count(a) > 0 ? a : b);
    }
  }
  // Where all of the cloth is torn, its points are in a wrong order.
  if (torn.empty() || 5 * num_torn_others > num_others) return {};
  Finding finding;
  finding.what = "start of handles";
  finding.severity = Severity::kWarning;
  finding.value = "the cloth beside " + Named("node", {torn.begin(), torn.end()}) + " is stretched to " +
                  Rounded(worst) + " times its length at the start";
  finding.hint = "their path begins elsewhere than the cloth: order of the handles, clock or frame of reference?";
  return {finding};
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
                   kHandleJump * checked.spacing + checked.noise_floor);
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
  if (motion.scene.mesh.has_corner_rest()) return {};  // how far apart its nodes may be is not known
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
      const double surely = farthest - kPairNoise * checked.noise_floor;
      if (!(surely > worst * rest)) continue;
      worst = surely / rest;
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
  const auto add = [&](const std::vector<Finding>& more) { findings.insert(findings.end(), more.begin(), more.end()); };
  add(TornHandles(checked));
  if (findings[0].severity < Severity::kWarning) add(HandlesAgainstStart(checked));
  add(CheckPathTimes(checked));
  return findings;
}

}  // namespace clothid
