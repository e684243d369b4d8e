#include "datasets/motion/handle_measurements.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "datasets/motion/noise_estimate.h"
#include "sim/scene/mesh.h"

namespace clothid {
namespace {

// Handles that nothing shows, relative to the cloth's size.
constexpr double kUnseenSigma = 0.05;
// A path with less noise than this share of the cloth's size counts as exact.
constexpr double kExactSigma = 1e-6;
// What is farther from the median than this many standard deviations does not count.
constexpr double kFarOff = 6.0;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

double Median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

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

HandleMeasurements MeasureStandingHandles(const MotionTensors& tensors, const std::vector<ObservedPoint>& points,
                                          const Eigen::VectorXd& sigma, Scene* scene) {
  const std::vector<int>& nodes = scene->handles.nodes;
  const Eigen::Index num_handles = static_cast<Eigen::Index>(nodes.size());
  HandleMeasurements measured;
  measured.times = tensors.times;
  measured.deviations = Eigen::MatrixXd::Constant(3 * num_handles, tensors.times.size(), kNaN);
  measured.sigma = Eigen::VectorXd::Constant(num_handles, kUnseenSigma * ClothSize(scene->mesh));
  for (Eigen::Index i = 0; i < num_handles; ++i) {
    const int point = PointOf(nodes[i], points);
    auto start = scene->initial_positions.segment<3>(3 * nodes[i]);
    const bool is_seen = point >= 0 && tensors.positions.middleRows<3>(3 * point).array().isFinite().any();
    if (!is_seen) {
      measured.deviations.block<3, 1>(3 * i, 0).setZero();
      continue;
    }
    measured.sigma[i] = sigma[point];
    for (int axis = 0; axis < 3; ++axis) {
      Eigen::RowVectorXd values = tensors.positions.row(3 * point + axis);
      const double mean = RobustMean(sigma[point], &values);
      if (!std::isnan(mean)) start[axis] = mean;
      measured.deviations.row(3 * i + axis) = values.array() - start[axis];
    }
  }
  Eigen::VectorXd places(3 * num_handles);
  for (Eigen::Index i = 0; i < num_handles; ++i) {
    places.segment<3>(3 * i) = scene->initial_positions.segment<3>(3 * nodes[i]);
  }
  scene->handles.path = HandlePath(Eigen::VectorXd::Constant(1, scene->start_time), places);
  return measured;
}

HandleMeasurements MeasurePath(const MotionTensors& tensors, const Scene& scene) {
  HandleMeasurements measured;
  measured.times = tensors.handle_times.size() > 0 ? tensors.handle_times : tensors.times;
  const double least = 1e-3 * kExactSigma * ClothSize(scene.mesh);
  measured.sigma = EstimateSigma(measured.times, tensors.handle_positions, least);
  if (measured.sigma.size() == 0) return {};  // too few times to tell
  measured.deviations = tensors.handle_positions;
  for (Eigen::Index k = 0; k < measured.times.size(); ++k) {
    measured.deviations.col(k) -= scene.handles.path.At(measured.times[k]);
  }
  return measured;
}

}  // namespace

HandleMeasurements MeasureHandles(const MotionTensors& tensors, const std::vector<ObservedPoint>& points,
                                  const Eigen::VectorXd& sigma, Scene* scene) {
  if (scene->handles.nodes.empty()) return {};
  const bool is_path_measured = !tensors.handle_index.empty();
  if (!is_path_measured && scene->handles.path.num_handles() > 0) return {};
  HandleMeasurements measured =
      is_path_measured ? MeasurePath(tensors, *scene) : MeasureStandingHandles(tensors, points, sigma, scene);
  if (measured.sigma.size() > 0 && measured.sigma.maxCoeff() < kExactSigma * ClothSize(scene->mesh)) return {};
  return measured;
}

}  // namespace clothid
