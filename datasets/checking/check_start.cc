#include "datasets/checking/check_start.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <set>
#include <string>

#include "datasets/checking/finding_words.h"
#include "datasets/checking/grid_orders.h"
#include "sim/matrix/dense.h"

namespace clothid {
namespace {

constexpr double kStartOff = 0.25;  // of the spacing: from here the cloth does not start where it was measured
constexpr double kSlightlyOff = 0.1;
constexpr double kStartElsewhere = 2.0;    // of the cloth's size: the scene is about another place
constexpr double kExplained = 3.0;         // how much nearer the points have to come
constexpr double kMeanNoise = 4.0;         // standard deviations of a mean
constexpr double kWrongSpeed = 0.05;       // of the spacing per frame
constexpr double kManyStartPoints = 0.25;  // share of the points
constexpr int kFirstFrames = 10;           // that tell where a point of the first one should be

// Where the scene puts the points at its start [3 x P] m.
Eigen::Matrix3Xd AtStart(const RecordedMotion& motion, const Eigen::VectorXd& nodes) {
  Eigen::Matrix3Xd places = Eigen::Matrix3Xd::Zero(3, motion.num_points());
  for (int p = 0; p < motion.num_points(); ++p) {
    const ObservedPoint& point = motion.points[p];
    for (int k = 0; k < point.num_nodes; ++k) {
      places.col(p) += point.weights[k] * nodes.segment<3>(3 * static_cast<Eigen::Index>(point.nodes[k]));
    }
  }
  return places;
}

Eigen::Vector3d MedianOf(const Eigen::Matrix3Xd& vectors) {
  return {Median(vectors.row(0).transpose()), Median(vectors.row(1).transpose()), Median(vectors.row(2).transpose())};
}

double MedianLength(const Eigen::Matrix3Xd& vectors) { return Median(vectors.colwise().norm().transpose()); }

// A way to have mistaken the axes: measured axis `axis[k]`, times `sign[k]`, is axis k.
struct AxisChange {
  std::array<int, 3> axis;
  std::array<double, 3> sign;

