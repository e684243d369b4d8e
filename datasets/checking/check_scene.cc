#include "datasets/checking/check_scene.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <set>

#include "datasets/checking/check_coverage.h"
#include "datasets/checking/finding_words.h"
#include "sim/obstacle/surface_sequence.h"
#include "sim/scene/pieces.h"

namespace clothid {
namespace {

constexpr double kTouching = 1e-3;             // of the cloth's size: a gap that counts as contact
constexpr double kDeep = 0.05;                 // of the cloth's size: no point of a cloth is so deep in an obstacle
constexpr double kSunk = 0.01;                 // of the cloth's size: nor are half of those that touch
constexpr double kManyTouch = 0.2;             // share of the points that tells where the obstacle is
constexpr double kFarOutside = 0.02;           // share of a cloud's points that may be anywhere
constexpr double kSupport = 0.3;               // cosine: an obstacle that gravity pulls away from
constexpr double kWall = 0.2;                  // cosine: an obstacle that carries nothing
constexpr double kFallTime = 2.0;              // times sqrt(size / gravity): by then it has fallen twice its size
constexpr double kSideways = 60.0;             // degrees
constexpr double kRadian = 57.29577951308232;  // degrees
constexpr double kEarth = 9.81;                // m/s^2
constexpr double kEarthTolerance = 0.05;       // by share; the poles and the equator differ by 0.5 %
constexpr double kBodyJump = 0.25;             // of the spacing: less is no jump of a body, as of a handle
constexpr double kFastBody = 1.0;              // m/s: so fast are robots and hands at most, where rows are far apart
constexpr double kMarkerReach = 0.5;           // of the cloth's size
constexpr int kFewVertices = 100;              // of a body that deforms are looked at
constexpr double kLightFabric = 0.031, kHeavyFabric = 0.488;  // kg/m^2
constexpr double kBeyondFabric = 3.0;                     // as a factor: nothing is woven or knitted so light or heavy
constexpr double kLargeCloth = 10.0, kSmallCloth = 0.01;  // m

Finding CheckStart(const CheckedMotion& checked) {
  const Scene& scene = checked.motion.scene;
  Finding finding;
  finding.what = "start";
  double deepest = 0.0;
  std::vector<int> nodes;
  const double tolerance = kTouching * checked.cloth_size;
  const SurfacesAt surfaces(scene, scene.start_time);
  for (int node = 0; node < scene.mesh.num_nodes(); ++node) {
    const double gap = surfaces.Nearest(scene.initial_positions.segment<3>(3 * node)).gap;
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

// How deep a point has to be inside an obstacle that it cannot be in, m.
double FarInside(const CheckedMotion& checked) { return kDeep * checked.cloth_size + checked.noise_floor; }

// "an obstacle"; of several the names of those that points are deep inside in `frames`.
std::string DeepIn(const CheckedMotion& checked, const std::vector<int>& frames) {
  const Scene& scene = checked.motion.scene;
  if (scene.obstacles.size() < 2) return "an obstacle";
  std::string names;
  for (const SceneObstacle& obstacle : scene.obstacles) {
    const auto is_around = [&](int frame) {
      const double limit = obstacle.contact_distance - FarInside(checked);
      const Eigen::Matrix3Xd places = checked.Places(frame);
      const std::shared_ptr<const Obstacle> shape = obstacle.ShapeAt(checked.motion.times[frame]);
      for (const auto& place : places.colwise()) {
        if (shape->Closest(place).gap < limit) return true;
      }
      return false;
    };
    if (std::any_of(frames.begin(), frames.end(), is_around)) names += (names.empty() ? "" : ", ") + obstacle.name;
  }
  return names;
}

Finding TellTouch(const CheckedMotion& checked, const Touch& touch) {
  Finding finding;
  finding.what = "contact";
  finding.value = "least gap " + Millimetres(touch.least_gap) + ", in contact in " +
                  std::to_string(touch.frames.size()) + " of " + std::to_string(checked.motion.num_frames()) +
                  " frames";
  if (touch.frames.empty()) {
    finding.severity = Severity::kWarning;
    finding.hint = "the cloth touches no obstacle: their friction cannot be told from this recording";
  } else if (!touch.deep.empty()) {
    finding.frames = touch.deep;
    finding.severity = Severity::kWarning;
    finding.hint = "points are deep inside " + DeepIn(checked, touch.deep) + " in " + Named("frame", touch.deep) +
                   ": check frame of reference, unit and obstacles";
  } else if (touch.share > kManyTouch && touch.depth > kSunk * checked.cloth_size + checked.noise_floor / 3.0) {
    finding.severity = Severity::kWarning;
    finding.value += "; points that touch are " + Millimetres(touch.depth) + " inside (median)";
    finding.hint = "the obstacle is elsewhere: its place, contact distance, frame of reference";
  }
  return finding;
}

// Mean of the points that are no handles and seen in a frame, minus that of the handles; NaN where none is.
Eigen::Vector3d HangDirection(const CheckedMotion& checked, int frame, const std::set<int>& handles) {
  const RecordedMotion& motion = checked.motion;
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  int count = 0;
  for (int p = 0; p < motion.num_points(); ++p) {
    const Eigen::Vector3d place = motion.positions.col(frame).segment<3>(3 * p);
    const bool is_handle = motion.points[p].num_nodes == 1 && handles.count(motion.points[p].nodes[0]) > 0;
    if (is_handle || !place.allFinite()) continue;
    sum += place;
    ++count;
  }
  if (motion.num_points() == 0) {
    const Eigen::Matrix3Xd cloud = checked.Cloud(frame);
    sum = cloud.rowwise().sum();
    count = static_cast<int>(cloud.cols());
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

Finding CheckSupport(const Touch& touch) {
  Finding finding;
  finding.what = "direction of gravity";
  finding.severity = Severity::kWarning;
  finding.value = "it pulls the cloth off the obstacle that it lies on (" +
                  Rounded(kRadian * std::acos(std::clamp(-touch.support, -1.0, 1.0))) + " degrees to its normal)";
  finding.hint = "sign or axis of gravity, or another frame of reference";
  return finding;
}

Finding Unusual(const std::string& what, Severity severity, const std::string& value, const std::string& hint) {
  Finding finding;
  finding.what = what;
  finding.severity = severity;
  finding.value = value;
  finding.hint = hint;
  return finding;
}

std::vector<Finding> CheckGravitySize(const Scene& scene) {
  const double size = scene.gravity.norm();
  const std::string value = Rounded(size) + " m/s^2";
  if (size == 0.0) return {Unusual("gravity", Severity::kNote, "none", "right where nothing can fall, as on a frame")};
  if (std::abs(size - kEarth) <= kEarthTolerance * kEarth) return {};
  return {Unusual("gravity", Severity::kWarning, value, "on earth it is 9.81; `gravity` in the scene is in m/s^2")};
}

std::vector<Finding> CheckDensity(const Scene& scene) {
  const double density = MeanMaterial(scene.nominal_parameters(), scene.mesh).density;
  if (density >= kLightFabric && density <= kHeavyFabric) return {};
  const std::string value = Rounded(density) + " kg/m^2; nine in ten fabrics have 0.031 to 0.488";
  if (density >= kLightFabric / kBeyondFabric && density <= kBeyondFabric * kHeavyFabric) {
    return {
        Unusual("density", Severity::kNote, value, "weigh it if it is a guess: stiffness is fitted relative to it")};
  }
  const bool is_grams = density >= 1e3 * kLightFabric / kBeyondFabric;
  return {Unusual("density", Severity::kWarning, value,
                  is_grams ? "is it in g/m^2? `density` in the scene is mass per area in kg/m^2"
                           : "`density` in the scene is mass per area in kg/m^2; stiffness is fitted relative to it")};
}

std::vector<Finding> CheckClothSize(const CheckedMotion& checked) {
  if (checked.cloth_size >= kSmallCloth && checked.cloth_size <= kLargeCloth) return {};
  return {Unusual("size of the cloth", Severity::kWarning,
                  Rounded(checked.cloth_size) + " m, the square root of the area of the mesh",
                  "points, mesh, handles and obstacles are in m: motion convert --scale, and numbers in the scene")};
}

// Six points of the body, `reach` m to either side of its origin along each of its axes [18 x T] m: of a body that only
// turns most of them move, too.
Eigen::MatrixXd BodyMarkers(const RigidPath& path, double reach) {
  Eigen::MatrixXd markers(18, path.times().size());
  for (Eigen::Index row = 0; row < markers.cols(); ++row) {
    const AffineMap pose = path.At(path.times()[row]).pose;
    for (int axis = 0; axis < 3; ++axis) {
      const Eigen::Vector3d arm = reach * Eigen::Vector3d::Unit(axis);
      markers.col(row).segment<6>(6 * axis) << Apply(pose, arm), Apply(pose, -arm);
    }
  }
  return markers;
}

// How an obstacle moves: what its rows are called, and points of it [3M x T] at the times of those.
struct BodyTrack {
  std::string name, row;
  const Eigen::VectorXd& times;
  Eigen::MatrixXd markers;
};

// Of a sequence, which may have very many vertices, some.
BodyTrack TrackOf(const SceneObstacle& obstacle, double reach) {
  if (obstacle.path != nullptr) {
    return {"path of " + obstacle.name, "pose", obstacle.path->times(), BodyMarkers(*obstacle.path, reach)};
  }
  const SurfaceSequence& sequence = *obstacle.sequence;
  const int every = sequence.num_vertices() / kFewVertices + 1;
  const int count = (sequence.num_vertices() - 1) / every + 1;
  Eigen::MatrixXd markers(3 * count, sequence.times().size());
  for (int i = 0; i < count; ++i) markers.middleRows<3>(3 * i) = sequence.positions().middleRows<3>(3 * every * i);
  return {"sequence of " + obstacle.name, "frame", sequence.times(), markers};
}

void Warn(const std::string& value, const std::string& hint, Finding* finding) {
  finding->severity = Severity::kWarning;
  finding->value += "; " + value;
  finding->hint += (finding->hint.empty() ? "" : "; ") + hint;
}

Finding CheckMotionOf(const CheckedMotion& checked, const SceneObstacle& obstacle) {
  const BodyTrack track = TrackOf(obstacle, kMarkerReach * checked.cloth_size);
  const Eigen::VectorXd &times = track.times, &frames = checked.motion.times;
  const double first = times[0], last = times[times.size() - 1];
  Finding finding;
  finding.what = track.name;
  finding.value = "one " + track.row + ": it stands still";
  if (times.size() < 2) return finding;
  finding.value =
      std::to_string(times.size()) + " " + track.row + "s from " + Rounded(first) + " s to " + Rounded(last) + " s";
  if (first >= frames[frames.size() - 1] || last <= frames[0]) {
    Warn("the recording lasts from " + Rounded(frames[0]) + " s to " + Rounded(frames[frames.size() - 1]) + " s",
         "it stands still all the time: another clock? See motion convert --obstacle_time_offset", &finding);
    return finding;
  }
  const std::string unknown = UnknownTimes(checked, times, track.markers);
  if (!unknown.empty()) {
    Warn("not known for " + unknown,
         "a smooth curve, or a standstill, is put there: complete the path, or leave these frames out (motion convert "
         "--frames, --skip_frames)",
         &finding);
  }
  const double interval = Median(times.tail(times.size() - 1) - times.head(times.size() - 1));
  const double floor = std::max(kBodyJump * checked.spacing + checked.noise_floor, kFastBody * interval);
  const std::vector<int> jumps = ClothJumps(times, track.markers, floor);
  if (!jumps.empty()) {
    Warn("jumps at " + Rounded(times[jumps.front()]) + " s" +
             (jumps.size() > 1 ? " and until " + Rounded(times[jumps.back()]) + " s" : ""),
         "the simulated cloth is hit or left behind there: smooth it, or leave those rows out", &finding);
  }
  return finding;
}

}  // namespace

Touch FindTouch(const CheckedMotion& checked) {
  const RecordedMotion& motion = checked.motion;
  Touch touch;
  touch.num_free = motion.num_frames();
  touch.least_gap = std::numeric_limits<double>::infinity();
  if (motion.scene.obstacles.empty()) return touch;
  const Eigen::Vector3d down = motion.scene.gravity.normalized();
  const double near = kTouching * checked.cloth_size + checked.noise_floor;
  const double far_inside = FarInside(checked);
  std::vector<double> touching;  // gaps
  double num_places = 0.0;
  for (int frame = 0; frame < motion.num_frames(); ++frame) {
    std::vector<double> gaps;
    const Eigen::Matrix3Xd places = checked.Places(frame);
    const SurfacesAt surfaces(motion.scene, motion.times[frame]);
    for (const auto& place : places.colwise()) {
      const SurfacePoint surface = surfaces.Nearest(place);
      gaps.push_back(surface.gap);
      if (!(surface.gap <= near)) continue;
      touching.push_back(surface.gap);
      touch.support -= surface.normal.dot(down);
    }
    if (gaps.empty()) continue;
    num_places += static_cast<double>(gaps.size());
    const double stray = motion.num_points() > 0 ? 0.0 : kFarOutside;
    const auto lowest = gaps.begin() + static_cast<std::ptrdiff_t>(stray * static_cast<double>(gaps.size()));
    std::nth_element(gaps.begin(), lowest, gaps.end());
    touch.least_gap = std::min(touch.least_gap, *lowest);
    if (*lowest < -far_inside) touch.deep.push_back(frame);
    if (!(*lowest <= near)) continue;
    if (touch.frames.empty()) touch.num_free = frame;
    touch.frames.push_back(frame);
  }
  if (touching.empty()) return touch;
  touch.share = static_cast<double>(touching.size()) / num_places;
  touch.support /= static_cast<double>(touching.size());
  touch.depth = -Median(std::move(touching));
  return touch;
}

std::vector<Finding> CheckContact(const CheckedMotion& checked, const Touch& touch) {
  if (!checked.motion.scene.obstacles.empty()) return {CheckStart(checked), TellTouch(checked, touch)};
  Finding contact;
  contact.what = "contact";
  contact.value = "no obstacles: friction has no meaning";
  return {contact};
}

std::vector<Finding> CheckObstaclePaths(const CheckedMotion& checked) {
  std::vector<Finding> findings;
  for (const SceneObstacle& obstacle : checked.motion.scene.obstacles) {
    if (obstacle.moves()) findings.push_back(CheckMotionOf(checked, obstacle));
  }
  return findings;
}

std::vector<Finding> CheckGravity(const CheckedMotion& checked, const Touch& touch) {
  const RecordedMotion& motion = checked.motion;
  const Handles& handles = motion.scene.handles;
  if (motion.scene.gravity.isZero(0.0)) return {};
  if (touch.share > kManyTouch && touch.support < -kSupport) return {CheckSupport(touch)};
  // What few points touch may pull the cloth anywhere, and a jaw may hold it up.
  const bool lies_on_a_wall = touch.share > kManyTouch && std::abs(touch.support) < kWall;
  if (handles.nodes.empty() || !handles.clamped.empty() || checked.stands_out ||
      (!touch.frames.empty() && !lies_on_a_wall))
    return {};
  const std::set<int> held(handles.nodes.begin(), handles.nodes.end());
  Eigen::Vector3d hangs = Eigen::Vector3d::Zero();
  // A cloth that was let go needs some time until it hangs.
  const double falling = kFallTime * std::sqrt(checked.cloth_size / motion.scene.gravity.norm());
  for (int frame = 0; frame < motion.num_frames(); ++frame) {
    if (motion.times[frame] - motion.times[0] < falling) continue;
    const Eigen::Vector3d direction = HangDirection(checked, frame, held);
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

std::vector<Finding> CheckConstants(const CheckedMotion& checked) {
  std::vector<Finding> findings;
  for (const std::vector<Finding>& some :
       {CheckClothSize(checked), CheckGravitySize(checked.motion.scene), CheckDensity(checked.motion.scene)}) {
    findings.insert(findings.end(), some.begin(), some.end());
  }
  return findings;
}

}  // namespace clothid
