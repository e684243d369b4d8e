#include "datasets/checking/check_clouds.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <utility>

#include "datasets/checking/finding_words.h"
#include "datasets/observation/cloth_surface.h"

namespace clothid {
namespace {

constexpr double kCloudUnitTolerance = 0.7;  // of the logarithm: a folded cloth is smaller than a flat one
constexpr double kLarge = 1.5;               // extent of a cloud over that of the cloth at rest
constexpr double kCloudOff = 0.15;           // of the cloth's size: from here clouds are not where the cloth starts
constexpr double kCloudElsewhere = 2.0;      // of the cloth's size: the scene is about another place
constexpr double kCloudOffHandle = 0.2;      // of the cloth's size: cloth is seen no nearer to a handle
constexpr int kMaxFrames = 50;               // that are looked at for handles
constexpr int kMaxHandles = 50;

struct CloudUnit {
  double ratio;
  const char* text;
};
constexpr CloudUnit kCloudUnits[] = {{1000.0, "the clouds seem to be in mm: motion convert_clouds --scale 0.001"},
                                     {100.0, "the clouds seem to be in cm: motion convert_clouds --scale 0.01"},
                                     {39.37, "the clouds seem to be in inches: motion convert_clouds --scale 0.0254"},
                                     {0.001, "the mesh seems to be in mm and the clouds in m: give the mesh in m"}};

// Median distance from the median of the points, m.
double Extent(const Eigen::Matrix3Xd& points) {
  const Eigen::Vector3d centre(Median(points.row(0).transpose()), Median(points.row(1).transpose()),
                               Median(points.row(2).transpose()));
  return Median((points.colwise() - centre).colwise().norm().transpose());
}

Finding CheckSize(const CheckedMotion& checked, const Eigen::Matrix3Xd& cloud) {
  Finding finding;
  finding.what = "size of clouds";
  const double ratio = Extent(cloud) / Extent(checked.motion.scene.mesh.rest_positions);
  finding.value = Rounded(ratio) + " of the mesh at rest in the first frame (median distance from the middle)";
  for (const CloudUnit& unit : kCloudUnits) {
    if (std::abs(std::log(ratio / unit.ratio)) > kCloudUnitTolerance) continue;
    finding.severity = Severity::kProblem;
    finding.hint = unit.text;
    return finding;
  }
  if (ratio <= kLarge) return finding;
  finding.severity = Severity::kWarning;
  finding.hint = "more than the cloth is in the clouds, or they are in another unit: motion convert_clouds --scale";
  return finding;
}

Finding CheckPlace(const CheckedMotion& checked, const Eigen::Matrix3Xd& cloud) {
  const Scene& scene = checked.motion.scene;
  const ClothSurface start(ClothTopology(scene.mesh.faces, scene.mesh.num_nodes()), scene.initial_positions);
  std::vector<double> distances;
  for (const auto& point : cloud.colwise()) distances.push_back(std::abs(start.Measure(point, 0.0).distance));
  const double distance = Median(std::move(distances));
  Finding finding;
  finding.what = "place of clouds";
  finding.value = Millimetres(distance) + " from where the cloth starts (median)";
  const double off = distance - 3.0 * checked.motion.cloud_sigma;
  if (off <= kCloudOff * checked.cloth_size) return finding;
  finding.severity = off > kCloudElsewhere * checked.cloth_size ? Severity::kProblem : Severity::kWarning;
  finding.hint =
      "the frame of reference of the clouds (motion convert --transform), or where the scene has the cloth in the "
      "first "
      "frame (`initial`, or motion convert_clouds --fit_pose)";
  return finding;
}

// How near the clouds come to the handles: median over frames and handles of the distance of the nearest point.
std::vector<Finding> CheckNearHandles(const CheckedMotion& checked) {
  const RecordedMotion& motion = checked.motion;
  const Handles& handles = motion.scene.handles;
  if (handles.nodes.empty()) return {};
  const int stride = 1 + (motion.num_frames() - 1) / kMaxFrames;
  const std::size_t handle_stride = 1 + (handles.nodes.size() - 1) / kMaxHandles;
  std::vector<double> distances;
  for (int frame = 0; frame < motion.num_frames(); frame += stride) {
    const Eigen::Matrix3Xd cloud = checked.Cloud(frame);
    if (cloud.cols() == 0) continue;
    const Eigen::VectorXd path =
        handles.path.num_handles() > 0 ? handles.path.At(motion.times[frame]) : Eigen::VectorXd();
    for (std::size_t i = 0; i < handles.nodes.size(); i += handle_stride) {
      const Eigen::Vector3d place = path.size() > 0 ? path.segment<3>(3 * static_cast<Eigen::Index>(i))
                                                    : motion.scene.initial_positions.segment<3>(3 * handles.nodes[i]);
      distances.push_back((cloud.colwise() - place).colwise().norm().minCoeff());
    }
  }
  const double distance = Median(std::move(distances));
  if (!(distance > kCloudOffHandle * checked.cloth_size + 3.0 * motion.cloud_sigma)) return {};
  Finding finding;
  finding.what = "clouds near handles";
  finding.severity = Severity::kWarning;
  finding.value = "the nearest points are " + Millimetres(distance) + " from the handles (median)";
  finding.hint = "clock, frame of reference or unit of the handles, or of the clouds?";
  return {finding};
}

}  // namespace

std::vector<Finding> CheckClouds(const CheckedMotion& checked) {
  const RecordedMotion& motion = checked.motion;
  int frame = 0;
  while (frame < static_cast<int>(motion.clouds.size()) && motion.clouds[frame].cols() == 0) ++frame;
  if (frame >= static_cast<int>(motion.clouds.size())) return {};
  const Eigen::Matrix3Xd cloud = checked.Cloud(frame);
  std::vector<Finding> findings = CheckRepeatedPlacesOfClouds(checked);
  findings.push_back(CheckSize(checked, cloud));
  if (findings.back().severity == Severity::kProblem) return findings;
  if (frame == 0) findings.push_back(CheckPlace(checked, cloud));
  const std::vector<Finding> handles = CheckNearHandles(checked);
  findings.insert(findings.end(), handles.begin(), handles.end());
  return findings;
}

}  // namespace clothid
