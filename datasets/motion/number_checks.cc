#include "datasets/motion/number_checks.h"

#include <cmath>

#include "datasets/files/safetensors.h"
#include "sim/base/error.h"

namespace clothid {
namespace {

constexpr double kWeightTolerance = 1e-6;

// Of all frames: more do not fit into a container.
constexpr long long kMaxCloudPoints = static_cast<long long>(kMaxContainerBytes / (3 * sizeof(float)));

}  // namespace

void NumberChecks::Fail(const std::string& field, const std::string& message) const {
  const std::string named = kind_ == Kind::kFile ? "tensor '" + field + "'" : field;
  throw Error(ErrorKind::kBadData, source_ + ": " + named + ": " + message);
}

void NumberChecks::FailEntry(const std::string& field, Eigen::Index index, const std::string& message) const {
  if (kind_ == Kind::kFile) Fail(field, "entry " + std::to_string(index) + " " + message);
  throw Error(ErrorKind::kBadData, source_ + ": " + field + "[" + std::to_string(index) + "] " + message);
}

void NumberChecks::ExpectSize(const std::string& field, Eigen::Index found, Eigen::Index expected) const {
  if (found == expected) return;
  Fail(field, "expected " + std::to_string(expected) + " numbers, found " + std::to_string(found));
}

void NumberChecks::ExpectIncreasing(const std::string& field, const Eigen::VectorXd& times) const {
  for (Eigen::Index i = 0; i < times.size(); ++i) {
    if (!std::isfinite(times[i])) FailEntry(field, i, "is not finite");
    if (i > 0 && !(times[i] > times[i - 1])) FailEntry(field, i, "is not above the one before it");
  }
}

void NumberChecks::ExpectPositive(const std::string& field, const Eigen::VectorXd& numbers) const {
  for (Eigen::Index i = 0; i < numbers.size(); ++i) {
    if (!std::isfinite(numbers[i]) || !(numbers[i] > 0.0)) FailEntry(field, i, "is not a number > 0");
  }
}

void NumberChecks::ExpectIndex(const std::string& field, Eigen::Index at, int index, int count) const {
  if (index >= 0 && index < count) return;
  FailEntry(field, at, "is " + std::to_string(index) + "; expected 0 to " + std::to_string(count - 1));
}

bool NumberChecks::SumsToOne(double sum) const { return std::abs(sum - 1.0) <= kWeightTolerance; }

void NumberChecks::ExpectPositions(const std::string& field, const Eigen::MatrixXd& positions, double largest) const {
  for (Eigen::Index t = 0; t < positions.cols(); ++t) {
    if ((positions.col(t).array().abs() > largest).any()) {
      Fail(field, "frame " + std::to_string(t) + " holds an infinite coordinate; expected numbers or NaN");
    }
  }
}

void NumberChecks::ExpectClouds(const std::string& field, const std::string& count_field,
                                const std::vector<Eigen::Matrix3Xd>& clouds, Eigen::Index num_times,
                                double largest) const {
  if (static_cast<Eigen::Index>(clouds.size()) != num_times) {
    Fail(count_field, "expected a cloud for each of the " + std::to_string(num_times) + " times, found " +
                          std::to_string(clouds.size()));
  }
  long long num_points = 0;
  for (std::size_t i = 0; i < clouds.size(); ++i) {
    num_points += clouds[i].cols();
    if ((clouds[i].array().abs() <= largest).all()) continue;
    Fail(field, "the cloud of frame " + std::to_string(i) + " holds a coordinate that is not finite");
  }
  if (num_points == 0) Fail(field, "expected at least one point");
  if (num_points > kMaxCloudPoints) {
    Fail(field, "expected at most " + std::to_string(kMaxCloudPoints) + " points");
  }
}

}  // namespace clothid
