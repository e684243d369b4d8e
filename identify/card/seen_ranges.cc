#include "identify/card/seen_ranges.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <functional>
#include <utility>
#include <vector>

#include "sim/shell/bending_patch.h"

namespace clothid {
namespace {

using Kind = ParameterKind;

constexpr double kLeastShare = 0.01, kMostShare = 0.99;
constexpr double kPerSeen = 1e6;  // a millionth of strain, or of 1/m: less is rounding, which depends on the processor
constexpr Eigen::Index kMaxSamples = 1000000;  // triangles times frames that are looked at

// What a triangle tells of `kind` by its deformation gradient, whose columns are along warp and weft.
double StrainOf(Kind kind, const Eigen::Matrix<double, 3, 2>& gradient) {
  const double warp = gradient.col(0).norm(), weft = gradient.col(1).norm();
  const double shear = gradient.col(0).dot(gradient.col(1));
  if (kind == Kind::kWarpStiffness || kind == Kind::kWarpStiffening) return warp - 1.0;
  if (kind == Kind::kWeftStiffness || kind == Kind::kWeftStiffening) return weft - 1.0;
  if (kind == Kind::kShearStiffness) return std::abs(shear) / (warp * weft);
  const double mean = 0.5 * (warp * warp + weft * weft), half = 0.5 * (warp * warp - weft * weft);
  return std::sqrt(mean + std::hypot(half, shear)) - 1.0;
}

// Likewise by its curvatures kappa_11, kappa_22, kappa_12 beyond those at rest, 1/m.
double CurvatureOf(Kind kind, const Eigen::Vector3d& curvature) {
  if (kind == Kind::kWarpBending) return std::abs(curvature[0]);
  if (kind == Kind::kWeftBending) return std::abs(curvature[1]);
  if (kind == Kind::kTwistBending) return std::abs(curvature[2]);
  const double mean = 0.5 * (curvature[0] + curvature[1]), half = 0.5 * (curvature[0] - curvature[1]);
  return std::abs(mean) + std::hypot(half, curvature[2]);
}

// The triangles of a scene at rest, in axes along warp and weft where it has them.
class RestTriangles {
 public:
  explicit RestTriangles(const Scene& scene)
      : mesh_(scene.mesh), axes_(scene.has_warp() ? WarpDirections(scene.warp, scene.mesh) : FirstEdges(scene.mesh)) {
    axes_.colwise().normalize();
    for (int f = 0; f < mesh_.num_faces(); ++f) {
      Eigen::Matrix<double, 3, 2> edges;
      for (int k = 0; k < 2; ++k) edges.col(k) = RestCorner(mesh_, f, k + 1) - RestCorner(mesh_, f, 0);
      const Eigen::Vector3d normal = Eigen::Vector3d(edges.col(0)).cross(Eigen::Vector3d(edges.col(1))).normalized();
      Eigen::Matrix<double, 3, 2> axes;
      axes << axes_.col(f), normal.cross(axes_.col(f));
      inverses_.push_back((axes.transpose() * edges).inverse());
    }
  }

  const Eigen::Matrix3Xd& axes() const { return axes_; }

  // F of a triangle, `x` [3N].
  Eigen::Matrix<double, 3, 2> Gradient(int face, const Eigen::Ref<const Eigen::VectorXd>& x) const {
    Eigen::Matrix<double, 3, 2> edges;
    const auto corner = [&](int k) { return x.segment<3>(3 * static_cast<Eigen::Index>(mesh_.faces(k, face))); };
    for (int k = 0; k < 2; ++k) edges.col(k) = corner(k + 1) - corner(0);
    return edges * inverses_[static_cast<std::size_t>(face)];
  }

