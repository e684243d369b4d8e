#include "datasets/synthetic/regrid.h"

#include <Eigen/LU>
#include <algorithm>
#include <filesystem>
#include <limits>
#include <nlohmann/json.hpp>

#include "sim/base/error.h"
#include "sim/base/json_document.h"
#include "sim/base/text_file.h"
#include "sim/scene/scene_json.h"

namespace clothid {
namespace {

// A barycentric coordinate smaller than this is the rounding of zero.
constexpr double kZeroWeight = 1e-9;

std::string FolderOf(const std::string& path) { return std::filesystem::path(path).parent_path().string(); }

// Barycentric coordinates of the point of the triangle's plane that is nearest to `point`.
Eigen::Vector3d Barycentric(const Mesh& mesh, int face, const Eigen::Vector3d& point) {
  const Eigen::Vector3d origin = mesh.rest_positions.col(mesh.faces(0, face));
  Eigen::Matrix<double, 3, 2> edges;
  edges.col(0) = mesh.rest_positions.col(mesh.faces(1, face)) - origin;
  edges.col(1) = mesh.rest_positions.col(mesh.faces(2, face)) - origin;
  const Eigen::Vector2d weights = (edges.transpose() * edges).inverse() * (edges.transpose() * (point - origin));
  return {1.0 - weights.sum(), weights[0], weights[1]};
}

ObservedPoint PlacePoint(const Mesh& mesh, const Eigen::Vector3d& point) {
  int best_face = 0;
  Eigen::Vector3d best = Eigen::Vector3d::Constant(-std::numeric_limits<double>::infinity());
  for (int face = 0; face < mesh.num_faces(); ++face) {
    const Eigen::Vector3d weights = Barycentric(mesh, face, point);
    if (weights.minCoeff() <= best.minCoeff()) continue;
    best = weights;
    best_face = face;
  }
  ObservedPoint placed;
  placed.num_nodes = 3;
  for (int k = 0; k < 3; ++k) {
    placed.nodes[k] = mesh.faces(k, best_face);
    placed.weights[k] = best[k] > kZeroWeight ? best[k] : 0.0;
    if (best[k] < 1.0 - kZeroWeight) continue;
    placed = {1, {mesh.faces(k, best_face), 0, 0}, {1.0, 0.0, 0.0}};
    break;
  }
  return placed;
}

bool IsHeld(const ObservedPoint& point, const std::vector<int>& handles) {
  for (int k = 0; k < point.num_nodes; ++k) {
    const bool is_handle = std::find(handles.begin(), handles.end(), point.nodes[k]) != handles.end();
    if (point.weights[k] > 0.0 && !is_handle) return false;
  }
  return true;
}

// `points` are the nodes of the new mesh on that of `old`.
Handles RegridHandles(const Scene& old, const std::vector<ObservedPoint>& points) {
  Handles handles;
  std::vector<ObservedPoint> held;
  for (int node = 0; node < static_cast<int>(points.size()); ++node) {
    if (!IsHeld(points[node], old.handles.nodes)) continue;
    handles.nodes.push_back(node);
    held.push_back(points[node]);
  }
  const HandlePath& path = old.handles.path;
  if (path.times().size() == 0) return handles;
  Eigen::MatrixXd positions = Eigen::MatrixXd::Zero(3 * old.mesh.num_nodes(), path.times().size());
  for (std::size_t i = 0; i < old.handles.nodes.size(); ++i) {
    positions.middleRows<3>(3 * old.handles.nodes[i]) =
        path.positions().middleRows<3>(3 * static_cast<Eigen::Index>(i));
  }
  handles.path = HandlePath(path.times(), Interpolate(held, positions));
  return handles;
}

Eigen::Vector3d RestMiddle(const ClampedEdge& edge, const Mesh& mesh) {
  return 0.5 * (mesh.rest_positions.col(edge.nodes[0]) + mesh.rest_positions.col(edge.nodes[1]));
}

// Edges between nodes that lie on clamped ones, each with the slope of that which was nearest.
void RegridClamps(const Scene& old, const std::vector<ObservedPoint>& points, Scene* scene) {
  const std::vector<ClampedEdge>& clamped = old.handles.clamped;
  if (clamped.empty()) return;
  std::vector<int> rows, held;
  for (const ClampedEdge& edge : clamped) rows.insert(rows.end(), edge.nodes.begin(), edge.nodes.end());
  for (const int node : scene->handles.nodes) {
    if (IsHeld(points[static_cast<std::size_t>(node)], rows)) held.push_back(node);
  }
  scene->handles.clamped = ClampedEdges(scene->mesh, held);
  const Eigen::MatrixXd& before = old.handles.slopes.positions();
  Eigen::MatrixXd slopes(3 * static_cast<Eigen::Index>(scene->handles.clamped.size()), before.cols());
  for (std::size_t i = 0; i < scene->handles.clamped.size(); ++i) {
    const Eigen::Vector3d middle = RestMiddle(scene->handles.clamped[i], scene->mesh);
    const auto distance = [&](const ClampedEdge& edge) { return (RestMiddle(edge, old.mesh) - middle).norm(); };
    const auto nearest = std::min_element(clamped.begin(), clamped.end(),
                                          [&](const auto& a, const auto& b) { return distance(a) < distance(b); });
    slopes.middleRows<3>(3 * static_cast<Eigen::Index>(i)) = before.middleRows<3>(3 * (nearest - clamped.begin()));
  }
  scene->handles.slopes = HandlePath(old.handles.slopes.times(), slopes);
}

void ExpectHandlesHeld(const GridScene& old, const Scene& scene, const std::array<int, 2>& nodes) {
  for (const int handle : old.scene.handles.nodes) {
    if (IsHeld(PlacePoint(scene.mesh, old.scene.mesh.rest_positions.col(handle)), scene.handles.nodes)) continue;
    throw Error(ErrorKind::kUsage, "--nodes: a grid of " + std::to_string(nodes[0]) + " x " + std::to_string(nodes[1]) +
                                       " nodes cannot hold handle " + std::to_string(handle) + " of " + old.path);
  }
}

}  // namespace

GridScene ReadGridScene(const std::string& path) {
  GridScene result;
  result.path = path;
  result.text = ReadText(path, kMaxJsonBytes);
  result.scene = ParseScene(result.text, path, FolderOf(path));
  const nlohmann::json mesh = nlohmann::json::parse(result.text)["mesh"];
  if (!mesh.contains("grid")) {
    throw Error(ErrorKind::kBadData, path + ": key 'mesh': expected a grid; no other mesh can be refined");
  }
  if (!result.scene.mesh.links.empty()) {
    throw Error(ErrorKind::kBadData,
                path + ": key 'mesh': expected no seams and buttons; they count the nodes of a grid");
  }
  if (!result.scene.node_force.isZero(0.0)) {
    throw Error(ErrorKind::kBadData, path + ": key 'node_force': expected none; on another grid it is another force");
  }
  if (!result.scene.pieces.empty()) {
    throw Error(ErrorKind::kBadData, path + ": key 'pieces': expected none; they are of the triangles of this grid");
  }
  result.nodes = mesh["grid"]["nodes"].get<std::array<int, 2>>();
  return result;
}

Scene Regrid(const GridScene& old, const std::array<int, 2>& nodes) {
  nlohmann::json text = nlohmann::json::parse(old.text);
  text["mesh"]["grid"]["nodes"] = nodes;
  for (const char* key : {"handles", "initial"}) text.erase(key);
  Scene scene = ParseScene(text.dump(), old.path, FolderOf(old.path));
  const std::vector<ObservedPoint> points = PlaceOnMesh(old.scene.mesh, scene.mesh.rest_positions);
  scene.initial_positions = Interpolate(points, old.scene.initial_positions);
  scene.initial_velocities = Interpolate(points, old.scene.initial_velocities);
  scene.handles = RegridHandles(old.scene, points);
  RegridClamps(old.scene, points, &scene);
  ExpectHandlesHeld(old, scene, nodes);
  return scene;
}

std::vector<ObservedPoint> PlaceOnMesh(const Mesh& mesh, const Eigen::Matrix3Xd& rest_points) {
  std::vector<ObservedPoint> points;
  for (Eigen::Index p = 0; p < rest_points.cols(); ++p) points.push_back(PlacePoint(mesh, rest_points.col(p)));
  return points;
}

Eigen::MatrixXd Interpolate(const std::vector<ObservedPoint>& points, const Eigen::MatrixXd& values) {
  Eigen::MatrixXd result = Eigen::MatrixXd::Zero(3 * static_cast<Eigen::Index>(points.size()), values.cols());
  for (std::size_t p = 0; p < points.size(); ++p) {
    for (int k = 0; k < points[p].num_nodes; ++k) {
      result.middleRows<3>(3 * static_cast<Eigen::Index>(p)) +=
          points[p].weights[k] * values.middleRows<3>(3 * points[p].nodes[k]);
    }
  }
  return result;
}

}  // namespace clothid
