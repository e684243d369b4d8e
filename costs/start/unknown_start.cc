#include "costs/start/unknown_start.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "costs/start/smooth_modes.h"
#include "costs/start/start_prior.h"
#include "sim/matrix/dense.h"

namespace clothid {
namespace {

// Knots of the offsets of a path that moves: one in so many measurements, no more than these. What the unknowns that
// may be had in all leave to each knot is how many handles, or patterns of them, are told apart. (With 2 knots in 3.2 s
// for each of 15 handles, noise of 1 mm at 30 Hz biases k_stretch by 1.9 of its deviations, with 16 by 0.4.)
constexpr Eigen::Index kMeasurementsPerKnot = 6;
constexpr Eigen::Index kMostKnots = 16;
constexpr Eigen::Index kMostOffsets = 192;
// Eigenvalues of P below this share of the largest are the rounding of zero: nothing is believed in that direction.
constexpr double kRounding = 1e-13;

Eigen::VectorXd OffsetKnots(const RecordedMotion& motion) {
  const HandleMeasurements& measured = motion.handle_measurements;
  if (measured.is_empty()) return {};
  const Eigen::Index num_times = measured.times.size();
  const bool stands_still = motion.scene.handles.path.times().size() == 1;
  const Eigen::Index count =
      stands_still ? 1 : std::clamp<Eigen::Index>(num_times / kMeasurementsPerKnot, 1, kMostKnots);
  return Eigen::VectorXd::LinSpaced(count, measured.times[0], measured.times[num_times - 1]);
}

// How many patterns of the handles have an offset of their own at every knot.
Eigen::Index NumPatterns(Eigen::Index num_handles, Eigen::Index num_knots) {
  if (num_knots == 0) return 0;
  return std::clamp<Eigen::Index>(kMostOffsets / (3 * num_knots), 1, num_handles);
}

// A quadratic form as 1/2 |rows (s - mean)|^2.
struct PriorRoot {
  Eigen::MatrixXd rows;
  Eigen::VectorXd mean;
};

PriorRoot RootOf(const Eigen::MatrixXd& precision, const Eigen::VectorXd& information) {
  const Spectrum spectrum = SymmetricSpectrum(precision);
  const Eigen::VectorXd& values = spectrum.values;
  const Eigen::Index rank = (values.array() > kRounding * values[values.size() - 1]).count();
  const Eigen::MatrixXd vectors = spectrum.vectors.rightCols(rank);
  return {values.tail(rank).cwiseSqrt().asDiagonal() * vectors.transpose(),
          vectors * values.tail(rank).cwiseInverse().asDiagonal() * (vectors.transpose() * information)};
}

HandlePath Offsets(const Eigen::VectorXd& times, const Eigen::VectorXd& values) {
  return HandlePath(times, values.reshaped(values.size() / times.size(), times.size()));
}

}  // namespace

UnknownStart::UnknownStart(const RecordedMotion& motion)
    : base_positions_(motion.scene.initial_positions),
      base_velocities_(motion.scene.initial_velocities),
      knot_times_(OffsetKnots(motion)) {
  if (!IsUnknown(motion.start_source)) throw std::logic_error("the start of this recording is known");
  const ShapePrior shape(motion.scene);
  const bool is_moving = motion.start_source == StartSource::kMoving;
  const Eigen::MatrixXd modes = SmoothModes(shape.model(), motion.scene.handles.nodes, kPositionModes);
  const Eigen::MatrixXd along = AlongAxes(modes);
  num_positions_ = static_cast<int>(along.cols());
  const auto num_handles = static_cast<Eigen::Index>(motion.scene.handles.nodes.size());
  num_offsets_ = static_cast<int>(3 * NumPatterns(num_handles, knot_times_.size()) * knot_times_.size());
  const Eigen::Index num_moved = num_positions_ + num_offsets_;
  const Eigen::Index num_velocities = is_moving ? 3 * std::min<Eigen::Index>(kVelocityModes, modes.cols()) : 0;
  const Eigen::Index size = num_moved + num_velocities, num_rows = along.rows();

  directions_.initial_positions = Eigen::MatrixXd::Zero(num_rows, size);
  directions_.initial_positions.leftCols(num_positions_) = along;
  QuadraticPrior prior{Eigen::MatrixXd::Zero(size, size), Eigen::VectorXd::Zero(size)};
  if (num_offsets_ > 0) AddHandles(motion, shape, &prior);
  shape.AddPositions(base_positions_, directions_.initial_positions.leftCols(num_moved), 0, &prior);
  if (is_moving) {
    directions_.initial_velocities = Eigen::MatrixXd::Zero(num_rows, size);
    directions_.initial_velocities.rightCols(num_velocities) = along.leftCols(num_velocities);
    shape.AddVelocities(base_positions_, base_velocities_, along.leftCols(num_velocities), num_moved, &prior);
  }

  SetPrior(prior);
}

void UnknownStart::AddHandles(const RecordedMotion& motion, const ShapePrior& shape, QuadraticPrior* prior) {
  const HandleCoupling coupling = shape.CoupleHandles(motion);
  const Eigen::Index num_knots = knot_times_.size(), num_coordinates = 3 * coupling.stiffness.rows();
  const Eigen::MatrixXd patterns = coupling.SmoothestOffsets(num_offsets_ / (3 * num_knots));
  const Eigen::MatrixXd offsets = AlongAxes(patterns), response = AlongAxes(coupling.response * patterns);
  const HandlePath unit = Offsets(knot_times_, Eigen::VectorXd::Zero(num_coordinates * num_knots));
  const Eigen::VectorXd at_start = unit.KnotWeights(motion.scene.start_time);
  Eigen::MatrixXd along = Eigen::MatrixXd::Zero(num_coordinates * num_knots, num_offsets_);
  for (Eigen::Index k = 0; k < num_knots; ++k) {
    directions_.initial_positions.middleCols(num_positions_ + k * response.cols(), response.cols()) =
        at_start[k] * response;
    along.block(k * num_coordinates, k * offsets.cols(), num_coordinates, offsets.cols()) = offsets;
  }
  directions_.handle_offsets = Eigen::MatrixXd::Zero(along.rows(), directions_.initial_positions.cols());
  directions_.handle_offsets.middleCols(num_positions_, num_offsets_) = along;
  const HandleMeasurements& measured = motion.handle_measurements;
  Eigen::MatrixXd weights(measured.times.size(), num_knots);
  for (Eigen::Index k = 0; k < weights.rows(); ++k) weights.row(k) = unit.KnotWeights(measured.times[k]).transpose();
  AddHandleMeasurements(measured, weights, along, num_positions_, prior);
  const PriorRoot root = RootOf(prior->precision.block(num_positions_, num_positions_, num_offsets_, num_offsets_),
                                prior->information.segment(num_positions_, num_offsets_));
  handle_root_ = root.rows;
  handle_mean_ = root.mean;
}

void UnknownStart::SetPrior(const QuadraticPrior& prior) {
  const PriorRoot root = RootOf(prior.precision, prior.information);
  root_ = root.rows;
  mean_ = root.mean;
}

Eigen::VectorXd UnknownStart::PositionsAt(const Eigen::VectorXd& unknowns) const {
  return base_positions_ + directions_.initial_positions * unknowns;
}

Eigen::VectorXd UnknownStart::VelocitiesAt(const Eigen::VectorXd& unknowns) const {
  if (directions_.initial_velocities.cols() == 0) return base_velocities_;
  return base_velocities_ + directions_.initial_velocities * unknowns;
}

std::optional<HandlePath> UnknownStart::HandleOffsetsAt(const Eigen::VectorXd& unknowns) const {
  if (num_offsets_ == 0) return std::nullopt;
  return Offsets(knot_times_, directions_.handle_offsets * unknowns);
}

SensitivityDirections UnknownStart::DirectionsAlong(const Eigen::MatrixXd& combinations) const {
  SensitivityDirections along;
  along.initial_positions = directions_.initial_positions * combinations;
  if (directions_.initial_velocities.cols() > 0) {
    along.initial_velocities = directions_.initial_velocities * combinations;
  }
  if (num_offsets_ > 0) along.handle_offsets = directions_.handle_offsets * combinations;
  return along;
}

// The rows of the handles in `initial_positions` are zero: what their start does stands in `handle_offsets`.
Eigen::MatrixXd UnknownStart::PullBack(const RolloutGradient& gradient) const {
  Eigen::MatrixXd sum = directions_.initial_positions.transpose() * gradient.initial_positions;
  if (directions_.initial_velocities.cols() > 0) {
    sum += directions_.initial_velocities.transpose() * gradient.initial_velocities;
  }
  if (num_offsets_ > 0) sum += directions_.handle_offsets.transpose() * gradient.handle_offsets;
  return sum;
}

double UnknownStart::HandleError(const Eigen::VectorXd& unknowns) const {
  if (num_offsets_ == 0) return 0.0;
  const Eigen::VectorXd residuals = handle_root_ * (unknowns.segment(num_positions_, num_offsets_) - handle_mean_);
  return std::sqrt(residuals.squaredNorm() / static_cast<double>(residuals.size()));
}

double UnknownStart::PriorAt(const Eigen::VectorXd& unknowns) const {
  return 0.5 * PriorResiduals(unknowns).squaredNorm();
}

}  // namespace clothid
