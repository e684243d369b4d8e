#include "datasets/observation/residual_derivative.h"

namespace clothid {

ResidualDerivative::ResidualDerivative(const Observation* observation, const Eigen::MatrixXd& predicted)
    : observation_(observation) {
  for (int i = 0; observation_->has_clouds() && i < observation_->num_frames(); ++i) {
    cloud_rows_.push_back(observation_->clouds().Linearize(i, observation_->Nodes(predicted).col(i)));
  }
}

Eigen::VectorXd ResidualDerivative::Apply(const Eigen::MatrixXd& change) const {
  Eigen::VectorXd result = observation_->Whiten(change);
  for (int i = 0; i < static_cast<int>(cloud_rows_.size()); ++i) {
    const auto nodes = observation_->Nodes(change).col(i);
    int row = observation_->first_cloud_row(i);
    for (const SurfaceDistance& distance : cloud_rows_[i]) {
      for (int k = 0; k < distance.num_nodes; ++k) {
        result[row] += distance.gradient.col(k).dot(nodes.segment<3>(3 * distance.nodes[k]));
      }
      ++row;
    }
  }
  return result;
}

Eigen::RowVector3d ResidualDerivative::OfShift(int row) const {
  const SeenCoordinate& seen = observation_->coordinates()[row];
  if (seen.point >= observation_->num_points()) {
    return cloud_rows_[seen.frame][seen.point - observation_->num_points()].gradient.rowwise().sum().transpose();
  }
  Eigen::RowVector3d derivative = Eigen::RowVector3d::Zero();
  derivative[seen.axis] = 1.0 / observation_->sigma(seen.point);
  return derivative;
}

void ResidualDerivative::AddFrameSeeds(int frame, double weight, const Eigen::MatrixXd& seeds,
                                       Eigen::MatrixXd* gradient) const {
  for (int r = observation_->first_row(frame); r < observation_->first_cloud_row(frame); ++r) {
    const SeenCoordinate& seen = observation_->coordinates()[r];
    const ObservedPoint& point = observation_->points()[seen.point];
    for (int k = 0; k < point.num_nodes; ++k) {
      gradient->row(3 * point.nodes[k] + seen.axis) +=
          (weight * point.weights[k] / observation_->sigma(seen.point)) * seeds.row(r);
    }
  }
  if (cloud_rows_.empty()) return;
  int row = observation_->first_cloud_row(frame);
  for (const SurfaceDistance& distance : cloud_rows_[frame]) {
    for (int k = 0; k < distance.num_nodes; ++k) {
      gradient->middleRows<3>(3 * distance.nodes[k]) += (weight * distance.gradient.col(k)) * seeds.row(row);
    }
    ++row;
  }
}

}  // namespace clothid
