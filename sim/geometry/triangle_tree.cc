#include "sim/geometry/triangle_tree.h"

#include <cstddef>
#include <limits>
#include <utility>

namespace clothid {
namespace {

using Eigen::Vector3d;
using Tree = Eigen::KdBVH<double, 3, int>;

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
void VisitTriangle(const SearchTriangle& triangle, const Vector3d& x, Nearest* nearest) {
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

double SquaredDistance(const Eigen::AlignedBox3d& box, const Vector3d& x) {
  return (box.min() - x).cwiseMax(x - box.max()).cwiseMax(0.0).squaredNorm();
}

// Goes down the tree, nearer boxes first. (Eigen::BVMinimize would allocate a queue for every point.)
void VisitTree(const Tree& tree, const std::vector<Eigen::AlignedBox3d>& bounds,
               const std::vector<SearchTriangle>& triangles, int node, const Vector3d& x, Nearest* nearest) {
  Tree::VolumeIterator box = nullptr, box_end = nullptr;
  Tree::ObjectIterator face = nullptr, face_end = nullptr;
  tree.getChildren(node, box, box_end, face, face_end);
  for (; face != face_end; ++face) VisitTriangle(triangles[*face], x, nearest);
  std::array<std::pair<double, int>, 2> boxes;
  std::size_t num_boxes = 0;
  for (; box != box_end; ++box) boxes[num_boxes++] = {SquaredDistance(bounds[*box], x), *box};
  if (num_boxes == 2 && boxes[1].first < boxes[0].first) std::swap(boxes[0], boxes[1]);
  for (std::size_t i = 0; i < num_boxes; ++i) {
    if (boxes[i].first <= nearest->squared_distance) VisitTree(tree, bounds, triangles, boxes[i].second, x, nearest);
  }
}

Eigen::AlignedBox3d BoxAround(const SearchTriangle& triangle) {
  Eigen::AlignedBox3d box(triangle.corners[0]);
  return box.extend(triangle.corners[1]).extend(triangle.corners[2]);
}

std::shared_ptr<const Tree> BuildTree(const std::vector<SearchTriangle>& triangles) {
  std::vector<int> faces;
  std::vector<Tree::Volume> boxes;
  for (const SearchTriangle& triangle : triangles) {
    faces.push_back(static_cast<int>(faces.size()));
    boxes.push_back(BoxAround(triangle));
  }
  return std::make_shared<const Tree>(faces.begin(), faces.end(), boxes.begin(), boxes.end());
}

// Of the nodes of a tree, of which children come before their parents and the root is the last.
std::vector<Eigen::AlignedBox3d> BoxesOf(const Tree& tree) {
  std::vector<Eigen::AlignedBox3d> boxes;
  for (int node = 0; node <= tree.getRootIndex(); ++node) boxes.push_back(tree.getVolume(node));
  return boxes;
}

}  // namespace

void SearchTriangle::Place(const Vector3d& a, const Vector3d& b, const Vector3d& c) {
  corners = {a, b, c};
  for (std::size_t k = 0; k < 3; ++k) sides[k] = corners[(k + 1) % 3] - corners[k];
  const Vector3d area = sides[0].cross(sides[1]);
  normal = area.normalized();
  gradients[0] = normal.cross(sides[2]) / area.norm();
  gradients[1] = normal.cross(sides[0]) / area.norm();
}

Vector3d SearchTriangle::Barycentric(const Vector3d& x) const {
  const Vector3d offset = x - corners[0];
  const double at_1 = gradients[0].dot(offset), at_2 = gradients[1].dot(offset);
  return {1.0 - at_1 - at_2, at_1, at_2};
}

TriangleTree::TriangleTree(std::vector<SearchTriangle> triangles)
    : triangles_(std::move(triangles)), tree_(BuildTree(triangles_)), boxes_(BoxesOf(*tree_)) {}

void TriangleTree::Refit(const Eigen::Matrix3Xd& vertices, const Eigen::Matrix3Xi& faces) {
  for (std::size_t i = 0; i < triangles_.size(); ++i) {
    const auto corners = faces.col(static_cast<Eigen::Index>(i));
    triangles_[i].Place(vertices.col(corners[0]), vertices.col(corners[1]), vertices.col(corners[2]));
  }
  for (std::size_t node = 0; node < boxes_.size(); ++node) {
    Tree::VolumeIterator child = nullptr, child_end = nullptr;
    Tree::ObjectIterator face = nullptr, face_end = nullptr;
    tree_->getChildren(static_cast<int>(node), child, child_end, face, face_end);
    boxes_[node].setEmpty();
    for (; face != face_end; ++face) boxes_[node].extend(BoxAround(triangles_[*face]));
    for (; child != child_end; ++child) boxes_[node].extend(boxes_[*child]);
  }
}

int TriangleTree::ClosestFeature(const Vector3d& x) const {
  Nearest nearest;
  VisitTree(*tree_, boxes_, triangles_, tree_->getRootIndex(), x, &nearest);
  return nearest.feature;
}

}  // namespace clothid
