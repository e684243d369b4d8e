#include "sim/shell/rest_curvature.h"

#include <Eigen/Geometry>
#include <cstddef>
#include <utility>

#include "sim/matrix/dense.h"

namespace clothid {
namespace {

constexpr double kFlat = 1e-5;  // distance from a plane, relative to the cloth's size

// A triangle where it is now.
struct CurrentTriangle {
  Eigen::Vector3d normal;     // n
  Eigen::Matrix3d gradients;  // columns g_k, 1/m
  Eigen::Vector3d moment;     // p

  CurrentTriangle(const RestMoment& of, const Eigen::VectorXd& positions, const Eigen::VectorXd& slopes)
      : moment(Eigen::Vector3d::Zero()) {
    const auto corner = [&](int k) { return positions.segment<3>(3 * of.nodes[static_cast<std::size_t>(k % 3)]); };
    const Eigen::Vector3d twice_area = (corner(1) - corner(0)).cross(corner(2) - corner(0));
    normal = twice_area.normalized();
    for (int k = 0; k < 3; ++k) {
      gradients.col(k) = normal.cross(corner(k + 2) - corner(k + 1)) / twice_area.norm();
    }
    for (std::size_t i = 0; i < of.nodes.size(); ++i) {
      moment += of.weights[static_cast<Eigen::Index>(i)] * positions.segment<3>(3 * of.nodes[i]);
    }
    for (std::size_t i = 0; i < of.slopes.size() && slopes.size() > 0; ++i) {
      moment += of.slope_weights[static_cast<Eigen::Index>(i)] * slopes.segment<3>(3 * of.slopes[i]);
    }
  }
};

// Of corners k and l, the part that is theirs as corners.
Eigen::Matrix3d CornerBlock(const CurrentTriangle& now, double square, HessianKind kind, int k, int l) {
  const Eigen::Vector3d& n = now.normal;
  const auto g_k = now.gradients.col(k), g_l = now.gradients.col(l);
  if (kind == HessianKind::kClamped) return square * g_k.dot(g_l) * n * n.transpose();
  return now.moment.dot(n) * g_k.dot(g_l) * n * n.transpose() - now.moment.dot(g_l) * n * g_k.transpose() -
         now.moment.dot(g_k) * g_l * n.transpose();
}

// d2E of node i of the patch and corner k.
Eigen::Matrix3d BlockOf(const RestMoment& of, const CurrentTriangle& now, HessianKind kind, int i, int k) {
  Eigen::Matrix3d block = of.weights[i] * now.gradients.col(k) * now.normal.transpose();
  if (i >= 3) return block;
  block += of.weights[k] * now.normal * now.gradients.col(i).transpose();
  return block + CornerBlock(now, of.square, kind, i, k);
}

}  // namespace

double AddMomentForce(const RestMoment& moment, double factor, const Eigen::VectorXd& positions,
                      const Eigen::VectorXd& slopes, Eigen::VectorXd* force) {
  const CurrentTriangle now(moment, positions, slopes);
  for (std::size_t i = 0; i < moment.nodes.size(); ++i) {
    const auto index = static_cast<Eigen::Index>(i);
    double along = moment.weights[index];
    if (i < 3) along -= now.moment.dot(now.gradients.col(index));
    force->segment<3>(3 * moment.nodes[i]) += factor * along * now.normal;
  }
  return 0.5 * moment.square - now.moment.dot(now.normal);
}

void AddMomentSlopeForce(const RestMoment& moment, double factor, const Eigen::VectorXd& positions,
                         Eigen::VectorXd* force) {
  if (moment.slopes.empty()) return;
  const CurrentTriangle now(moment, positions, Eigen::VectorXd());
  for (std::size_t i = 0; i < moment.slopes.size(); ++i) {
    force->segment<3>(3 * moment.slopes[i]) += factor * moment.slope_weights[static_cast<Eigen::Index>(i)] * now.normal;
  }
}

bool IsFlat(const Mesh& mesh) {
  const Eigen::Vector3d mean = mesh.rest_positions.rowwise().mean();
  const Eigen::Matrix3Xd from_mean = mesh.rest_positions.colwise() - mean;
  const Eigen::Vector3d normal = SymmetricSpectrum(Eigen::Matrix3d(from_mean * from_mean.transpose())).vectors.col(0);
  return (normal.transpose() * from_mean).cwiseAbs().maxCoeff() <= kFlat * ClothSize(mesh);
}

// A block above the diagonal is the transpose of the one below it. Of two corners one order is enough.
RestCurvature::RestCurvature(std::vector<RestMoment> moments, const std::vector<int>& free_index,
                             const BlockPattern& pattern)
    : moments_(std::move(moments)) {
  for (const RestMoment& moment : moments_) {
    std::vector<std::array<Place, 3>>& places = places_.emplace_back(moment.nodes.size());
    for (std::size_t i = 0; i < moment.nodes.size(); ++i) {
      for (std::size_t k = 0; k < 3; ++k) {
        const int node = free_index[moment.nodes[i]], corner = free_index[moment.nodes[k]];
        if (i == k || (i < 3 && i < k) || (node < 0 && corner < 0)) continue;
        const bool transposed = node >= 0 && (corner < 0 || node < corner);
        const int row = transposed ? corner : node, column = transposed ? node : corner;
        places[i][k] = {pattern.Find(row < 0 ? column : row, column), transposed};
      }
    }
  }
}

double RestCurvature::AddForce(double stiffness, const Eigen::VectorXd& positions, const Eigen::VectorXd& slopes,
                               Eigen::VectorXd* force) const {
  double energy = 0.0;
  for (const RestMoment& moment : moments_) energy += AddMomentForce(moment, stiffness, positions, slopes, force);
  return energy;
}

void RestCurvature::AddHessian(double stiffness, HessianKind kind, const Eigen::VectorXd& positions,
                               const Eigen::VectorXd& slopes, BlockMatrix* hessian) const {
  for (std::size_t m = 0; m < moments_.size(); ++m) {
    const CurrentTriangle now(moments_[m], positions, slopes);
    for (std::size_t i = 0; i < places_[m].size(); ++i) {
      for (std::size_t k = 0; k < 3; ++k) {
        const Place& place = places_[m][i][k];
        if (!place.position.valid()) continue;
        const Eigen::Matrix3d block =
            stiffness * BlockOf(moments_[m], now, kind, static_cast<int>(i), static_cast<int>(k));
        if (place.transposed) {
          hessian->block(place.position) += block.transpose();
        } else {
          hessian->block(place.position) += block;
        }
      }
    }
  }
}

}  // namespace clothid
