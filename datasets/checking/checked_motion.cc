#include "datasets/checking/checked_motion.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <utility>

#include "sim/scene/pieces.h"

namespace clothid {
namespace {

constexpr Eigen::Index kMaxMarkers = 3000;        // points off the nodes whose neighbours are looked for
constexpr std::size_t kMaxPairValues = 10000000;  // pairs times frames
constexpr int kNeighbours = 4;                    // of a marker
constexpr double kNoiseFloor = 3.0;               // in standard deviations
constexpr Eigen::Index kMaxCloudPoints = 1000;    // that are looked at in a frame
constexpr double kStiff =
    0.5;  // bending length over the cloth's size: a strip of twice that length points 41 degrees down
constexpr double kLeastPointJump = 0.3;  // of the spacing: less is no jump of a point
constexpr double kNoiseJump = 8.0;       // standard deviations: likewise

Eigen::Vector3d RestPosition(const ObservedPoint& point, const Mesh& mesh) {
  Eigen::Vector3d position = Eigen::Vector3d::Zero();
  for (int k = 0; k < point.num_nodes; ++k) position += point.weights[k] * mesh.rest_positions.col(point.nodes[k]);
  return position;
}

bool IsHeld(const ObservedPoint& point, const std::set<int>& handles) {
  for (int k = 0; k < point.num_nodes; ++k) {
    if (point.weights[k] != 0.0 && handles.count(point.nodes[k]) == 0) return false;
  }
  return true;
}

// Edges of the mesh both of whose nodes are measured.
std::vector<PointPair> MeshPairs(const RecordedMotion& motion) {
  const Mesh& mesh = motion.scene.mesh;
  std::vector<int> point_of_node(static_cast<std::size_t>(mesh.num_nodes()), -1);
  for (int p = 0; p < motion.num_points(); ++p) {
    if (motion.points[p].num_nodes == 1) point_of_node[motion.points[p].nodes[0]] = p;
  }
  std::map<std::pair<int, int>, double> lengths;  // of edges, m at rest
  for (int face = 0; face < mesh.num_faces(); ++face) {
    for (int k = 0; k < 3; ++k) {
      lengths[std::minmax({mesh.faces(k, face), mesh.faces((k + 1) % 3, face)})] = RestLength(mesh, face, k);
    }
  }
  std::vector<PointPair> pairs;
  for (const auto& [edge, length] : lengths) {
    const int first = point_of_node[edge.first], second = point_of_node[edge.second];
    if (first >= 0 && second >= 0) pairs.push_back({first, second, length});
  }
  return pairs;
}

// Every point with those nearest to it at rest.
std::vector<PointPair> NearestPairs(const Eigen::Matrix3Xd& rest_points) {
  std::vector<PointPair> pairs;
  const Eigen::Index count = rest_points.cols();
  if (count > kMaxMarkers) return pairs;
  std::set<std::pair<int, int>> found;
  for (Eigen::Index p = 0; p < count; ++p) {
    std::vector<std::pair<double, int>> others;
    for (Eigen::Index q = 0; q < count; ++q) {
      const double length = (rest_points.col(q) - rest_points.col(p)).norm();
      if (q != p && length > 0.0) others.emplace_back(length, static_cast<int>(q));
    }
    const std::size_t num_nearest = std::min<std::size_t>(kNeighbours, others.size());
    std::partial_sort(others.begin(), others.begin() + static_cast<std::ptrdiff_t>(num_nearest), others.end());
    for (std::size_t i = 0; i < num_nearest; ++i) {
      const int low = std::min(static_cast<int>(p), others[i].second);
      const int high = std::max(static_cast<int>(p), others[i].second);
      if (found.emplace(low, high).second) pairs.push_back({low, high, others[i].first});
    }
  }
  return pairs;
}

std::vector<PointPair> FindPairs(const RecordedMotion& motion, const Eigen::Matrix3Xd& rest_points) {
  std::vector<PointPair> pairs = MeshPairs(motion);
  if (pairs.size() < motion.points.size() / 2) pairs = NearestPairs(rest_points);
  const std::size_t stride = 1 + pairs.size() * static_cast<std::size_t>(motion.num_frames()) / kMaxPairValues;
  std::vector<PointPair> kept;
  for (std::size_t i = 0; i < pairs.size(); i += stride) kept.push_back(pairs[i]);
  return kept;
}

double MedianEdge(const Mesh& mesh) {
  std::vector<double> lengths;
  for (int face = 0; face < mesh.num_faces(); ++face) {
    lengths.push_back(RestLength(mesh, face, 0));
  }
  return Median(std::move(lengths));
}

}  // namespace

CheckedMotion::CheckedMotion(const RecordedMotion& recorded)
    : motion(recorded),
      rest_points(3, recorded.num_points()),
      cloth_size(ClothSize(recorded.scene.mesh)),
      noise(EstimateNoise(recorded.times, recorded.positions)) {
  const std::set<int> handles(motion.scene.handles.nodes.begin(), motion.scene.handles.nodes.end());
  for (int p = 0; p < motion.num_points(); ++p) {
    rest_points.col(p) = RestPosition(motion.points[p], motion.scene.mesh);
    is_held.push_back(IsHeld(motion.points[p], handles));
  }
  // The bending length is that of Peirce (1930).
  const Material material = MeanMaterial(motion.scene.nominal_parameters(), motion.scene.mesh);
  const double weight = material.density * motion.scene.gravity.norm();
  const double rigidity = std::max({material.bending_stiffness, material.warp_bending, material.weft_bending});
  stands_out = weight > 0.0 && std::cbrt(rigidity / weight) > kStiff * cloth_size;
  pairs = FindPairs(motion, rest_points);
  std::vector<double> lengths, intervals;
  for (const PointPair& pair : pairs) lengths.push_back(pair.rest_length);
  spacing = pairs.empty() ? MedianEdge(motion.scene.mesh) : Median(std::move(lengths));
  for (int i = 1; i < motion.num_frames(); ++i) intervals.push_back(motion.times[i] - motion.times[i - 1]);
  median_interval = Median(std::move(intervals));
  const double known = motion.sigma.size() > 0 ? Median(motion.sigma) : 0.0;
  noise_floor = kNoiseFloor * (motion.num_points() > 0 ? std::max(known, noise.rms()) : motion.cloud_sigma);
}

Eigen::Matrix3Xd CheckedMotion::Cloud(int frame) const {
  if (motion.clouds.empty()) return Eigen::Matrix3Xd(3, 0);
  const Eigen::Matrix3Xd& cloud = motion.clouds[frame];
  const Eigen::Index stride = 1 + (cloud.cols() - 1) / kMaxCloudPoints;
  return cloud(Eigen::all, Eigen::seq(0, cloud.cols() - 1, stride));
}

Eigen::Matrix3Xd CheckedMotion::Places(int frame) const {
  Eigen::Matrix3Xd places(3, motion.num_points());
  Eigen::Index count = 0;
  for (int p = 0; p < motion.num_points(); ++p) {
    const Eigen::Vector3d place = motion.positions.col(frame).segment<3>(3 * static_cast<Eigen::Index>(p));
    if (place.allFinite()) places.col(count++) = place;
  }
  const Eigen::Matrix3Xd cloud = Cloud(frame);
  places.conservativeResize(Eigen::NoChange, count + cloud.cols());
  places.rightCols(cloud.cols()) = cloud;
  return places;
}

double CheckedMotion::point_jump_floor() const { return std::max(kLeastPointJump * spacing, kNoiseJump * noise.rms()); }

}  // namespace clothid