  Eigen::Matrix3Xd Apply(const Eigen::Matrix3Xd& points) const {
    Eigen::Matrix3Xd changed(3, points.cols());
    for (int k = 0; k < 3; ++k) changed.row(k) = sign[k] * points.row(axis[k]);
    return changed;
  }
  // "(x, z, -y)".
  std::string Words() const {
    std::string words;
    for (int k = 0; k < 3; ++k) words += (k > 0 ? ", " : "(") + std::string(sign[k] < 0.0 ? "-" : "") + "xyz"[axis[k]];
    return words + ")";
  }
};

std::vector<AxisChange> AxisChanges() {
  std::vector<AxisChange> changes;
  std::array<int, 3> axis = {0, 1, 2};
  do {
    for (int signs = 0; signs < 8; ++signs) {
      changes.push_back({axis, {signs & 1 ? -1.0 : 1.0, signs & 2 ? -1.0 : 1.0, signs & 4 ? -1.0 : 1.0}});
    }
  } while (std::next_permutation(axis.begin(), axis.end()));
  return changes;
}

// In tenths of a millimetre.
std::string Vector(const Eigen::Vector3d& v) {
  std::string words;
  for (const double coordinate : v) {
    words += (words.empty() ? "(" : ", ") + Rounded(0.1 * std::round(1e4 * coordinate) + 0.0);
  }
  return words + ") mm";
}

// What is left of the distances where the measured points are moved as a rigid body to where they are expected.
double RigidMisfit(const Eigen::Matrix3Xd& expected, const Eigen::Matrix3Xd& measured) {
  Eigen::Matrix3Xd from(3, measured.cols()), to(3, measured.cols());
  Eigen::Index count = 0;
  for (Eigen::Index p = 0; p < measured.cols(); ++p) {
    if (!measured.col(p).allFinite()) continue;
    from.col(count) = measured.col(p);
    to.col(count++) = expected.col(p);
  }
  if (count < 4) return std::numeric_limits<double>::infinity();
  const Eigen::Isometry3d motion = RigidMotion(from.leftCols(count), to.leftCols(count));
  return MedianLength(motion * from.leftCols(count) - to.leftCols(count));
}

Finding StartAgainstFrame(const CheckedMotion& checked) {
  const RecordedMotion& motion = checked.motion;
  Finding finding;
  finding.what = "first frame";
  const Eigen::Matrix3Xd expected = AtStart(motion, motion.scene.initial_positions);
  const Eigen::Matrix3Xd measured = motion.positions.col(0).reshaped(3, motion.num_points());
  const Eigen::Matrix3Xd difference = measured - expected;
  const double distance = MedianLength(difference);
  if (std::isnan(distance)) {
    finding.value = "no point is seen in it";
    return finding;
  }
  finding.value = "the cloth starts " + Millimetres(distance) + " from its points (median)";
  const double mean_noise = kMeanNoise * checked.noise.rms() / std::sqrt(static_cast<double>(motion.num_points()));
  const double off = std::max(distance - checked.noise_floor, MedianOf(difference).norm() - mean_noise);
  if (!(off > kSlightlyOff * checked.spacing)) return finding;
  finding.severity = off > kStartElsewhere * checked.cloth_size ? Severity::kProblem
                     : off > kStartOff * checked.spacing        ? Severity::kWarning
                                                                : Severity::kNote;
  std::vector<std::vector<int>> orders;
  if (motion.num_points() <= kMaxOrderPoints) orders = GridOrders(checked.rest_points);
  finding.hint = Explanation(expected, measured, orders);
  if (!finding.hint.empty()) return finding;
  finding.hint =
      motion.start_source == StartSource::kScene
          ? "the points have another shape there; without `initial` in the scene the cloth starts as they are"
          : "the points have another shape there: identify --initial smoothed, or `initial` in the scene";
  return finding;
}

// The points that only the first frame puts where they are.
std::vector<int> FirstFrameOutliers(const CheckedMotion& checked) {
  const RecordedMotion& motion = checked.motion;
  const Eigen::Index num_frames = std::min<Eigen::Index>(motion.num_frames(), kFirstFrames);
  std::vector<int> outliers;
  for (const auto& [frame, point] :
       PointJumps(motion.times.head(num_frames), motion.positions.leftCols(num_frames), checked.point_jump_floor())) {
    if (frame == 0) outliers.push_back(point);
  }
  return outliers;
}

// The length that a share of the vectors exceeds.
double UpperLength(const Eigen::Matrix3Xd& vectors, double share) {
  std::vector<double> lengths;
  for (const double length : vectors.colwise().norm()) {
    if (!std::isnan(length)) lengths.push_back(length);
  }
  if (lengths.empty()) return std::numeric_limits<double>::quiet_NaN();
  const auto place = lengths.begin() + static_cast<std::ptrdiff_t>((1.0 - share) * static_cast<double>(lengths.size()));
  std::nth_element(lengths.begin(), place, lengths.end());
  return *place;
}

// The velocities over the first interval against those of the scene. Gravity, the handles and the air may have
// changed it by then.
std::vector<Finding> CheckStartVelocity(const CheckedMotion& checked) {
  const RecordedMotion& motion = checked.motion;
  const Scene& scene = motion.scene;
  if (motion.num_frames() < 2) return {};
  if (scene.has_wind()) return {};
  const std::set<int> held(scene.handles.nodes.begin(), scene.handles.nodes.end());
  const Eigen::Matrix3Xd given = AtStart(motion, scene.initial_velocities);
  const double interval = motion.times[1] - motion.times[0];
  Eigen::Matrix3Xd difference = (motion.positions.col(1) - motion.positions.col(0)).reshaped(3, motion.num_points());
  difference = difference / interval - given;
  for (int p = 0; p < motion.num_points(); ++p) {
    if (motion.points[p].num_nodes == 1 && held.count(motion.points[p].nodes[0]) > 0) {
      difference.col(p).setConstant(std::numeric_limits<double>::quiet_NaN());
    }
  }
  const HandlePath& path = scene.handles.path;
  const double pulled =
      path.num_handles() == 0
          ? 0.0
          : MedianLength((path.At(motion.times[1]) - path.At(motion.times[0])).reshaped(3, path.num_handles())) /
                interval;
  const double noise = kMeanNoise * std::sqrt(2.0) * checked.noise.rms() / interval;
  const double allowed = scene.gravity.norm() * interval + 1.5 * pulled + kWrongSpeed * checked.spacing / interval;
  const double of_cloth = MedianOf(difference).norm() - noise / std::sqrt(1.0 * motion.num_points());
  const double of_points = UpperLength(difference, kManyStartPoints) - noise;
  const double off = std::max(of_cloth, of_points);
  if (!(off > allowed)) return {};
  Finding finding;
  finding.what = "start velocity";
  finding.severity = Severity::kWarning;
  finding.value = "many points move by " + Rounded(off) + " m/s other than the scene has it in the first frame";
  finding.hint =
      "was the recording cut while it moved? `initial` in the scene gives a velocity, --fit v0 fits one, --initial "
      "smoothed takes it from the first frames";
  return {finding};
}

}  // namespace

std::string Explanation(const Eigen::Matrix3Xd& expected, const Eigen::Matrix3Xd& measured,
                        const std::vector<std::vector<int>>& orders) {
  double best = MedianLength(measured - expected) / kExplained;
  std::string words;
  const auto consider = [&](double misfit, const std::string& explanation) {
    if (!(misfit < best)) return;
    best = misfit;
    words = explanation + " (then they are " + Millimetres(misfit) + " off)";
  };
  for (std::size_t k = 1; k < orders.size(); ++k) {
    consider(MedianLength(measured(Eigen::all, orders[k]) - expected),
             "they fit in another order of the grid: turned, mirrored or transposed");
  }
  for (const AxisChange& change : AxisChanges()) {
    consider(MedianLength(change.Apply(measured) - expected),
             "they fit with the axes " + change.Words() + ": motion convert --transform, or another order of columns");
  }
  if (!words.empty()) return words;
  const Eigen::Vector3d offset = MedianOf(measured - expected);
  consider(
      MedianLength((measured - expected).colwise() - offset),
      "all of them are off by " + Vector(offset) + ": the frame of reference, or the place of the mesh in the scene");
  if (!words.empty()) best /= 2.0;
  consider(RigidMisfit(expected, measured),
           "they are turned and shifted: another frame of reference, such as a "
           "camera's? See motion convert --transform");
  return words;
}

std::vector<Finding> CheckFirstFrame(const CheckedMotion& checked) {
  Finding start = StartAgainstFrame(checked);
  const std::vector<int> outliers = FirstFrameOutliers(checked);
  if (!outliers.empty() && start.severity <= Severity::kNote) {
    start.value += "; " + Named("point", outliers) + (outliers.size() == 1 ? " is" : " are") + " far off their path";
    start.points = outliers;
    start.frames = {0};
    const bool is_start = checked.motion.start_source == StartSource::kFirstFrame;
    start.severity = is_start ? Severity::kWarning : Severity::kNote;
    start.hint =
        "the simulated cloth starts there: leave frame 0 out (motion convert --skip_frames 0), or start with "
        "identify --initial smoothed";
    if (!is_start) start.hint = "leave frame 0 out, or fit with a robust loss";
  }
  std::vector<Finding> findings = {start};
  if (start.severity == Severity::kProblem) return findings;
  const std::vector<Finding> velocity = CheckStartVelocity(checked);
  findings.insert(findings.end(), velocity.begin(), velocity.end());
  return findings;
}

}  // namespace clothid
