#include "identify/prediction/derived.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <charconv>
#include <cmath>
#include <map>
#include <numeric>
#include <string_view>

#include "sim/base/error.h"
#include "sim/base/text_file.h"
#include "sim/mesh/mesh.h"

namespace clothid {
namespace {

constexpr double kSquaresPerEdge = 16.0;
constexpr double kMostSquares = 1e7;  // a raster that would have more has larger squares

const std::map<std::string_view, DerivedKind>& DerivedWords() {
  static const std::map<std::string_view, DerivedKind> words = {{"area", DerivedKind::kArea},
                                                                {"strain", DerivedKind::kStrain},
                                                                {"force", DerivedKind::kForce},
                                                                {"slip", DerivedKind::kSlip}};
  return words;
}

DerivedRequest ParseOne(const std::string& item, const std::string& flag, const Scene& scene) {
  constexpr std::string_view kPoint = "point:";
  if (const auto word = DerivedWords().find(item); word != DerivedWords().end()) return {word->second, 0, item};
  if (item.rfind(kPoint, 0) == 0) {
    int node = -1;
    const char* const end = item.data() + item.size();
    const auto [parsed, error] = std::from_chars(item.data() + kPoint.size(), end, node);
    if (error == std::errc() && parsed == end && node >= 0 && node < scene.mesh.num_nodes()) {
      return {DerivedKind::kPoint, node, "point_" + std::to_string(node)};
    }
    throw Error(ErrorKind::kUsage, flag + ": '" + Printable(item) + "': expected a node from 0 to " +
                                       std::to_string(scene.mesh.num_nodes() - 1));
  }
  throw Error(ErrorKind::kUsage,
              flag + ": expected some of point:NODE, area, strain, force and slip, got '" + Printable(item) + "'");
}

// Two unit vectors across gravity; without it across z.
Eigen::Matrix<double, 2, 3> AcrossGravity(const Eigen::Vector3d& gravity) {
  const Eigen::Vector3d down = gravity.norm() > 0.0 ? Eigen::Vector3d(gravity.normalized()) : -Eigen::Vector3d::UnitZ();
  const Eigen::Vector3d first = down.unitOrthogonal();
  Eigen::Matrix<double, 2, 3> axes;
  axes << first.transpose(), down.cross(first).transpose();
  return axes;
}

// Squares whose middle is covered.
class Raster {
 public:
  Raster(const Eigen::Vector2d& low, const Eigen::Vector2d& high, double side) : low_(low), side_(side) {
    size_ = ((high - low) / side).array().ceil().cast<Eigen::Index>() + 1;
    covered_.assign(static_cast<std::size_t>(size_[0] * size_[1]), 0);
  }

  // The corners are the columns.
  void Cover(const Eigen::Matrix<double, 2, 3>& triangle) {
    const Eigen::Vector2d a = triangle.col(0), ab = triangle.col(1) - a, ac = triangle.col(2) - a;
    const double twice = ab[0] * ac[1] - ab[1] * ac[0];
    if (twice == 0.0) return;
    const Eigen::Array<Eigen::Index, 2, 1> first = SquareOf(triangle.rowwise().minCoeff());
    const Eigen::Array<Eigen::Index, 2, 1> last = SquareOf(triangle.rowwise().maxCoeff());
    for (Eigen::Index j = first[1]; j <= last[1]; ++j) {
      for (Eigen::Index i = first[0]; i <= last[0]; ++i) {
        const Eigen::Vector2d p =
            low_ + side_ * Eigen::Vector2d(static_cast<double>(i) + 0.5, static_cast<double>(j) + 0.5) - a;
        const double s = (p[0] * ac[1] - p[1] * ac[0]) / twice, t = (ab[0] * p[1] - ab[1] * p[0]) / twice;
        if (s >= 0.0 && t >= 0.0 && s + t <= 1.0) covered_[static_cast<std::size_t>(i + size_[0] * j)] = 1;
      }
    }
  }

  double Area() const {
    return side_ * side_ * static_cast<double>(std::accumulate(covered_.begin(), covered_.end(), 0L));
  }

 private:
  Eigen::Array<Eigen::Index, 2, 1> SquareOf(const Eigen::Vector2d& place) const {
    return ((place - low_) / side_).array().floor().cast<Eigen::Index>().max(0).min(size_ - 1);
  }

