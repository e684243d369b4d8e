#include "datasets/checking/track_statistics.h"

#include <algorithm>
#include <limits>

#include "sim/matrix/dense.h"

namespace clothid {
namespace {

constexpr double kNormalMad = 1.4826;        // standard deviation over median absolute deviation, of a normal law
constexpr std::size_t kMaxSamples = 300000;  // third differences that are kept
constexpr double kTrim = 3.0;                // residuals above this multiple of the median do not turn the directions
constexpr int kWindow = 4;                   // frames on each side that say what is usual
constexpr double kClothJump = 4.0;           // of the usual step
constexpr double kPointJump = 6.0;           // of the usual deviation
constexpr double kShared = 0.25;             // of a deviation: less in the frame beside it, where half is expected

Eigen::VectorXd Intervals(const Eigen::VectorXd& times) {
  return times.tail(times.size() - 1) - times.head(times.size() - 1);
}

double MedianInterval(const Eigen::VectorXd& times) { return Median(Intervals(times)); }

// Of four times: the weights of their third difference, of unit sum of squares.
Eigen::Vector4d ThirdDifference(const Eigen::Vector4d& times) {
  Eigen::Vector4d weights = Eigen::Vector4d::Ones();
  const double scale = times[3] - times[0];
  for (int i = 0; i < 4; ++i) {
    for (int j = 0; j < 4; ++j) {
      if (j != i) weights[i] *= scale / (times[i] - times[j]);
    }
  }
  return weights.normalized();
}

// What is usual around index i: the median of `values` within the window, without i itself and NaN.
double Usual(const Eigen::VectorXd& values, Eigen::Index i) {
  std::vector<double> around;
  for (Eigen::Index k = std::max<Eigen::Index>(0, i - kWindow); k <= std::min(values.size() - 1, i + kWindow); ++k) {
    if (k != i) around.push_back(values[k]);
  }
  return Median(around);
}

// Row p: how far point p is off the line between the frames before and after, beside the median of the cloth [P x T];
// NaN at the ends.
Eigen::MatrixXd Deviations(const Eigen::VectorXd& times, const Eigen::MatrixXd& positions) {
  const Eigen::Index num_points = positions.rows() / 3, num_frames = positions.cols();
  Eigen::MatrixXd result = Eigen::MatrixXd::Constant(num_points, num_frames, std::numeric_limits<double>::quiet_NaN());
  for (Eigen::Index frame = 1; frame + 1 < num_frames; ++frame) {
    const double share = (times[frame] - times[frame - 1]) / (times[frame + 1] - times[frame - 1]);
    const Eigen::VectorXd line = (1.0 - share) * positions.col(frame - 1) + share * positions.col(frame + 1);
    Eigen::Matrix3Xd off = (positions.col(frame) - line).reshaped(3, num_points);
    for (int axis = 0; axis < 3; ++axis) off.row(axis).array() -= Median(off.row(axis).transpose());
    result.col(frame) = off.colwise().norm().transpose();
  }
  return result;
}

// A point that is off in frame i is off the lines of the frames beside it, too, by half as much. Where only one of the
// outer lines shows it, the frame at the end is the one that is off.
int FrameOfJump(const Eigen::VectorXd& deviations, Eigen::Index frame) {
  const Eigen::Index last = deviations.size() - 1;
  const auto is_alone = [&](Eigen::Index other) { return deviations[other] < kShared * deviations[frame]; };
  if (frame == 1 && last > 2 && is_alone(2)) return 0;
  if (frame == last - 1 && last > 2 && is_alone(last - 2)) return static_cast<int>(last);
  return static_cast<int>(frame);
}

}  // namespace

NoiseEstimate EstimateNoise(const Eigen::VectorXd& times, const Eigen::MatrixXd& positions) {
  NoiseEstimate noise;
  const Eigen::Index num_points = positions.rows() / 3, num_frames = times.size();
  if (num_frames < 4) return noise;
  const double longest = kGapFactor * MedianInterval(times);
  const auto stride = 1 + num_points * num_frames / static_cast<Eigen::Index>(kMaxSamples);
  std::vector<Eigen::Vector3d> residuals;
  std::vector<double> sizes;
  for (Eigen::Index frame = 0; frame + 3 < num_frames; ++frame) {
    const Eigen::Vector4d four = times.segment<4>(frame);
    if (Intervals(four).maxCoeff() > longest) continue;
    const Eigen::Vector4d weights = ThirdDifference(four);
    for (Eigen::Index p = frame % stride; p < num_points; p += stride) {
      const Eigen::Vector3d residual = positions.block<3, 4>(3 * p, frame) * weights;
      if (!residual.allFinite()) continue;
      residuals.push_back(residual);
      sizes.push_back(residual.norm());
    }
  }
  if (residuals.empty()) return noise;
  noise.is_known = true;
  const double limit = kTrim * Median(sizes);
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  for (const Eigen::Vector3d& residual : residuals) {
    if (residual.norm() <= limit) covariance += residual * residual.transpose();
  }
  noise.directions = SymmetricSpectrum(covariance).vectors;
  for (int k = 0; k < 3; ++k) {
    std::vector<double> along;
    for (const Eigen::Vector3d& residual : residuals) along.push_back(std::abs(noise.directions.col(k).dot(residual)));
    noise.sigma[k] = kNormalMad * Median(std::move(along));
  }
  return noise;
}

Eigen::MatrixXd LengthRatios(const std::vector<PointPair>& pairs, const Eigen::MatrixXd& positions) {
  Eigen::MatrixXd ratios(static_cast<Eigen::Index>(pairs.size()), positions.cols());
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const PointPair& pair = pairs[i];
    ratios.row(static_cast<Eigen::Index>(i)) =
        (positions.middleRows<3>(3 * pair.first) - positions.middleRows<3>(3 * pair.second)).colwise().norm() /
        pair.rest_length;
  }
  return ratios;
}

