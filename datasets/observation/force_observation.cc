#include "datasets/observation/force_observation.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace clothid {
namespace {

int NearestFrame(const Eigen::VectorXd& times, double time) {
  const auto after = static_cast<int>(std::lower_bound(times.begin(), times.end(), time) - times.begin());
  if (after == 0) return 0;
  if (after == times.size()) return after - 1;
  return times[after] - time < time - times[after - 1] ? after : after - 1;
}

}  // namespace

double ForceError::rms() const { return std::sqrt(squared_error / num_components); }

double ForceError::autocorrelation() const {
  if (!(successive_squares > 0.0)) return std::numeric_limits<double>::quiet_NaN();
  return successive_products / successive_squares;
}

ForceError& ForceError::operator+=(const ForceError& other) {
  successive_products += other.successive_products;
  successive_squares += other.successive_squares;
  squared_error += other.squared_error;
  num_components += other.num_components;
  return *this;
}

ForceObservation::ForceObservation(const RecordedMotion& motion) {
  const ForceReadings& forces = motion.forces;
  if (forces.is_empty()) return;
  groups_ = forces.groups;
  if (groups_.empty()) groups_ = {motion.scene.handles.nodes};
  sigma_ = forces.sigma;
  stencils_ = LinearStencils(forces.times, motion.scene);
  std::vector<double> measured;
  for (int i = 0; i < num_readings(); ++i) {
    nearest_frame_.push_back(NearestFrame(motion.times, forces.times[i]));
    first_row_.push_back(num_residuals());
    for (int row = 0; row < 3 * num_groups(); ++row) {
      if (!std::isfinite(forces.values(row, i))) continue;
      seen_.push_back({i, row});
      measured.push_back(forces.values(row, i) / sigma_[row / 3]);
    }
  }
  first_row_.push_back(num_residuals());
  measured_ = Eigen::Map<const Eigen::VectorXd>(measured.data(), static_cast<Eigen::Index>(measured.size()));
}

Eigen::VectorXd ForceObservation::Whiten(const Eigen::MatrixXd& forces) const {
  Eigen::VectorXd whitened(num_residuals());
  for (int r = 0; r < num_residuals(); ++r) {
    whitened[r] = forces(seen_[r].row, seen_[r].reading) / sigma_[seen_[r].row / 3];
  }
  return whitened;
}

Eigen::VectorXd ForceObservation::Residuals(const Eigen::MatrixXd& forces) const { return Whiten(forces) - measured_; }

ForceError ForceObservation::Compare(const Eigen::MatrixXd& forces) const {
  ForceError error;
  Eigen::VectorXd last = Eigen::VectorXd::Constant(forces.rows(), std::numeric_limits<double>::quiet_NaN());
  for (int r = 0; r < num_residuals(); ++r) {
    const int row = seen_[r].row;
    const double difference = forces(row, seen_[r].reading) - measured_[r] * sigma_[row / 3];
    error.squared_error += difference * difference;
    if (!std::isnan(last[row])) {
      error.successive_products += last[row] * difference;
      error.successive_squares += 0.5 * (last[row] * last[row] + difference * difference);
    }
    last[row] = difference;
  }
  error.num_components = num_residuals();
  return error;
}

void ForceObservation::LinearizeReading(int reading, const Eigen::MatrixXd& forces, Eigen::VectorXd* residuals,
                                        Eigen::MatrixXd* jacobian) const {
  const int first = first_row(reading), count = first_row(reading + 1) - first;
  residuals->resize(count);
  jacobian->resize(count, forces.cols() - 1);
  for (int r = 0; r < count; ++r) {
    const int row = seen_[first + r].row;
    (*residuals)[r] = forces(row, 0) / sigma_[row / 3] - measured_[first + r];
    jacobian->row(r) = forces.row(row).tail(jacobian->cols()) / sigma_[row / 3];
  }
}

Eigen::MatrixXd ForceObservation::PullBack(int reading, const Eigen::Ref<const Eigen::MatrixXd>& seeds) const {
  Eigen::MatrixXd pulled = Eigen::MatrixXd::Zero(3 * num_groups(), seeds.cols());
  for (int r = first_row(reading); r < first_row(reading + 1); ++r) {
    pulled.row(seen_[r].row) += seeds.row(r) / sigma_[seen_[r].row / 3];
  }
  return pulled;
}

}  // namespace clothid
