#include "datasets/motion/handle_measurements.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "datasets/motion/noise_estimate.h"
#include "sim/base/median.h"
#include "sim/mesh/mesh.h"

namespace clothid {
namespace {

// Handles that nothing shows, relative to the cloth's size.
constexpr double kUnseenSigma = 0.05;
// A path with less noise than this share of the cloth's size counts as exact.
constexpr double kExactSigma = 1e-6;
// What is farther from the median than this many standard deviations does not count.
constexpr double kFarOff = 6.0;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

// A coordinate over the frames; what is far off becomes NaN. The mean of the rest, NaN where nothing is left.
double RobustMean(double sigma, Eigen::RowVectorXd* values) {
  std::vector<double> seen;
  for (const double value : *values) {
    if (std::isfinite(value)) seen.push_back(value);
  }
  if (seen.empty()) return kNaN;
  const double median = Median(seen);
  double sum = 0.0;
  int count = 0;
  for (double& value : *values) {
    if (!(std::abs(value - median) <= kFarOff * sigma)) value = kNaN;
    if (std::isnan(value)) continue;
    sum += value;
    ++count;
  }
  return count > 0 ? sum / count : kNaN;
}

// The point that is the node; -1 where none is.
int PointOf(int node, const std::vector<ObservedPoint>& points) {
  for (std::size_t p = 0; p < points.size(); ++p) {
    if (points[p].num_nodes == 1 && points[p].nodes[0] == node) return static_cast<int>(p);
  }
  return -1;
}

bool IsExact(const HandleMeasurements& measured, const Scene& scene) {
  return measured.sigma.size() > 0 && measured.sigma.maxCoeff() < kExactSigma * ClothSize(scene.mesh);
}

}  // namespace

HandleMeasurements MeasureStandingHandles(const Eigen::VectorXd& sigma, RecordedMotion* motion) {
  Scene& scene = motion->scene;
  const std::vector<int>& nodes = scene.handles.nodes;
  const Eigen::Index num_handles = static_cast<Eigen::Index>(nodes.size());
  HandleMeasurements measured;
  measured.times = motion->times;
  measured.deviations = Eigen::MatrixXd::Constant(3 * num_handles, motion->times.size(), kNaN);
  measured.sigma = Eigen::VectorXd::Constant(num_handles, kUnseenSigma * ClothSize(scene.mesh));
  Eigen::VectorXd places(3 * num_handles);
  for (Eigen::Index i = 0; i < num_handles; ++i) {
    const int point = PointOf(nodes[i], motion->points);
    auto start = scene.initial_positions.segment<3>(3 * nodes[i]);
    if (point < 0 || !motion->positions.middleRows<3>(3 * point).array().isFinite().any()) {
      measured.deviations.block<3, 1>(3 * i, 0).setZero();
    } else {
      measured.sigma[i] = sigma[point];
      for (int axis = 0; axis < 3; ++axis) {
        Eigen::RowVectorXd values = motion->positions.row(3 * point + axis);
        const double mean = RobustMean(sigma[point], &values);
        if (!std::isnan(mean)) start[axis] = mean;
        measured.deviations.row(3 * i + axis) = values.array() - start[axis];
      }
    }
    places.segment<3>(3 * i) = start;
  }
  scene.handles.path = HandlePath(Eigen::VectorXd::Constant(1, scene.start_time), places);
  return IsExact(measured, scene) ? HandleMeasurements() : measured;
}

HandleMeasurements MeasureHandlePath(const Eigen::VectorXd& times, const Eigen::MatrixXd& positions,
                                     const Scene& scene) {
  HandleMeasurements measured;
  measured.times = times;
  measured.sigma = EstimateSigma(times, positions, 1e-3 * kExactSigma * ClothSize(scene.mesh));
  if (measured.sigma.size() == 0 || IsExact(measured, scene)) return {};
  measured.deviations = positions;
  for (Eigen::Index k = 0; k < times.size(); ++k) measured.deviations.col(k) -= scene.handles.path.At(times[k]);
  return measured;
}

}  // namespace clothid
