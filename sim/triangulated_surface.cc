#include "sim/triangulated_surface.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <string>
#include <unsupported/Eigen/BVH>
#include <utility>
#include <vector>

#include "sim/error.h"
#include "sim/mesh.h"

namespace clothid {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

// Other libraries have trees of triangles, too: Embree's is in single precision, CGAL's comes under the GPL.
using Tree = Eigen::KdBVH<double, 3, int>;

// The angle, in rad, below which normals count as equal: the rounding of coordinates given to seven digits.
constexpr double kFlat = 1e-7;

// Nearer to an edge or vertex than this share of the largest coordinate there is no direction to speak of.
constexpr double kSingular = 1e-12;

[[noreturn]] void Fail(const std::string& message) {
  throw Error(ErrorKind::kBadData, "triangulated surface: " + message);
}

// What can be closest to a point: a face, an edge or a vertex. The normal is constant on a plane, turns about a crease
// and points away from a corner; an edge within a plane is a plane, a vertex within a straight edge a crease.
struct Feature {
  enum class Kind { kPlane, kCrease, kCorner };

  Kind kind = Kind::kPlane;
  Vector3d point = Vector3d::Zero();   // any point of it
  Vector3d normal = Vector3d::Zero();  // pseudonormal, a unit vector
  Vector3d along = Vector3d::Zero();   // of a crease, a unit vector
};

// A face as the search needs it. Side k runs from corner k to corner k + 1 and is opposite to corner k + 2 (mod 3).
struct Triangle {
  std::array<Vector3d, 3> corners, sides;
  std::array<Vector3d, 2> gradients;  // of the barycentric coordinates of corners 1 and 2, 1/m
  Vector3d normal;
  int feature;
  std::array<int, 3> side_features, corner_features;
};

// The nearest feature so far; the lowest one where several are equally near. (Beyond 1e154 m all are.)
struct Nearest {
  double squared_distance = std::numeric_limits<double>::infinity();
  int feature = 0;

  void Consider(double candidate, int candidate_feature) {
    if (candidate > squared_distance || (candidate == squared_distance && candidate_feature > feature)) return;
    squared_distance = candidate;
    feature = candidate_feature;
  }
};

// Where it is not within the face, the closest point lies on a side that does not have x on its inner side.
void VisitTriangle(const Triangle& triangle, const Vector3d& x, Nearest* nearest) {
  const Vector3d offset = x - triangle.corners[0];
  const double height = triangle.normal.dot(offset);
  if (height * height > nearest->squared_distance) return;
  const double at_1 = triangle.gradients[0].dot(offset), at_2 = triangle.gradients[1].dot(offset);
  const std::array<double, 3> opposite = {at_2, 1.0 - at_1 - at_2, at_1};  // to the sides
  if (opposite[0] > 0.0 && opposite[1] > 0.0 && opposite[2] > 0.0) {
    nearest->Consider(height * height, triangle.feature);
    return;
  }
  for (std::size_t k = 0; k < 3; ++k) {
    if (opposite[k] > 0.0) continue;
    const Vector3d from_corner = x - triangle.corners[k];
    const double along = triangle.sides[k].dot(from_corner), length = triangle.sides[k].squaredNorm();
    if (along <= 0.0) {
      nearest->Consider(from_corner.squaredNorm(), triangle.corner_features[k]);
    } else if (along >= length) {
      const std::size_t next = (k + 1) % 3;
      nearest->Consider((x - triangle.corners[next]).squaredNorm(), triangle.corner_features[next]);
    } else {
      nearest->Consider((from_corner - (along / length) * triangle.sides[k]).squaredNorm(), triangle.side_features[k]);
    }
  }
}

double SquaredDistance(const Tree::Volume& box, const Vector3d& x) {
  return (box.min() - x).cwiseMax(x - box.max()).cwiseMax(0.0).squaredNorm();
}

// Goes down the tree, nearer boxes first. (Eigen::BVMinimize would allocate a queue for every point.)
void VisitTree(const Tree& tree, const std::vector<Triangle>& triangles, int node, const Vector3d& x,
               Nearest* nearest) {
  Tree::VolumeIterator box = nullptr, box_end = nullptr;
  Tree::ObjectIterator face = nullptr, face_end = nullptr;
  tree.getChildren(node, box, box_end, face, face_end);
  for (; face != face_end; ++face) VisitTriangle(triangles[*face], x, nearest);
  std::array<std::pair<double, int>, 2> boxes;
  std::size_t num_boxes = 0;
  for (; box != box_end; ++box) boxes[num_boxes++] = {SquaredDistance(tree.getVolume(*box), x), *box};
  if (num_boxes == 2 && boxes[1].first < boxes[0].first) std::swap(boxes[0], boxes[1]);
  for (std::size_t i = 0; i < num_boxes; ++i) {
    if (boxes[i].first <= nearest->squared_distance) VisitTree(tree, triangles, boxes[i].second, x, nearest);
  }
}

// phi, n and dn/dx of points whose closest point is on `feature`. `least_distance` (m) is that of a direction.
SurfacePoint Evaluate(const Feature& feature, const Vector3d& x, double least_distance) {
  SurfacePoint result;
  Vector3d offset = x - feature.point;
  result.normal = feature.normal;
  result.gap = feature.normal.dot(offset);
  if (feature.kind == Feature::Kind::kPlane) return result;
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

  std::vector<Triangle> TakeTriangles() { return std::move(triangles_); }
  std::vector<Feature> TakeFeatures() { return std::move(features_); }

 private:
  Vector3d Position(int vertex) const { return mesh_.rest_positions.col(vertex); }

  void AddFace(int face) {
    Triangle& triangle = triangles_[face];
    for (int k = 0; k < 3; ++k) {
      triangle.corners[k] = Position(mesh_.faces(k, face));
      triangle.sides[k] = Position(mesh_.faces((k + 1) % 3, face)) - triangle.corners[k];
    }
    const Vector3d area = triangle.sides[0].cross(triangle.sides[1]);
    triangle.normal = area.normalized();
    triangle.gradients[0] = triangle.normal.cross(triangle.sides[2]) / area.norm();
    triangle.gradients[1] = triangle.normal.cross(triangle.sides[0]) / area.norm();
    triangle.feature = face;
    features_.push_back({Feature::Kind::kPlane, triangle.corners[0], triangle.normal, Vector3d::Zero()});
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
        Fail(name + " belongs to one triangle only (" + std::to_string(side.first) +
             "); expected a closed surface: holes filled, a sheet with a thickness");
      }
      if (ends.first > ends.second) continue;
      AddEdge(side, twin->second, name);
    }
  }

  void AddEdge(const std::pair<int, int>& side, const std::pair<int, int>& twin, const std::string& name) {
    Triangle& one = triangles_[side.first];
    Triangle& other = triangles_[twin.first];
    Feature edge;
    edge.point = one.corners[side.second];
    edge.normal = one.normal + other.normal;
    if (edge.normal.norm() < kFlat) Fail("the two triangles at " + name + " lie flat on each other");
    edge.normal.normalize();
    if ((one.normal - other.normal).norm() >= kFlat) {
      edge.kind = Feature::Kind::kCrease;
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
      Triangle& triangle = triangles_[face];
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
    Feature feature;
    feature.point = Position(vertex);
    if (normal_sum.norm() < kFlat) Fail("the triangles around vertex " + std::to_string(vertex) + " have no outside");
    feature.normal = normal_sum.normalized();
    const Eigen::SelfAdjointEigenSolver<Matrix3d> eigen(span);  // eigenvalues ascend
    const double flat = kFlat * kFlat * span.trace();
    const auto is_flat = [&](int i) { return eigen.eigenvalues()[i] < flat; };
    if (!is_flat(1)) feature.kind = is_flat(0) ? Feature::Kind::kCrease : Feature::Kind::kCorner;
    if (feature.kind == Feature::Kind::kCrease) feature.along = eigen.eigenvectors().col(0);
    features_.push_back(feature);
  }

  const Mesh& mesh_;
  std::vector<Triangle> triangles_;
  std::vector<Feature> features_;
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
    Fail(std::to_string(mesh.num_faces()) + " triangles; expected at most " + std::to_string(kMaxSurfaceFaces));
  }
  ValidateMesh(mesh, "triangulated surface");
}

