#include "datasets/observation/cloth_surface.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <map>
#include <utility>
#include <vector>

#include "sim/geometry/triangle_tree.h"

namespace clothid {
namespace {

using Eigen::Vector3d;

// Nearer than this share of the largest coordinate there is no direction from an edge or vertex to a point.
constexpr double kSingular = 1e-12;

}  // namespace

// A face, an edge or a vertex.
struct ClothFeature {
  int num_nodes = 0;
  std::array<int, 3> nodes = {0, 0, 0};
  std::vector<int> faces;  // that share it, ascending
  bool is_border = false;
};

// Features are numbered: faces, then edges, then vertices.
struct ClothTopology::Data {
  Eigen::Matrix3Xi faces;
  std::vector<ClothFeature> features;
  std::vector<std::array<int, 3>> side_features;  // by face
  std::vector<int> border_edges;                  // features
  int first_vertex = 0;                           // the feature of node 0

  void AddEdge(int face, int side, std::map<std::pair<int, int>, int>* edges) {
    const int a = faces(side, face), b = faces((side + 1) % 3, face);
    const auto [edge, is_new] = edges->try_emplace(std::minmax(a, b), static_cast<int>(features.size()));
    if (is_new) features.push_back({2, {std::min(a, b), std::max(a, b), 0}, {}, false});
    features[edge->second].faces.push_back(face);
    side_features[face][side] = edge->second;
  }

