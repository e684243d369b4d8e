#include "costs/assimilation/surface_pairs.h"

#include <algorithm>
#include <utility>

namespace clothid {
namespace {

// What a displacement along the cloth counts for, of one across it.
constexpr double kAlong = 0.01;

using LocalColumns = Eigen::Matrix<double, 9, Eigen::Dynamic>;

// The rows of the nodes of a pair; zero beyond them.
void Take(const SurfaceOffset& offset, const Eigen::MatrixXd& columns, LocalColumns* own) {
  for (int k = 0; k < offset.num_nodes; ++k) own->middleRows<3>(3 * k) = columns.middleRows<3>(3 * offset.nodes[k]);
}

void AddTo(const SurfaceOffset& offset, const LocalColumns& own, Eigen::MatrixXd* columns) {
  for (int k = 0; k < offset.num_nodes; ++k) columns->middleRows<3>(3 * offset.nodes[k]) += own.middleRows<3>(3 * k);
}

}  // namespace

SurfacePairs::SurfacePairs(const CloudObservation& clouds, int frame, const Eigen::Matrix3Xi* faces,
                           const Eigen::VectorXd& nodes, double weight, const InfluenceOf& influence)
    : normals_(faces, nodes) {
  std::vector<SurfaceOffset> offsets = clouds.Offsets(frame, nodes);
  if (offsets.empty()) return;
  const double num_nodes = static_cast<double>(nodes.size() / 3), num_points = static_cast<double>(offsets.size());
  weight_ = weight * std::min(1.0, num_nodes / num_points);
  for (std::size_t j = 0; j < offsets.size(); ++j) {
    Pair pair;
    pair.offset = std::move(offsets[j]);
    for (int k = 0; k < pair.offset.num_nodes; ++k) {
      pair.normal += pair.offset.weights[k] * normals_.At(pair.offset.nodes[k]);
    }
    pair.length = pair.normal.norm();
    if (!(pair.length > 0.0)) continue;  // folded onto itself: it has no sides
    pair.normal /= pair.length;
    pair.metric = kAlong * Eigen::Matrix3d::Identity() + (1.0 - kAlong) * pair.normal * pair.normal.transpose();
    const Eigen::Vector3d& e = pair.offset.offset;
    pair.counted = e;
    if (influence) {
      const double sigma = clouds.points(frame)[j].sigma, variance = sigma * sigma;
      const Influence own = influence(e.squaredNorm() / variance);
      pair.counted *= own.factor;
      pair.slope = own.factor * Eigen::Matrix3d::Identity() + (2.0 * own.slope / variance) * e * e.transpose();
    }
    pairs_.push_back(std::move(pair));
  }
}

void SurfacePairs::AddMatrix(const std::function<void(int, int, const Eigen::Matrix3d&)>& add) const {
  for (const Pair& pair : pairs_) {
    const SurfaceOffset& own = pair.offset;
    for (int i = 0; i < own.num_nodes; ++i) {
      for (int k = 0; k < own.num_nodes; ++k) {
        add(own.nodes[i], own.nodes[k], weight_ * own.weights[i] * own.weights[k] * pair.metric);
      }
    }
  }
}

void SurfacePairs::AddRight(Eigen::VectorXd* right) const {
  for (const Pair& pair : pairs_) {
    const SurfaceOffset& own = pair.offset;
    for (int k = 0; k < own.num_nodes; ++k) {
      right->segment<3>(3 * own.nodes[k]) += weight_ * own.weights[k] * (pair.metric * pair.counted);
    }
  }
}

void SurfacePairs::SetSolution(const Eigen::VectorXd& solution) {
  using NodeColumns = SurfaceOffset::NodeColumns;
  for (Pair& pair : pairs_) {
    const SurfaceOffset& own = pair.offset;
    const Eigen::Vector3d& n = pair.normal;
    Eigen::Matrix3d moves = Eigen::Matrix3d::Zero(), normals = Eigen::Matrix3d::Zero();  // u and m by columns
    for (int k = 0; k < own.num_nodes; ++k) {
      moves.col(k) = solution.segment<3>(3 * own.nodes[k]);
      normals.col(k) = normals_.At(own.nodes[k]);
    }
    const Eigen::Vector3d left = pair.counted - moves * own.weights;  // r
    // Of dN r by a change of sum_k w_k m_k.
    const Eigen::Matrix3d turns = (1.0 - kAlong) / pair.length *
                                  (n.dot(left) * Eigen::Matrix3d::Identity() + n * left.transpose()) *
                                  (Eigen::Matrix3d::Identity() - n * n.transpose());
    const Eigen::Vector3d pulled = pair.metric * left;
    const NodeColumns change = pair.metric * (pair.slope * own.offset_gradient - moves * own.weight_gradient) +
                               turns * (normals * own.weight_gradient);
    for (int k = 0; k < 3; ++k) {
      pair.by_nodes.middleRows<3>(3 * k) = weight_ * (pulled * own.weight_gradient.row(k) + own.weights[k] * change);
      for (int i = 0; i < 3; ++i) {
        pair.by_normals.block<3, 3>(3 * k, 3 * i) = (weight_ * own.weights[k] * own.weights[i]) * turns;
      }
    }
  }
}

void SurfacePairs::AddTimes(const Eigen::MatrixXd& changes, Eigen::MatrixXd* right) const {
  const Eigen::MatrixXd turned = normals_.Times(changes);
  LocalColumns nodes = LocalColumns::Zero(9, changes.cols()), normals = nodes;
  for (const Pair& pair : pairs_) {
    Take(pair.offset, changes, &nodes);
    Take(pair.offset, turned, &normals);
    AddTo(pair.offset, pair.by_nodes * nodes + pair.by_normals * normals, right);
  }
}

void SurfacePairs::AddTimesTransposed(const Eigen::MatrixXd& by_right, Eigen::MatrixXd* by_nodes) const {
  Eigen::MatrixXd by_normals = Eigen::MatrixXd::Zero(by_right.rows(), by_right.cols());
  LocalColumns own = LocalColumns::Zero(9, by_right.cols());
  for (const Pair& pair : pairs_) {
    Take(pair.offset, by_right, &own);
    AddTo(pair.offset, pair.by_nodes.transpose() * own, by_nodes);
    AddTo(pair.offset, pair.by_normals.transpose() * own, &by_normals);
  }
  normals_.AddTimesTransposed(by_normals, by_nodes);
}

}  // namespace clothid
