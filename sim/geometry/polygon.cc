#include "sim/geometry/polygon.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cstddef>
#include <numeric>

namespace clothid {
namespace {

using Triangle = std::array<int, 3>;

// Twice the area that counts as none, relative to that of a square about the polygon.
constexpr double kNoArea = 1e-12;

// A polygon as it is seen along its normal, counterclockwise.
class FlatPolygon {
 public:
  explicit FlatPolygon(const Eigen::Matrix3Xd& corners) {
    const Eigen::Index n = corners.cols();
    const Eigen::Matrix3Xd about_mean = corners.colwise() - corners.rowwise().mean();
    Eigen::Vector3d normal = Eigen::Vector3d::Zero();
    for (Eigen::Index i = 0; i < n; ++i) normal += about_mean.col(i).cross(about_mean.col((i + 1) % n));
    const double size = about_mean.cwiseAbs().maxCoeff();
    least_area_ = kNoArea * size * size;
    if (!(normal.norm() > least_area_)) return;
    const Eigen::Vector3d u = normal.unitOrthogonal(), v = normal.normalized().cross(u);
    places_.resize(2, n);
    places_ << u.transpose() * about_mean, v.transpose() * about_mean;
  }

  bool has_area() const { return places_.cols() > 0; }
  double least_area() const { return least_area_; }

  // Twice the area of three corners; negative where they turn the other way.
  double Area(int a, int b, int c) const {
    const Eigen::Vector2d ab = places_.col(b) - places_.col(a), ac = places_.col(c) - places_.col(a);
    return ab.x() * ac.y() - ab.y() * ac.x();
  }
  bool IsTriangle(int a, int b, int c) const { return Area(a, b, c) > least_area_; }
  // Whether corner `p` is in the triangle, or on its border.
  bool Holds(int a, int b, int c, int p) const {
    return Area(a, b, p) >= -least_area_ && Area(b, c, p) >= -least_area_ && Area(c, a, p) >= -least_area_;
  }

 private:
  double least_area_ = 0.0;
  Eigen::Matrix2Xd places_;  // empty: it has no area
};

// Whether two sides of it cross, between their ends.
bool CrossesItself(const FlatPolygon& polygon, int num_corners) {
  const auto are_apart = [&](int from, int to, int a, int b) {
    const double of_a = polygon.Area(from, to, a), of_b = polygon.Area(from, to, b);
    return std::min(of_a, of_b) < -polygon.least_area() && std::max(of_a, of_b) > polygon.least_area();
  };
  for (int i = 2; i < num_corners; ++i) {
    const int end = (i + 1) % num_corners;
    for (int k = i == num_corners - 1 ? 1 : 0; k + 1 < i; ++k) {
      if (are_apart(i, end, k, k + 1) && are_apart(k, k + 1, i, end)) return true;
    }
  }
  return false;
}

// Empty where a triangle turns over.
std::vector<Triangle> Fan(const FlatPolygon& polygon, int num_corners) {
  std::vector<Triangle> triangles;
  for (int k = 2; k < num_corners; ++k) {
    if (!polygon.IsTriangle(0, k - 1, k)) return {};
    triangles.push_back({0, k - 1, k});
  }
  return triangles;
}

// Whether place `i` of the corners that are left is an ear: a triangle that holds none of the others.
bool IsEar(const FlatPolygon& polygon, const std::vector<int>& left, std::size_t i) {
  const std::size_t n = left.size(), before = (i + n - 1) % n, after = (i + 1) % n;
  if (!polygon.IsTriangle(left[before], left[i], left[after])) return false;
  for (std::size_t k = 0; k < n; ++k) {
    if (k == before || k == i || k == after) continue;
    if (polygon.Holds(left[before], left[i], left[after], left[k])) return false;
  }
  return true;
}

// Empty where it comes to an end before all is cut.
std::vector<Triangle> Ears(const FlatPolygon& polygon, int num_corners) {
  std::vector<int> left(static_cast<std::size_t>(num_corners));
  std::iota(left.begin(), left.end(), 0);
  std::vector<Triangle> triangles;
  while (left.size() >= 3) {
    std::size_t ear = 0;
    while (ear < left.size() && !IsEar(polygon, left, ear)) ++ear;
    if (ear == left.size()) return {};
    const std::size_t n = left.size();
    triangles.push_back({left[(ear + n - 1) % n], left[ear], left[(ear + 1) % n]});
    left.erase(left.begin() + static_cast<std::ptrdiff_t>(ear));
  }
  return triangles;
}

}  // namespace

std::vector<Triangle> TrianglesOfPolygon(const Eigen::Matrix3Xd& corners) {
  const auto num_corners = static_cast<int>(corners.cols());
  if (num_corners == 3) return {{0, 1, 2}};
  const FlatPolygon polygon(corners);
  if (!polygon.has_area() || CrossesItself(polygon, num_corners)) return {};
  std::vector<Triangle> triangles = Fan(polygon, num_corners);
  return triangles.empty() ? Ears(polygon, num_corners) : triangles;
}

std::vector<Triangle> TrianglesLike(const Eigen::Matrix3Xi& faces, Eigen::Index first,
                                    const std::vector<int>& corners) {
  const Eigen::Index count = static_cast<Eigen::Index>(corners.size()) - 2;
  if (first + count > faces.cols()) return {};
  std::vector<Triangle> triangles;
  for (const auto face : faces.middleCols(first, count).colwise()) {
    Triangle triangle;
    for (int k = 0; k < 3; ++k) {
      const auto corner = std::find(corners.begin(), corners.end(), face[k]);
      if (corner == corners.end()) return {};
      triangle[k] = static_cast<int>(corner - corners.begin());
    }
    triangles.push_back(triangle);
  }
  return triangles;
}

}  // namespace clothid
