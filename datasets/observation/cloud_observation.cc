#include "datasets/observation/cloud_observation.h"

#include <cmath>
#include <limits>

namespace clothid {
namespace {

// Sums the distances near every node, frame by frame, and compares the means of one frame with those of the frame
// before in which the node had points.
class NodeMeans {
 public:
  explicit NodeMeans(Eigen::Index num_nodes)
      : sum_(num_nodes), count_(num_nodes), last_(Eigen::VectorXd::Constant(num_nodes, kNone)) {
    Clear();
  }

  void Add(const SurfaceDistance& row, double distance) {
    Eigen::Index heaviest = 0;
    row.weights.maxCoeff(&heaviest);
    sum_[row.nodes[heaviest]] += distance;
    count_[row.nodes[heaviest]] += 1.0;
  }

  void EndFrame(CloudError* error) {
    for (Eigen::Index node = 0; node < sum_.size(); ++node) {
      if (!(count_[node] > 0.0)) continue;
      const double mean = sum_[node] / count_[node], last = last_[node];
      if (!std::isnan(last)) {
        error->successive_products += last * mean;
        error->successive_squares += 0.5 * (last * last + mean * mean);
      }
      last_[node] = mean;
    }
    Clear();
  }

 private:
  static constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

  void Clear() {
    sum_.setZero();
    count_.setZero();
  }

  Eigen::VectorXd sum_, count_, last_;  // [N]
};

}  // namespace

double CloudError::rmse() const { return std::sqrt(squared_distance / num_points); }

CloudError& CloudError::operator+=(const CloudError& other) {
  squared_distance += other.squared_distance;
  num_points += other.num_points;
  num_far += other.num_far;
  successive_products += other.successive_products;
  successive_squares += other.successive_squares;
  return *this;
}

CloudObservation::CloudObservation(const RecordedMotion& motion, double sigma)
    : clouds_(motion.clouds),
      sigma_(sigma),
      topology_(motion.clouds.empty() ? Eigen::Matrix3Xi() : motion.scene.mesh.faces, motion.scene.mesh.num_nodes()) {}

CloudRows CloudObservation::Linearize(int frame, const Eigen::VectorXd& nodes) const {
  CloudRows rows(static_cast<std::size_t>(num_points(frame)));
  if (rows.empty()) return rows;
  const ClothSurface surface(topology_, nodes);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    rows[i] = surface.Measure(clouds_[frame].col(static_cast<Eigen::Index>(i)), kBorderAllowance * sigma_);
    rows[i].distance /= sigma_;
    rows[i].gradient /= sigma_;
  }
  return rows;
}

Eigen::VectorXd CloudObservation::Residuals(int frame, const Eigen::VectorXd& nodes) const {
  const CloudRows rows = Linearize(frame, nodes);
  Eigen::VectorXd residuals(num_points(frame));
  for (Eigen::Index i = 0; i < residuals.size(); ++i) residuals[i] = rows[static_cast<std::size_t>(i)].distance;
  return residuals;
}

Eigen::Matrix3Xd CloudObservation::ClosestPoints(int frame, const Eigen::VectorXd& nodes) const {
  const CloudRows rows = Linearize(frame, nodes);
  Eigen::Matrix3Xd points(3, num_points(frame));
  for (Eigen::Index i = 0; i < points.cols(); ++i) points.col(i) = rows[static_cast<std::size_t>(i)].closest;
  return points;
}

CloudError CloudObservation::Compare(const Eigen::MatrixXd& nodes) const {
  CloudError error;
  NodeMeans means(nodes.rows() / 3);
  for (int frame = 0; frame < static_cast<int>(clouds_.size()); ++frame) {
    for (const SurfaceDistance& row : Linearize(frame, nodes.col(frame))) {
      const double distance = row.distance * sigma_;
      error.squared_distance += distance * distance;
      error.num_points += 1.0;
      error.num_far += std::abs(row.distance) > kFarFromSurface;
      means.Add(row, distance);
    }
    means.EndFrame(&error);
  }
  return error;
}

}  // namespace clothid