std::vector<int> ClothJumps(const Eigen::VectorXd& times, const Eigen::MatrixXd& positions, double floor) {
  std::vector<int> frames;
  const Eigen::Index num_frames = times.size(), num_points = positions.rows() / 3;
  if (num_frames < 4) return frames;
  const double usual_interval = MedianInterval(times);
  Eigen::VectorXd steps(num_frames - 1);
  for (Eigen::Index i = 0; i + 1 < num_frames; ++i) {
    const Eigen::VectorXd moved =
        (positions.col(i + 1) - positions.col(i)).reshaped(3, num_points).colwise().norm().transpose();
    steps[i] = Median(moved) * std::min(1.0, usual_interval / (times[i + 1] - times[i]));
  }
  for (Eigen::Index i = 0; i < steps.size(); ++i) {
    if (steps[i] > floor && steps[i] > kClothJump * Usual(steps, i)) frames.push_back(static_cast<int>(i) + 1);
  }
  return frames;
}

std::vector<std::pair<int, int>> PointJumps(const Eigen::VectorXd& times, const Eigen::MatrixXd& positions,
                                            double floor) {
  std::vector<std::pair<int, int>> jumps;
  const Eigen::MatrixXd deviations = Deviations(times, positions);
  for (Eigen::Index frame = 1; frame + 1 < deviations.cols(); ++frame) {
    const double of_cloth = Median(deviations.col(frame));
    for (Eigen::Index p = 0; p < deviations.rows(); ++p) {
      const double deviation = deviations(p, frame);
      if (!(deviation > floor && deviation > kPointJump * of_cloth)) continue;
      // A jump shows half its size in the frames beside it.
      if (deviation < deviations(p, frame - 1) || deviation < deviations(p, frame + 1)) continue;
      Eigen::VectorXd own = deviations.row(p).transpose();
      own.segment<3>(frame - 1).setConstant(std::numeric_limits<double>::quiet_NaN());
      const double usual = Usual(own, frame);
      if (!(deviation > kPointJump * usual)) continue;
      jumps.emplace_back(FrameOfJump(deviations.row(p).transpose(), frame), static_cast<int>(p));
    }
  }
  std::sort(jumps.begin(), jumps.end());
  return jumps;
}

}  // namespace clothid