Tree BuildTree(const std::vector<Triangle>& triangles) {
  std::vector<int> faces;
  std::vector<Tree::Volume> boxes;
  for (const Triangle& triangle : triangles) {
    faces.push_back(triangle.feature);
    boxes.emplace_back(triangle.corners[0]);
    boxes.back().extend(triangle.corners[1]).extend(triangle.corners[2]);
  }
  return Tree(faces.begin(), faces.end(), boxes.begin(), boxes.end());
}

}  // namespace

struct TriangulatedSurface::Data {
  Mesh mesh;
  std::vector<Triangle> triangles;
  std::vector<Feature> features;
  Tree tree;
  double least_distance = 0.0;  // m, see Evaluate
};

TriangulatedSurface::TriangulatedSurface(Eigen::Matrix3Xd vertices, Eigen::Matrix3Xi faces) {
  auto data = std::make_shared<Data>();
  data->mesh = {std::move(vertices), std::move(faces)};
  Validate(data->mesh);
  FeatureBuilder builder(data->mesh);
  builder.Build();
  if (!(Volume(data->mesh) > 0.0)) {
    Fail("encloses no positive volume; expected triangles that run counter-clockwise seen from outside");
  }
  data->triangles = builder.TakeTriangles();
  data->features = builder.TakeFeatures();
  data->tree = BuildTree(data->triangles);
  data->least_distance = kSingular * data->mesh.rest_positions.cwiseAbs().maxCoeff();
  data_ = std::move(data);
}

SurfacePoint TriangulatedSurface::Closest(const Eigen::Vector3d& position) const {
  Nearest nearest;
  VisitTree(data_->tree, data_->triangles, data_->tree.getRootIndex(), position, &nearest);
  return Evaluate(data_->features[nearest.feature], position, data_->least_distance);
}

const Eigen::Matrix3Xd& TriangulatedSurface::vertices() const { return data_->mesh.rest_positions; }
const Eigen::Matrix3Xi& TriangulatedSurface::faces() const { return data_->mesh.faces; }

}  // namespace clothid
