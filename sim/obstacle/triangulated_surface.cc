#include "sim/obstacle/triangulated_surface.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "sim/base/error.h"
#include "sim/geometry/triangle_tree.h"
#include "sim/matrix/dense.h"
#include "sim/mesh/mesh.h"

namespace clothid {

using Eigen::Matrix3d;
using Eigen::Vector3d;

// What can be closest to a point: a face, an edge or a vertex. The normal is constant on a plane, turns about a crease
// and points away from a corner; an edge within a plane is a plane, a vertex within a straight edge a crease.
struct SurfaceFeature {
  enum class Kind { kPlane, kCrease, kCorner };

  Kind kind = Kind::kPlane;
  Vector3d point = Vector3d::Zero();   // any point of it
  Vector3d normal = Vector3d::Zero();  // pseudonormal, a unit vector
  Vector3d along = Vector3d::Zero();   // of a crease, a unit vector
};

namespace {

// The angle, in rad, below which normals count as equal: the rounding of coordinates given to seven digits.
constexpr double kFlat = 1e-7;

// Nearer to an edge or vertex than this share of the largest coordinate there is no direction to speak of.
constexpr double kSingularDistance = 1e-12;

[[noreturn]] void FailOnSurface(const std::string& message) {
  throw Error(ErrorKind::kBadData, "triangulated surface: " + message);
}

// phi, n and dn/dx of points whose closest point is on `feature`. `least_distance` (m) is that of a direction.
SurfacePoint Evaluate(const SurfaceFeature& feature, const Vector3d& x, double least_distance) {
  SurfacePoint result;
  Vector3d offset = x - feature.point;
  result.normal = feature.normal;
  result.gap = feature.normal.dot(offset);
  if (feature.kind == SurfaceFeature::Kind::kPlane) return result;
  offset -= feature.along.dot(offset) * feature.along;
  const double sign = result.gap < 0.0 ? -1.0 : 1.0;
  const double distance = offset.stableNorm();
  result.gap = sign * distance;
  if (distance <= least_distance) return result;
  const Vector3d& n = result.normal = offset * (sign / distance);
  result.normal_gradient =
      (sign / distance) * (Matrix3d::Identity() - n * n.transpose() - feature.along * feature.along.transpose());
  return result;
}

// Builds the features of a mesh: first those of the faces, then of the edges, then of the vertices.
class FeatureBuilder {
 public:
  explicit FeatureBuilder(const Mesh& mesh) : mesh_(mesh) {}

  void Build() {
    triangles_.resize(mesh_.num_faces());
    for (int face = 0; face < mesh_.num_faces(); ++face) AddFace(face);
    AddEdges();
    AddVertices();
  }

  std::vector<SearchTriangle> TakeTriangles() { return std::move(triangles_); }
  std::vector<SurfaceFeature> TakeFeatures() { return std::move(features_); }

 private:
  Vector3d Position(int vertex) const { return mesh_.rest_positions.col(vertex); }

  void AddFace(int face) {
    SearchTriangle& triangle = triangles_[face];
    triangle.Place(Position(mesh_.faces(0, face)), Position(mesh_.faces(1, face)), Position(mesh_.faces(2, face)));
    triangle.feature = face;
    features_.push_back({SurfaceFeature::Kind::kPlane, triangle.corners[0], triangle.normal, Vector3d::Zero()});
  }

  // Walks every edge from the triangle that runs along it from its lower to its higher vertex.
  void AddEdges() {
    std::map<std::pair<int, int>, std::pair<int, int>> sides;  // by their two ends: face and side
    for (int face = 0; face < mesh_.num_faces(); ++face) {
      for (int k = 0; k < 3; ++k) sides[{mesh_.faces(k, face), mesh_.faces((k + 1) % 3, face)}] = {face, k};
    }
    for (const auto& [ends, side] : sides) {
      const std::string name = "edge " + std::to_string(ends.first) + "-" + std::to_string(ends.second);
      const auto twin = sides.find({ends.second, ends.first});
      if (twin == sides.end()) {
        FailOnSurface(name + " belongs to one triangle only (" + std::to_string(side.first) +
                      "); expected a closed surface: holes filled, a sheet with a thickness");
      }
      if (ends.first > ends.second) continue;
      AddEdge(side, twin->second, name);
    }
  }

  void AddEdge(const std::pair<int, int>& side, const std::pair<int, int>& twin, const std::string& name) {
    SearchTriangle& one = triangles_[side.first];
    SearchTriangle& other = triangles_[twin.first];
    SurfaceFeature edge;
    edge.point = one.corners[side.second];
    edge.normal = one.normal + other.normal;
    if (edge.normal.norm() < kFlat) FailOnSurface("the two triangles at " + name + " lie flat on each other");
    edge.normal.normalize();
    if ((one.normal - other.normal).norm() >= kFlat) {
      edge.kind = SurfaceFeature::Kind::kCrease;
      edge.along = one.sides[side.second].normalized();
    }
    one.side_features[side.second] = static_cast<int>(features_.size());
    other.side_features[twin.second] = static_cast<int>(features_.size());
    features_.push_back(edge);
  }

