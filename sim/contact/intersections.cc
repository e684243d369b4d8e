#include "sim/contact/intersections.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace clothid {
namespace {

using Eigen::Vector3d;
using Triangle = std::array<Vector3d, 3>;

// Of a determinant below, relative to the sum of the absolute values of its terms (Shewchuk 1997, "Adaptive precision
// floating-point arithmetic and fast robust geometric predicates": (7 + 56 eps) eps, eps = 2^-53).
constexpr double kRounding = 7.8e-16;

// The sign of the volume of a tetrahedron; 0 where rounding could have made it.
int VolumeSign(const Vector3d& a, const Vector3d& b, const Vector3d& c, const Vector3d& d) {
  const Vector3d x = a - d, y = b - d, z = c - d;
  double volume = 0.0, size = 0.0;
  for (int i = 0; i < 3; ++i) {
    const int j = (i + 1) % 3, k = (i + 2) % 3;
    volume += z[i] * (x[j] * y[k] - x[k] * y[j]);
    size += std::abs(z[i]) * (std::abs(x[j] * y[k]) + std::abs(x[k] * y[j]));
  }
  if (!(std::abs(volume) > kRounding * size)) return 0;
  return volume > 0.0 ? 1 : -1;
}

bool PassesThrough(const Vector3d& p, const Vector3d& q, const Triangle& face) {
  const int side = VolumeSign(face[0], face[1], face[2], p);
  if (side == 0 || VolumeSign(face[0], face[1], face[2], q) != -side) return false;
  const int turn = VolumeSign(p, q, face[0], face[1]);
  return turn != 0 && VolumeSign(p, q, face[1], face[2]) == turn && VolumeSign(p, q, face[2], face[0]) == turn;
}

bool AnySidePassesThrough(const Triangle& sides, const Triangle& face) {
  for (std::size_t k = 0; k < 3; ++k) {
    if (PassesThrough(sides[k], sides[(k + 1) % 3], face)) return true;
  }
  return false;
}

Triangle Corners(const Eigen::Matrix3Xi& faces, const Eigen::VectorXd& positions, int face) {
  Triangle corners;
  for (int k = 0; k < 3; ++k) corners[k] = positions.segment<3>(3 * faces(k, face));
  return corners;
}

bool ShareNode(const Eigen::Matrix3Xi& faces, int a, int b) {
  for (const int node : faces.col(a)) {
    if ((faces.col(b).array() == node).any()) return true;
  }
  return false;
}

}  // namespace

IntersectionCounter::IntersectionCounter(const Mesh& mesh) : faces_(mesh.faces), boxes_(mesh.num_faces()) {
  Place(mesh.rest_positions.reshaped());
  tree_ = BoxTree(boxes_);
}

void IntersectionCounter::Place(const Eigen::VectorXd& positions) {
  for (std::size_t f = 0; f < boxes_.size(); ++f) {
    boxes_[f].setEmpty();
    for (const Vector3d& corner : Corners(faces_, positions, static_cast<int>(f))) boxes_[f].extend(corner);
  }
}

Intersections IntersectionCounter::Count(const Eigen::VectorXd& positions) {
  Place(positions);
  tree_.Refit(boxes_);
  Intersections result;
  tree_.VisitPairs([&](int f, int other) {
    if (ShareNode(faces_, f, other)) return;
    const Triangle face = Corners(faces_, positions, f), other_face = Corners(faces_, positions, other);
    if (!AnySidePassesThrough(face, other_face) && !AnySidePassesThrough(other_face, face)) return;
    const std::array<int, 2> pair = {f, other};
    if (result.count == 0 || pair < result.first) result.first = pair;
    ++result.count;
  });
  return result;
}

}  // namespace clothid
