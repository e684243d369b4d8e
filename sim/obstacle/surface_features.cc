#include "sim/obstacle/surface_features.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <utility>

#include "sim/matrix/dense.h"

namespace clothid {

using Eigen::Matrix3d;
using Eigen::Vector3d;

namespace {

// The angle, in rad, below which normals count as equal: the rounding of coordinates given to seven digits.
constexpr double kFlat = 1e-7;

Vector3d NormalSum(const SearchTriangle& one, const SearchTriangle& other) { return one.normal + other.normal; }

// Six times the volume of the cones from the first corner of all.
double Volume(const std::vector<SearchTriangle>& triangles) {
  double volume = 0.0;
  for (const SearchTriangle& triangle : triangles) {
    const auto corner = [&](std::size_t k) -> Vector3d { return triangle.corners[k] - triangles[0].corners[0]; };
    volume += corner(0).dot(corner(1).cross(corner(2)));
  }
  return volume;
}

}  // namespace

SurfacePoint EvaluateFeature(const SurfaceFeature& feature, const Vector3d& x, double least_distance) {
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

// Finds every edge from the triangle that runs along it from its lower to its higher vertex.
SurfaceTopology::SurfaceTopology(const Mesh& mesh)
    : num_faces_(mesh.num_faces()), corners_(static_cast<std::size_t>(mesh.num_nodes())) {
  std::map<std::pair<int, int>, Side> sides;  // by their two ends
  for (int face = 0; face < num_faces_; ++face) {
    for (int k = 0; k < 3; ++k) {
      sides[{mesh.faces(k, face), mesh.faces((k + 1) % 3, face)}] = {face, k};
      corners_[static_cast<std::size_t>(mesh.faces(k, face))].push_back({face, k});
    }
  }
  for (const auto& [ends, side] : sides) {
    const auto twin = sides.find({ends.second, ends.first});
    if (twin == sides.end()) {
      throw MeshError("triangulated surface",
                      "edge " + std::to_string(ends.first) + "-" + std::to_string(ends.second) +
                          " belongs to one triangle only (" + std::to_string(side.face) +
                          "); expected a closed surface: holes filled, a sheet with a thickness",
                      {side.face});
    }
    if (ends.first < ends.second) edges_.push_back({side, twin->second, ends.first, ends.second});
  }
}

void SurfaceTopology::NumberFeatures(std::vector<SearchTriangle>* triangles) const {
  int feature = 0;
  for (SearchTriangle& triangle : *triangles) triangle.feature = feature++;
  for (const Edge& edge : edges_) {
    for (const Side& side : {edge.one, edge.other}) (*triangles)[side.face].side_features[side.side] = feature;
    ++feature;
  }
  for (const std::vector<Side>& corners : corners_) {
    for (const Side& corner : corners) (*triangles)[corner.face].corner_features[corner.side] = feature;
    ++feature;
  }
}

SurfaceFeature SurfaceTopology::FeatureAt(int feature, const std::vector<SearchTriangle>& triangles) const {
  if (feature < num_faces_) {
    const SearchTriangle& triangle = triangles[feature];
    return {SurfaceFeature::Kind::kPlane, triangle.corners[0], triangle.normal, Vector3d::Zero()};
  }
  const int edge = feature - num_faces_, num_edges = static_cast<int>(edges_.size());
  return edge < num_edges ? EdgeAt(edges_[edge], triangles) : VertexAt(corners_[edge - num_edges], triangles);
}

SurfaceFeature SurfaceTopology::EdgeAt(const Edge& edge, const std::vector<SearchTriangle>& triangles) const {
  const SearchTriangle &one = triangles[edge.one.face], &other = triangles[edge.other.face];
  SurfaceFeature feature;
  feature.point = one.corners[edge.one.side];
  feature.normal = NormalSum(one, other).normalized();
  if ((one.normal - other.normal).norm() < kFlat) return feature;
  feature.kind = SurfaceFeature::Kind::kCrease;
  feature.along = one.sides[edge.one.side].normalized();
  return feature;
}

// The normals around a vertex span one direction in a plane, two at a straight crease, else three.
SurfaceFeature SurfaceTopology::VertexAt(const std::vector<Side>& corners,
                                         const std::vector<SearchTriangle>& triangles) const {
  Vector3d sum = Vector3d::Zero();   // of the normals, by angle
  Matrix3d span = Matrix3d::Zero();  // of the normals
  for (const auto& [face, corner] : corners) {
    const SearchTriangle& triangle = triangles[face];
    const Vector3d& ahead = triangle.sides[corner];
    const Vector3d back = -triangle.sides[(corner + 2) % 3];
    sum += std::atan2(ahead.cross(back).norm(), ahead.dot(back)) * triangle.normal;
    span += triangle.normal * triangle.normal.transpose();
  }
  SurfaceFeature feature;
  feature.point = triangles[corners[0].face].corners[corners[0].side];
  if (sum.norm() >= kFlat) feature.normal = sum.normalized();
  const Spectrum3 eigen = SymmetricSpectrum(span);  // eigenvalues ascend
  const double flat = kFlat * kFlat * span.trace();
  const auto is_flat = [&](int i) { return eigen.values[i] < flat; };
  if (!is_flat(1)) feature.kind = is_flat(0) ? SurfaceFeature::Kind::kCrease : SurfaceFeature::Kind::kCorner;
  if (feature.kind == SurfaceFeature::Kind::kCrease) feature.along = eigen.vectors.col(0);
  return feature;
}

int SurfaceTopology::FaceOf(int feature) const {
  if (feature < num_faces_) return feature;
  const int edge = feature - num_faces_, num_edges = static_cast<int>(edges_.size());
  return edge < num_edges ? edges_[edge].one.face : corners_[edge - num_edges].front().face;
}

void SurfaceTopology::ExpectOutside(const std::vector<SearchTriangle>& triangles, const std::string& source) const {
  for (int face = 0; face < num_faces_; ++face) {
    const std::array<Vector3d, 3>& sides = triangles[face].sides;
    const double longest = std::max({sides[0].squaredNorm(), sides[1].squaredNorm(), sides[2].squaredNorm()});
    if (sides[0].cross(sides[1]).norm() > kDegenerate * longest) continue;
    throw MeshError(source, "triangle " + std::to_string(face) + " has no area", {face});
  }
  for (const Edge& edge : edges_) {
    if (NormalSum(triangles[edge.one.face], triangles[edge.other.face]).norm() >= kFlat) continue;
    throw MeshError(source,
                    "the two triangles at edge " + std::to_string(edge.low) + "-" + std::to_string(edge.high) +
                        " lie flat on each other",
                    {edge.one.face});
  }
  if (Volume(triangles) > 0.0) return;
  throw MeshError(source,
                  "encloses no positive volume; expected triangles that run counter-clockwise seen from outside", {});
}

}  // namespace clothid