 private:
  const Mesh& mesh_;
  Eigen::Matrix3Xd axes_;  // [3 x F] unit vectors
  std::vector<Eigen::Matrix2d> inverses_;
};

Eigen::Vector3d CurvaturesOf(const BendingPatch& patch, const Eigen::Ref<const Eigen::VectorXd>& x) {
  const auto node = [&](std::size_t i) { return x.segment<3>(3 * static_cast<Eigen::Index>(patch.nodes[i])); };
  const Eigen::Vector3d normal =
      Eigen::Vector3d(node(1) - node(0)).cross(Eigen::Vector3d(node(2) - node(0))).normalized();
  Eigen::Vector3d curvatures = -patch.curvature;
  for (std::size_t i = 0; i < patch.nodes.size(); ++i) {
    curvatures += patch.weights.col(static_cast<Eigen::Index>(i)) * (node(i) - node(0)).dot(normal);
  }
  return curvatures;
}

double TakeQuantile(double share, std::vector<double>* values) {
  const auto place = values->begin() + std::lround(share * static_cast<double>(values->size() - 1));
  std::nth_element(values->begin(), place, values->end());
  return std::round(*place * kPerSeen) / kPerSeen + 0.0;  // not -0
}

// Of what `sample` gives for every triangle and as many frames as there is time for.
SeenRange RangeOf(int num_faces, const Eigen::MatrixXd& positions,
                  const std::function<double(int face, const Eigen::Ref<const Eigen::VectorXd>& x)>& sample) {
  const Eigen::Index every = num_faces * positions.cols() / kMaxSamples + 1;
  std::vector<double> values;
  for (Eigen::Index frame = 0; frame < positions.cols(); frame += every) {
    for (int f = 0; f < num_faces; ++f) {
      const double value = sample(f, positions.col(frame));
      if (std::isfinite(value)) values.push_back(value);
    }
  }
  if (values.empty()) return {};
  return {TakeQuantile(kLeastShare, &values), TakeQuantile(kMostShare, &values)};
}

}  // namespace

void SeenRange::Extend(const SeenRange& other) {
  if (!other.is_known()) return;
  from = is_known() ? std::min(from, other.from) : other.from;
  to = std::isnan(to) ? other.to : std::max(to, other.to);
}

std::map<ParameterKind, SeenRange> SeenRanges(const Scene& scene, const Eigen::MatrixXd& positions) {
  std::map<Kind, SeenRange> ranges;
  if (positions.size() == 0) return ranges;
  const int num_faces = scene.mesh.num_faces();
  const RestTriangles triangles(scene);
  for (const Kind kind : MaterialKinds()) {
    if (RowOf(kind).term != ParameterTerm::kMembrane || kind == Kind::kPoissonStiffness || !scene.has(kind)) continue;
    ranges[kind] = RangeOf(num_faces, positions,
                           [&](int face, const auto& x) { return StrainOf(kind, triangles.Gradient(face, x)); });
  }
  if (!scene.has_bending() || scene.bending.law != BendingLaw::kPatches) return ranges;
  const BendingPatches bending(scene.mesh, triangles.axes(), RestOf(scene));
  for (const Kind kind : MaterialKinds()) {
    if (RowOf(kind).term != ParameterTerm::kBending || !scene.has(kind)) continue;
    ranges[kind] = RangeOf(num_faces, positions, [&](int face, const auto& x) {
      return CurvatureOf(kind, CurvaturesOf(bending.patches()[static_cast<std::size_t>(face)], x));
    });
  }
  return ranges;
}

Eigen::VectorXd MeanStrains(const Scene& scene, const Eigen::MatrixXd& positions, ParameterKind kind) {
  const RestTriangles triangles(scene);
  const Eigen::VectorXd areas = TriangleAreas(scene.mesh);
  Eigen::VectorXd strains = Eigen::VectorXd::Zero(positions.cols());
  for (Eigen::Index frame = 0; frame < positions.cols(); ++frame) {
    for (int f = 0; f < scene.mesh.num_faces(); ++f) {
      strains[frame] += areas[f] * StrainOf(kind, triangles.Gradient(f, positions.col(frame)));
    }
  }
  return strains / areas.sum();
}

}  // namespace clothid