  void AddVertices() {
    std::vector<Vector3d> sums(mesh_.num_nodes(), Vector3d::Zero());  // by angle
    std::vector<Matrix3d> spans(sums.size(), Matrix3d::Zero());       // of the normals
    const int first_feature = static_cast<int>(features_.size());
    for (int face = 0; face < mesh_.num_faces(); ++face) {
      SearchTriangle& triangle = triangles_[face];
      for (std::size_t k = 0; k < 3; ++k) {
        const int vertex = mesh_.faces(static_cast<int>(k), face);
        const Vector3d& ahead = triangle.sides[k];
        const Vector3d back = -triangle.sides[(k + 2) % 3];
        const double angle = std::atan2(ahead.cross(back).norm(), ahead.dot(back));
        sums[vertex] += angle * triangle.normal;
        spans[vertex] += triangle.normal * triangle.normal.transpose();
        triangle.corner_features[k] = first_feature + vertex;
      }
    }
    for (int vertex = 0; vertex < mesh_.num_nodes(); ++vertex) {
      AddVertex(vertex, sums[vertex], spans[vertex]);
    }
  }

  // The normals around a vertex span one direction in a plane, two at a straight crease, else three.
  void AddVertex(int vertex, const Vector3d& normal_sum, const Matrix3d& span) {
    SurfaceFeature feature;
    feature.point = Position(vertex);
    if (normal_sum.norm() < kFlat)
      FailOnSurface("the triangles around vertex " + std::to_string(vertex) + " have no outside");
    feature.normal = normal_sum.normalized();
    const Spectrum3 eigen = SymmetricSpectrum(span);  // eigenvalues ascend
    const double flat = kFlat * kFlat * span.trace();
    const auto is_flat = [&](int i) { return eigen.values[i] < flat; };
    if (!is_flat(1)) feature.kind = is_flat(0) ? SurfaceFeature::Kind::kCrease : SurfaceFeature::Kind::kCorner;
    if (feature.kind == SurfaceFeature::Kind::kCrease) feature.along = eigen.vectors.col(0);
    features_.push_back(feature);
  }

  const Mesh& mesh_;
  std::vector<SearchTriangle> triangles_;
  std::vector<SurfaceFeature> features_;
};

double Volume(const Mesh& mesh) {
  const auto corner = [&](int k, int face) -> Vector3d {
    return mesh.rest_positions.col(mesh.faces(k, face)) - mesh.rest_positions.col(0);
  };
  double volume = 0.0;
  for (int f = 0; f < mesh.num_faces(); ++f) volume += corner(0, f).dot(corner(1, f).cross(corner(2, f))) / 6.0;
  return volume;
}

void Validate(const Mesh& mesh) {
  if (mesh.num_faces() > kMaxSurfaceFaces) {
    FailOnSurface(std::to_string(mesh.num_faces()) + " triangles; expected at most " +
                  std::to_string(kMaxSurfaceFaces));
  }
  ValidateMesh(mesh, "triangulated surface");
}

}  // namespace

struct TriangulatedSurface::Data {
  Mesh mesh;
  TriangleTree tree;
  std::vector<SurfaceFeature> features;
  double least_distance = 0.0;  // m, see Evaluate
};

TriangulatedSurface::TriangulatedSurface(Eigen::Matrix3Xd vertices, Eigen::Matrix3Xi faces) {
  auto data = std::make_shared<Data>();
  data->mesh = {std::move(vertices), std::move(faces)};
  Validate(data->mesh);
  FeatureBuilder builder(data->mesh);
  builder.Build();
  if (!(Volume(data->mesh) > 0.0)) {
    FailOnSurface("encloses no positive volume; expected triangles that run counter-clockwise seen from outside");
  }
  data->features = builder.TakeFeatures();
  data->tree = TriangleTree(builder.TakeTriangles());
  data->least_distance = kSingularDistance * data->mesh.rest_positions.cwiseAbs().maxCoeff();
  data_ = std::move(data);
}

SurfacePoint TriangulatedSurface::Closest(const Eigen::Vector3d& position) const {
  return Evaluate(data_->features[data_->tree.ClosestFeature(position)], position, data_->least_distance);
}

const Eigen::Matrix3Xd& TriangulatedSurface::vertices() const { return data_->mesh.rest_positions; }
const Eigen::Matrix3Xi& TriangulatedSurface::faces() const { return data_->mesh.faces; }

}  // namespace clothid
