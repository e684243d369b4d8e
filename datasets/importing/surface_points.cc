#include "datasets/importing/surface_points.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <utility>

#include "datasets/motion/recorded_motion.h"
#include "sim/base/error.h"

namespace clothid {
namespace {

constexpr double kPi = 3.14159265358979323846;
// The faces at a border node that is no corner span pi.
constexpr double kWidestCorner = 0.75 * kPi;

// Edges of one face alone, each with its nodes in ascending order.
std::set<std::pair<int, int>> BorderEdges(const Mesh& mesh) {
  std::map<std::pair<int, int>, int> num_faces;
  for (int face = 0; face < mesh.num_faces(); ++face) {
    for (int k = 0; k < 3; ++k) ++num_faces[std::minmax({mesh.faces(k, face), mesh.faces((k + 1) % 3, face)})];
  }
  std::set<std::pair<int, int>> edges;
  for (const auto& [edge, count] : num_faces) {
    if (count == 1) edges.insert(edge);
  }
  return edges;
}

// [N] what the faces at every node span there.
Eigen::VectorXd SpannedAngles(const Mesh& mesh) {
  Eigen::VectorXd angles = Eigen::VectorXd::Zero(mesh.num_nodes());
  for (int face = 0; face < mesh.num_faces(); ++face) {
    for (int k = 0; k < 3; ++k) {
      const Eigen::Vector3d corner = mesh.rest_positions.col(mesh.faces(k, face));
      const Eigen::Vector3d a = mesh.rest_positions.col(mesh.faces((k + 1) % 3, face)) - corner;
      const Eigen::Vector3d b = mesh.rest_positions.col(mesh.faces((k + 2) % 3, face)) - corner;
      angles[mesh.faces(k, face)] += std::atan2(a.cross(b).norm(), a.dot(b));
    }
  }
  return angles;
}

// The one or two nodes, or the three, between which a point lies, ascending.
std::vector<int> NodesOf(const MotionTensors& tensors, int point) {
  if (tensors.face_index.empty()) return {tensors.node_index.empty() ? point : tensors.node_index[point]};
  std::vector<int> nodes;
  for (int k = 0; k < 3; ++k) {
    if (tensors.barycentric(k, point) != 0.0) nodes.push_back(tensors.mesh.faces(k, tensors.face_index[point]));
  }
  std::sort(nodes.begin(), nodes.end());
  return nodes;
}

}  // namespace

std::vector<int> MarkSurfacePoints(const MotionTensors& tensors, const SurfaceMarks& marks, const std::string& source) {
  if (!marks.as_surface) throw Error(ErrorKind::kUsage, source + ": borders and corners: expected with as_surface");
  const auto num_points = static_cast<int>(tensors.positions.rows() / 3);
  if (num_points == 0) throw Error(ErrorKind::kBadData, source + ": expected tracked points to mark, found none");
  const std::set<std::pair<int, int>> edges = BorderEdges(tensors.mesh);
  std::set<int> border;
  for (const auto& [a, b] : edges) border.insert({a, b});
  const Eigen::VectorXd angles = SpannedAngles(tensors.mesh);
  std::vector<int> kinds;
  int num_border = 0, num_corners = 0;
  for (int point = 0; point < num_points; ++point) {
    const std::vector<int> nodes = NodesOf(tensors, point);
    const bool is_border =
        nodes.size() == 1 ? border.count(nodes[0]) > 0 : nodes.size() == 2 && edges.count({nodes[0], nodes[1]}) > 0;
    const bool is_corner = is_border && nodes.size() == 1 && angles[nodes[0]] < kWidestCorner;
    PointKind kind = marks.borders && is_border ? PointKind::kBorder : PointKind::kSurface;
    if (marks.corners && is_corner) kind = PointKind::kMaterial;
    kinds.push_back(static_cast<int>(kind));
    num_border += is_border;
    num_corners += is_corner;
  }
  if (marks.borders && num_border == 0) throw Error(ErrorKind::kBadData, source + ": no point is on a border");
  if (marks.corners && num_corners == 0) throw Error(ErrorKind::kBadData, source + ": no point is at a corner");
  return kinds;
}

}  // namespace clothid