  void AddVertices(int num_nodes) {
    const int num_faces_and_edges = first_vertex = static_cast<int>(features.size());
    for (int node = 0; node < num_nodes; ++node) features.push_back({1, {node, 0, 0}, {}, false});
    for (int face = 0; face < faces.cols(); ++face) {
      for (int k = 0; k < 3; ++k) features[first_vertex + faces(k, face)].faces.push_back(face);
    }
    for (int edge = static_cast<int>(faces.cols()); edge < num_faces_and_edges; ++edge) {
      features[edge].is_border = features[edge].faces.size() == 1;
      if (!features[edge].is_border) continue;
      border_edges.push_back(edge);
      for (int k = 0; k < 2; ++k) features[first_vertex + features[edge].nodes[k]].is_border = true;
    }
  }
};

ClothTopology::ClothTopology(const Eigen::Matrix3Xi& faces, int num_nodes) {
  auto data = std::make_shared<Data>();
  data->faces = faces;
  data->side_features.resize(static_cast<std::size_t>(faces.cols()));
  for (int face = 0; face < faces.cols(); ++face) {
    data->features.push_back({3, {faces(0, face), faces(1, face), faces(2, face)}, {face}, false});
  }
  std::map<std::pair<int, int>, int> edges;
  for (int face = 0; face < faces.cols(); ++face) {
    for (int side = 0; side < 3; ++side) data->AddEdge(face, side, &edges);
  }
  data->AddVertices(num_nodes);
  data_ = std::move(data);
}

bool ClothTopology::has_border() const { return !data_->border_edges.empty(); }

ClothSurface::ClothSurface(const ClothTopology& topology, const Eigen::VectorXd& nodes)
    : topology_(topology.data_), nodes_(nodes) {
  std::vector<SearchTriangle> triangles(topology_->side_features.size());
  for (std::size_t face = 0; face < triangles.size(); ++face) {
    SearchTriangle& triangle = triangles[face];
    const auto corners = topology_->faces.col(static_cast<Eigen::Index>(face));
    triangle.Place(Position(corners[0]), Position(corners[1]), Position(corners[2]));
    triangle.feature = static_cast<int>(face);
    triangle.side_features = topology_->side_features[face];
    for (int k = 0; k < 3; ++k) triangle.corner_features[k] = topology_->first_vertex + corners[k];
  }
  tree_ = std::make_shared<const TriangleTree>(std::move(triangles));
}

SurfaceDistance ClothSurface::Measure(const Vector3d& q, double allowance) const {
  const int nearest = tree_->ClosestFeature(q);
  const ClothFeature& feature = topology_->features[nearest];
  if (feature.num_nodes == 3) return MeasureFace(q, nearest);
  return feature.is_border ? MeasureBorder(q, nearest, allowance) : MeasureWithin(q, nearest);
}

SurfaceDistance ClothSurface::MeasureFace(const Vector3d& q, int face) const {
  const SearchTriangle& triangle = tree_->triangles()[face];
  SurfaceDistance result;
  result.num_nodes = 3;
  result.nodes = topology_->features[face].nodes;
  result.weights = triangle.Barycentric(q);
  result.distance = triangle.normal.dot(q - triangle.corners[0]);
  result.closest = q - result.distance * triangle.normal;
  result.gradient = -triangle.normal * result.weights.transpose();
  return result;
}

SurfaceDistance ClothSurface::Project(const Vector3d& q, int feature) const {
  SurfaceDistance result;
  result.num_nodes = topology_->features[feature].num_nodes;
  result.nodes = topology_->features[feature].nodes;
  result.weights = Vector3d::UnitX();
  result.closest = Position(result.nodes[0]);
  if (result.num_nodes == 1) return result;
  const Vector3d edge = Position(result.nodes[1]) - result.closest;
  result.weights[1] = std::clamp(edge.dot(q - result.closest) / edge.squaredNorm(), 0.0, 1.0);
  result.weights[0] = 1.0 - result.weights[1];
  result.closest += result.weights[1] * edge;
  return result;
}

// The angle-weighted normal of a vertex, or the sum of the normals at an edge.
Vector3d ClothSurface::Pseudonormal(int feature) const {
  const ClothFeature& own = topology_->features[feature];
  Vector3d sum = Vector3d::Zero();
  for (const int face : own.faces) {
    const SearchTriangle& triangle = tree_->triangles()[face];
    double weight = 1.0;
    for (int k = 0; own.num_nodes == 1 && k < 3; ++k) {
      if (topology_->faces(k, face) != own.nodes[0]) continue;
      const Vector3d ahead = triangle.sides[k], back = -triangle.sides[(k + 2) % 3];
      weight = std::atan2(ahead.cross(back).norm(), ahead.dot(back));
    }
    sum += weight * triangle.normal;
  }
  return sum.normalized();
}

SurfaceDistance ClothSurface::MeasureWithin(const Vector3d& q, int feature) const {
  SurfaceDistance result = Project(q, feature);
  const Vector3d offset = q - result.closest;
  Vector3d normal = Pseudonormal(feature);
  const double sign = normal.dot(offset) < 0.0 ? -1.0 : 1.0, length = offset.norm();
  result.distance = sign * length;
  if (length > kSingular * q.cwiseAbs().maxCoeff()) normal = (sign / length) * offset;
  result.gradient = -normal * result.weights.transpose();
  return result;
}

SurfaceDistance ClothSurface::ProjectOnFace(const Vector3d& q, int feature) const {
  const SurfaceDistance projection = Project(q, feature);
  SurfaceDistance result;
  result.num_nodes = 3;
  result.nodes = topology_->features[topology_->features[feature].faces.front()].nodes;
  result.closest = projection.closest;
  for (int k = 0; k < 3; ++k) {
    for (int i = 0; i < projection.num_nodes; ++i) {
      if (result.nodes[k] == projection.nodes[i]) result.weights[k] = projection.weights[i];
    }
  }
  return result;
}

SurfaceDistance ClothSurface::MeasureBorder(const Vector3d& q, int feature, double allowance) const {
  SurfaceDistance result = ProjectOnFace(q, feature);
  const SearchTriangle& triangle = tree_->triangles()[topology_->features[feature].faces.front()];
  const Vector3d& normal = triangle.normal;
  const Vector3d offset = q - result.closest;
  const double height = normal.dot(offset);
  const double along = std::sqrt(std::max(0.0, offset.squaredNorm() - height * height));
  const Eigen::Matrix3d height_gradient = -normal * triangle.Barycentric(q).transpose();
  const double excess = along - allowance;
  if (!(excess > 0.0)) {
    result.distance = height;
    result.gradient = height_gradient;
    return result;
  }
  const double length = std::hypot(height, excess), sign = height < 0.0 ? -1.0 : 1.0;
  const Eigen::Matrix3d along_gradient = (-offset * result.weights.transpose() - height * height_gradient) / along;
  result.distance = sign * length;
  result.gradient = (sign / length) * (height * height_gradient + excess * along_gradient);
  return result;
}

Vector3d ClothSurface::Outwards(int edge) const {
  const ClothFeature& own = topology_->features[edge];
  const SearchTriangle& triangle = tree_->triangles()[own.faces.front()];
  const Vector3d start = Position(own.nodes[0]);
  const Vector3d outwards = (Position(own.nodes[1]) - start).cross(triangle.normal).normalized();
  const Vector3d middle = (triangle.corners[0] + triangle.corners[1] + triangle.corners[2]) / 3.0;
  return outwards.dot(middle - start) > 0.0 ? Vector3d(-outwards) : outwards;
}

ClothSurface::BorderFeature ClothSurface::NearestBorder(const Vector3d& q) const {
  BorderFeature nearest{topology_->border_edges.front()};
  int vertex = -1;
  double least = std::numeric_limits<double>::infinity();
  for (const int edge : topology_->border_edges) {
    const SurfaceDistance projection = Project(q, edge);
    const double squared = (q - projection.closest).squaredNorm();
    const bool is_vertex = projection.weights[0] == 0.0 || projection.weights[1] == 0.0;
    const int end = is_vertex ? projection.nodes[projection.weights[0] == 0.0 ? 1 : 0] : -1;
    const bool is_same = is_vertex && end == vertex;  // the other edge of the vertex
    if (is_same) nearest.outwards += Outwards(edge);
    if (is_same || !(squared < least)) continue;
    least = squared;
    vertex = end;
    nearest = {is_vertex ? topology_->first_vertex + end : edge, Outwards(edge)};
  }
  return nearest;
}

SurfaceDistance ClothSurface::MeasureToBorder(const Vector3d& q) const {
  const BorderFeature nearest = NearestBorder(q);
  return Beyond(q, nearest.feature, nearest.outwards);
}

SurfaceOffset ClothSurface::OffsetToLine(const Vector3d& q, int feature) const {
  const ClothFeature& own = topology_->features[feature];
  SurfaceOffset result = own.num_nodes == 1 ? OffsetToVertex(Position(own.nodes[0]), q)
                                            : OffsetToEdge(Position(own.nodes[0]), Position(own.nodes[1]), q);
  result.nodes = own.nodes;
  return result;
}

SurfaceOffset ClothSurface::OffsetToBorder(const Vector3d& q) const {
  return OffsetToLine(q, NearestBorder(q).feature);
}

SurfaceOffset ClothSurface::Offset(const Vector3d& q, double allowance) const {
  const int nearest = tree_->ClosestFeature(q);
  const ClothFeature& feature = topology_->features[nearest];
  const bool is_face = feature.num_nodes == 3;
  if (!is_face && !feature.is_border) return OffsetToLine(q, nearest);
  const int face = feature.faces.front();
  const std::array<int, 3>& nodes = topology_->features[face].nodes;
  SurfaceOffset result;
  if (is_face) {
    result = OffsetToFace(tree_->triangles()[face], q);
  } else {
    SurfaceOffset to_border = OffsetToLine(q, nearest);
    for (int i = 0; i < to_border.num_nodes; ++i) {
      to_border.nodes[i] = static_cast<int>(std::find(nodes.begin(), nodes.end(), to_border.nodes[i]) - nodes.begin());
    }
    result = OffsetBesideFace(tree_->triangles()[face], allowance, to_border);
  }
  result.nodes = nodes;
  return result;
}

SurfaceDistance ClothSurface::Beyond(const Vector3d& q, int feature, const Vector3d& outwards) const {
  SurfaceDistance result = ProjectOnFace(q, feature);
  const SearchTriangle& triangle = tree_->triangles()[topology_->features[feature].faces.front()];
  const Vector3d offset = q - result.closest;
  const double height = triangle.normal.dot(offset);
  Vector3d direction = outwards - triangle.normal.dot(outwards) * triangle.normal;
  if (topology_->features[feature].num_nodes == 1) {
    const Vector3d along = offset - height * triangle.normal;
    const double sign = along.dot(direction) < 0.0 ? -1.0 : 1.0;
    if (along.norm() > kSingular * q.cwiseAbs().maxCoeff()) direction = sign * along;
  }
  direction.normalize();
  result.distance = direction.dot(offset);
  const Vector3d slopes =
      triangle.Barycentric(result.closest + direction) - triangle.Barycentric(result.closest);  // m . grad b
  result.gradient = height * triangle.normal * slopes.transpose() - direction * result.weights.transpose();
  return result;
}

}  // namespace clothid