  Eigen::Vector2d low_;
  double side_;
  Eigen::Array<Eigen::Index, 2, 1> size_;
  std::vector<char> covered_;
};

}  // namespace

std::vector<DerivedRequest> ParseDerived(const std::string& text, const std::string& flag, const Scene& scene) {
  std::vector<DerivedRequest> requests;
  for (const std::string& item : Split(text, ',')) {
    const DerivedRequest request = ParseOne(std::string(Trimmed(item)), flag, scene);
    const auto is_same = [&](const DerivedRequest& other) { return other.name == request.name; };
    ExpectUsage(std::none_of(requests.begin(), requests.end(), is_same),
                flag + ": '" + request.name + "' is given twice");
    ExpectUsage(request.kind != DerivedKind::kForce || !scene.handles.nodes.empty(),
                flag + ": 'force': expected a scene with handles");
    ExpectUsage(request.kind != DerivedKind::kSlip || !scene.obstacles.empty(),
                flag + ": 'slip': expected a scene with obstacles");
    requests.push_back(request);
  }
  return requests;
}

const char* UnitOf(DerivedKind kind) {
  switch (kind) {
    case DerivedKind::kPoint:
      return "m";
    case DerivedKind::kArea:
      return "m^2";
    case DerivedKind::kStrain:
      return "";
    case DerivedKind::kForce:
      return "N";
    case DerivedKind::kSlip:
      return "s";
  }
  return "";
}

std::vector<std::vector<int>> GripperNodes(const Scene& scene) {
  const std::vector<int>& nodes = scene.handles.nodes;
  std::vector<int> handle_of(static_cast<std::size_t>(scene.mesh.num_nodes()), -1);
  for (std::size_t h = 0; h < nodes.size(); ++h) handle_of[static_cast<std::size_t>(nodes[h])] = static_cast<int>(h);
  std::vector<int> gripper(nodes.size());
  std::iota(gripper.begin(), gripper.end(), 0);
  const auto join = [&](int a, int b) {
    const int from = std::max(gripper[static_cast<std::size_t>(a)], gripper[static_cast<std::size_t>(b)]);
    const int to = std::min(gripper[static_cast<std::size_t>(a)], gripper[static_cast<std::size_t>(b)]);
    std::replace(gripper.begin(), gripper.end(), from, to);
  };
  for (const auto& face : scene.mesh.faces.colwise()) {
    for (int i = 0; i < 3; ++i) {
      const int a = handle_of[static_cast<std::size_t>(face[i])];
      const int b = handle_of[static_cast<std::size_t>(face[(i + 1) % 3])];
      if (a >= 0 && b >= 0) join(a, b);
    }
  }
  std::map<int, std::vector<int>> grippers;
  for (std::size_t h = 0; h < nodes.size(); ++h) grippers[gripper[h]].push_back(nodes[h]);
  std::vector<std::vector<int>> ordered;
  for (const auto& [first, held] : grippers) ordered.push_back(held);
  return ordered;
}

double CoveredArea(const Scene& scene, const Eigen::Ref<const Eigen::VectorXd>& x) {
  const Eigen::Matrix<double, 2, 3> axes = AcrossGravity(scene.gravity);
  const Eigen::Matrix2Xd seen = axes * x.reshaped(3, x.size() / 3);
  const Eigen::Vector2d low = seen.rowwise().minCoeff(), high = seen.rowwise().maxCoeff();
  double edge = 0.0;
  const Mesh& mesh = scene.mesh;
  for (int f = 0; f < mesh.num_faces(); ++f) edge += (RestCorner(mesh, f, 1) - RestCorner(mesh, f, 0)).norm();
  edge /= mesh.num_faces();
  const double side = std::max(edge / kSquaresPerEdge, std::sqrt((high - low).prod() / kMostSquares));
  Raster raster(low, high, side);
  for (const auto& face : mesh.faces.colwise()) {
    Eigen::Matrix<double, 2, 3> triangle;
    for (int k = 0; k < 3; ++k) triangle.col(k) = seen.col(face[k]);
    raster.Cover(triangle);
  }
  return raster.Area();
}

// The squared principal stretches are the eigenvalues of G_0^-1 G, G = E^T E of the edges E of a triangle.
double LargestStrain(const Mesh& mesh, const Eigen::Ref<const Eigen::VectorXd>& x) {
  double largest = 0.0;
  for (int f = 0; f < mesh.num_faces(); ++f) {
    Eigen::Matrix<double, 3, 2> rest, now;
    const auto corner = [&](int k) { return x.segment<3>(3 * static_cast<Eigen::Index>(mesh.faces(k, f))); };
    for (int k = 0; k < 2; ++k) {
      rest.col(k) = RestCorner(mesh, f, k + 1) - RestCorner(mesh, f, 0);
      now.col(k) = corner(k + 1) - corner(0);
    }
    const Eigen::Matrix2d squared = (rest.transpose() * rest).inverse() * (now.transpose() * now);
    const double half = 0.5 * (squared(0, 0) - squared(1, 1)), product = squared(0, 1) * squared(1, 0);
    largest = std::max(largest, 0.5 * squared.trace() + std::sqrt(std::max(half * half + product, 0.0)));
  }
  return std::sqrt(largest) - 1.0;
}

}  // namespace clothid
