#include "identify/fit/sigmoid_map.h"

#include <algorithm>
#include <cmath>

namespace clothid {
namespace {

// A start at a bound has no finite u; it is moved inside by this share of the range.
constexpr double kInside = 1e-3;

}  // namespace

SigmoidMap::SigmoidMap(const std::vector<ParameterBlock>& blocks) {
  start_.resize(static_cast<Eigen::Index>(blocks.size()));
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    start_[i] = blocks[i].ToCoordinate(blocks[i].start);
    if (!blocks[i].frozen) free_.push_back(static_cast<int>(i));
  }
  lower_.resize(num_free());
  range_.resize(num_free());
  shift_.resize(num_free());
  for (int i = 0; i < num_free(); ++i) {
    const ParameterBlock& block = blocks[free_[i]];
    lower_[i] = block.ToCoordinate(block.lower_bound);
    range_[i] = block.ToCoordinate(block.upper_bound) - lower_[i];
    const double share = std::clamp((start_[free_[i]] - lower_[i]) / range_[i], kInside, 1.0 - kInside);
    shift_[i] = std::log(share / (1.0 - share));
  }
}

double SigmoidMap::Sigmoid(int i, double u) const { return 1.0 / (1.0 + std::exp(-(4.0 * u / range_[i] + shift_[i]))); }

Eigen::VectorXd SigmoidMap::ToCoordinates(const double* u) const {
  Eigen::VectorXd coordinates = start_;
  for (int i = 0; i < num_free(); ++i) coordinates[free_[i]] = lower_[i] + range_[i] * Sigmoid(i, u[i]);
  return coordinates;
}

void SigmoidMap::PullBack(const double* u, const Eigen::VectorXd& coordinate_gradient, double* gradient) const {
  for (int i = 0; i < num_free(); ++i) {
    const double s = Sigmoid(i, u[i]);
    gradient[i] = coordinate_gradient[free_[i]] * 4.0 * s * (1.0 - s);
  }
}

}  // namespace clothid
