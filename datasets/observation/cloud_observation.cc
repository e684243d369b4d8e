#include "datasets/observation/cloud_observation.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "sim/base/error.h"

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
        error->num_successive += 1.0;
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

bool HasSurfacePoints(const RecordedMotion& motion) {
  return std::any_of(motion.points.begin(), motion.points.end(),
                     [](const ObservedPoint& point) { return point.kind != PointKind::kMaterial; });
}

bool HasBorderPoints(const RecordedMotion& motion) {
  return std::any_of(motion.points.begin(), motion.points.end(),
                     [](const ObservedPoint& point) { return point.kind == PointKind::kBorder; });
}

ClothTopology TopologyFor(const RecordedMotion& motion) {
  const bool is_needed = !motion.clouds.empty() || HasSurfacePoints(motion);
  return ClothTopology(is_needed ? motion.scene.mesh.faces : Eigen::Matrix3Xi(), motion.scene.mesh.num_nodes());
}

}  // namespace

double CloudError::rmse() const { return std::sqrt(squared_distance / num_points); }

double CloudError::border_rmse() const { return std::sqrt(squared_border / num_border); }

double CloudError::node_rmse() const { return std::sqrt(squared_node / num_tracked); }

CloudError& CloudError::operator+=(const CloudError& other) {
  squared_distance += other.squared_distance;
  num_points += other.num_points;
  squared_border += other.squared_border;
  num_border += other.num_border;
  squared_node += other.squared_node;
  num_tracked += other.num_tracked;
  num_far += other.num_far;
  successive_products += other.successive_products;
  successive_squares += other.successive_squares;
  num_successive += other.num_successive;
  return *this;
}

CloudObservation::CloudObservation(const RecordedMotion& motion, double cloud_sigma, const Eigen::VectorXd& sigma,
                                   const std::vector<bool>& is_held)
    : cloud_sigma_(cloud_sigma), topology_(TopologyFor(motion)) {
  if (motion.clouds.empty() && !HasSurfacePoints(motion)) return;
  if (HasBorderPoints(motion) && !topology_.has_border()) {
    throw Error(ErrorKind::kBadData, motion.name + ": points are of the border, but the mesh has no border");
  }
  points_.resize(static_cast<std::size_t>(motion.num_frames()));
  row_points_.resize(points_.size());
  for (int frame = 0; frame < motion.num_frames(); ++frame) {
    if (!motion.clouds.empty()) {
      for (const auto& position : motion.clouds[frame].colwise()) AddPoint({position, cloud_sigma, false, -1}, frame);
    }
    for (int p = 0; p < motion.num_points(); ++p) {
      const PointKind kind = motion.points[p].kind;
      const Eigen::Vector3d position = motion.positions.col(frame).segment<3>(3 * p);
      if (kind == PointKind::kMaterial || is_held[p] || !position.allFinite()) continue;
      AddPoint({position, sigma[p], kind == PointKind::kBorder, p}, frame);
    }
  }
}

void CloudObservation::AddPoint(const SeenSurfacePoint& point, int frame) {
  std::vector<SeenSurfacePoint>& points = points_[static_cast<std::size_t>(frame)];
  const int index = static_cast<int>(points.size());
  points.push_back(point);
  row_points_[frame].emplace_back(index, false);
  if (point.is_border) row_points_[frame].emplace_back(index, true);
}

CloudRows CloudObservation::Linearize(int frame, const Eigen::VectorXd& nodes) const {
  CloudRows rows;
  if (num_rows(frame) == 0) return rows;
  rows.reserve(static_cast<std::size_t>(num_rows(frame)));
  const ClothSurface surface(topology_, nodes);
  for (int row = 0; row < num_rows(frame); ++row) {
    const SeenSurfacePoint& seen = point(frame, row);
    const double allowance = seen.is_border ? std::numeric_limits<double>::infinity() : kBorderAllowance * seen.sigma;
    rows.push_back(is_border_row(frame, row) ? surface.MeasureToBorder(seen.position)
                                             : surface.Measure(seen.position, allowance));
    rows.back().distance /= seen.sigma;
    rows.back().gradient /= seen.sigma;
  }
  return rows;
}

Eigen::VectorXd CloudObservation::Residuals(int frame, const Eigen::VectorXd& nodes) const {
  const CloudRows rows = Linearize(frame, nodes);
  Eigen::VectorXd residuals(num_rows(frame));
  for (Eigen::Index i = 0; i < residuals.size(); ++i) residuals[i] = rows[static_cast<std::size_t>(i)].distance;
  return residuals;
}

std::vector<SurfaceOffset> CloudObservation::Offsets(int frame, const Eigen::VectorXd& nodes) const {
  std::vector<SurfaceOffset> offsets;
  if (num_rows(frame) == 0) return offsets;
  const ClothSurface surface(topology_, nodes);
  offsets.reserve(points(frame).size());
  for (const SeenSurfacePoint& seen : points(frame)) {
    offsets.push_back(seen.is_border ? surface.OffsetToBorder(seen.position)
                                     : surface.Offset(seen.position, kBorderAllowance * seen.sigma));
  }
  return offsets;
}

Eigen::Matrix3Xd CloudObservation::ClosestPoints(int frame, const Eigen::VectorXd& nodes) const {
  Eigen::Matrix3Xd closest(3, static_cast<Eigen::Index>(points(frame).size()));
  const CloudRows rows = Linearize(frame, nodes);
  Eigen::Index column = 0;
  for (int row = 0; row < num_rows(frame); ++row) {
    if (!is_border_row(frame, row)) closest.col(column++) = rows[static_cast<std::size_t>(row)].closest;
  }
  return closest;
}

CloudError CloudObservation::Compare(const Eigen::MatrixXd& tracked, const Eigen::MatrixXd& nodes) const {
  CloudError error;
  NodeMeans means(nodes.rows() / 3);
  for (int frame = 0; frame < static_cast<int>(points_.size()); ++frame) {
    const CloudRows rows = Linearize(frame, nodes.col(frame));
    for (int i = 0; i < num_rows(frame); ++i) {
      const SurfaceDistance& row = rows[static_cast<std::size_t>(i)];
      const SeenSurfacePoint& seen = point(frame, i);
      const double distance = row.distance * seen.sigma;
      if (is_border_row(frame, i)) {
        error.squared_border += distance * distance;
        error.num_border += 1.0;
        continue;
      }
      error.squared_distance += distance * distance;
      error.num_points += 1.0;
      error.num_far += std::abs(row.distance) > kFarFromSurface;
      means.Add(row, distance);
      if (seen.tracked < 0) continue;
      error.squared_node += (tracked.col(frame).segment<3>(3 * seen.tracked) - seen.position).squaredNorm();
      error.num_tracked += 1.0;
    }
    means.EndFrame(&error);
  }
  return error;
}

}  // namespace clothid
