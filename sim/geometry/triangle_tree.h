// The nearest of many triangles: a search tree that names the face, edge or vertex which holds the closest point.
#ifndef CLOTHID_SIM_GEOMETRY_TRIANGLE_TREE_H_
#define CLOTHID_SIM_GEOMETRY_TRIANGLE_TREE_H_

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <memory>
#include <unsupported/Eigen/BVH>
#include <vector>

namespace clothid {

// A face as the search needs it. Side k runs from corner k to corner k + 1 and is opposite to corner k + 2 (mod 3).
// Features are numbered by the caller: edges and vertices have one number in all triangles that share them.
struct SearchTriangle {
  std::array<Eigen::Vector3d, 3> corners, sides;
  std::array<Eigen::Vector3d, 2> gradients;  // of the barycentric coordinates of corners 1 and 2, 1/m
  Eigen::Vector3d normal;                    // a unit vector
  int feature = 0;                           // of the face
  std::array<int, 3> side_features = {0, 0, 0}, corner_features = {0, 0, 0};

  // Fills everything but the features.
  void Place(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c);
  // Of the projection of x into the plane of the triangle: [3], sum 1, negative beyond a side.
  Eigen::Vector3d Barycentric(const Eigen::Vector3d& x) const;
};

// `ClosestFeature` may be called from several threads and allocates nothing. Copies share the hierarchy.
class TriangleTree {
 public:
  TriangleTree() = default;
  explicit TriangleTree(std::vector<SearchTriangle> triangles);

  // Moves the corners of the triangles to the columns of `vertices` that `faces` [3 x F] names. The hierarchy stays,
  // its boxes are fitted again, in time proportional to F.
  void Refit(const Eigen::Matrix3Xd& vertices, const Eigen::Matrix3Xi& faces);

  // The feature that is nearest to x, the lowest one where several are equally near. There must be a triangle.
  int ClosestFeature(const Eigen::Vector3d& x) const;

  const std::vector<SearchTriangle>& triangles() const { return triangles_; }

 private:
  std::vector<SearchTriangle> triangles_;
  // Other libraries have trees of triangles, too: Embree's is in single precision, CGAL's comes under the GPL.
  std::shared_ptr<const Eigen::KdBVH<double, 3, int>> tree_;
  std::vector<Eigen::AlignedBox3d> boxes_;  // of its nodes; those of the tree itself stay where it was built
};

}  // namespace clothid

#endif  // CLOTHID_SIM_GEOMETRY_TRIANGLE_TREE_H_
