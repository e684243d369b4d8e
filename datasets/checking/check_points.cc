#include "datasets/checking/check_points.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <set>

#include "datasets/checking/finding_words.h"
#include "datasets/checking/grid_orders.h"

namespace clothid {
namespace {

constexpr double kQuiet = 1e-3;       // noise over the size of the cloth that counts as none
constexpr double kSigmaFactor = 3.0;  // between the noise that the file states and the one estimated
constexpr double kWrongSigma = 30.0;  // likewise: another unit
constexpr double kCoarse = 0.3;       // noise over spacing from which neighbours cannot be told apart
constexpr double kLongEdge = 1.6;     // a pair over its own median length and that of its frame: torn apart
constexpr double kTornShare = 0.04;   // of the pairs: from here a frame counts as out of order
constexpr double kStrayShare = 0.15;  // of the points: so many may be far off in a frame without its order being wrong
constexpr double kOwnShare = 0.5;     // of a point's deviation: less is what the points around it do
constexpr double kLeastClothJump = 0.1;  // of the spacing: less is no jump of the cloth

// The pairs of a frame, of which some are long, and points that are left out together with their pairs.
class TornPairs {
 public:
  TornPairs(const std::vector<PointPair>& pairs, const std::vector<bool>& is_long, int num_points)
      : pairs_(pairs), is_long_(is_long), is_left_(pairs.size(), true) {
    pairs_of_.resize(static_cast<std::size_t>(num_points));
    num_left_.resize(pairs_of_.size());
    num_long_.resize(pairs_of_.size());
    for (std::size_t i = 0; i < pairs.size(); ++i) {
      for (const int point : {pairs[i].first, pairs[i].second}) {
        pairs_of_[point].push_back(i);
        ++num_left_[point];
        num_long_[point] += is_long[i];
      }
    }
  }

  int num_left() const { return std::accumulate(num_left_.begin(), num_left_.end(), 0) / 2; }
  int num_long() const { return std::accumulate(num_long_.begin(), num_long_.end(), 0) / 2; }
  double LongShare(int point) const { return static_cast<double>(num_long_[point]) / std::max(1, num_left_[point]); }
  // The point with the largest share of long pairs.
  int Worst() const {
    int worst = 0;
    for (int point = 1; point < static_cast<int>(pairs_of_.size()); ++point) {
      if (LongShare(point) > LongShare(worst)) worst = point;
    }
    return worst;
  }
  void LeaveOut(int stray) {
    for (const std::size_t i : pairs_of_[stray]) {
      if (!is_left_[i]) continue;
      is_left_[i] = false;
      for (const int point : {pairs_[i].first, pairs_[i].second}) {
        --num_left_[point];
        num_long_[point] -= is_long_[i];
      }
    }
  }

 private:
  const std::vector<PointPair>& pairs_;
  const std::vector<bool>& is_long_;
  std::vector<bool> is_left_;
  std::vector<std::vector<std::size_t>> pairs_of_;  // by point
  std::vector<int> num_left_, num_long_;            // by point
};

// Whether many pairs of a frame are torn. A few points that strayed from all around them are no matter of order: the
// worst is left out, and so on until none has lost half of its neighbours.
bool IsTorn(const std::vector<PointPair>& pairs, const std::vector<bool>& is_long, int num_points) {
  TornPairs torn(pairs, is_long, num_points);
  for (int k = 0; k < std::max(1.0, kStrayShare * num_points); ++k) {
    const int worst = torn.Worst();
    if (torn.LongShare(worst) < 0.5) break;
    torn.LeaveOut(worst);
  }
  return torn.num_long() > std::max(2.0, kTornShare * torn.num_left());
}

// Frames in which many pairs are much longer than they and their frame are otherwise.
std::vector<int> TornFrames(const CheckedMotion& checked) {
  std::vector<int> frames;
  if (checked.pairs.empty() || checked.motion.num_frames() < 3) return frames;
  Eigen::MatrixXd ratios = LengthRatios(checked.pairs, checked.motion.positions);
  for (Eigen::Index i = 0; i < ratios.rows(); ++i) ratios.row(i) /= Median(ratios.row(i).transpose());
  for (Eigen::Index frame = 0; frame < ratios.cols(); ++frame) {
    const double usual = std::max(1.0, Median(ratios.col(frame)));
    std::vector<bool> is_long;
    for (const double ratio : ratios.col(frame)) is_long.push_back(ratio > kLongEdge * usual);
    if (IsTorn(checked.pairs, is_long, checked.motion.num_points())) frames.push_back(static_cast<int>(frame));
  }
  return frames;
}

Finding JumpsOfCloth(const CheckedMotion& checked, const Eigen::MatrixXd& positions) {
  Finding finding;
  finding.what = "jumps of the cloth";
  // The noise of a median over the points.
  const double noise = checked.noise_floor / std::sqrt(static_cast<double>(checked.motion.num_points()));
  // Nor is what gravity may do to a cloth within an interval, unless handles pull it farther.
  const Scene& scene = checked.motion.scene;
  const double fall =
      scene.handles.path.num_handles() > 0 ? 0.0 : scene.gravity.norm() * std::pow(checked.median_interval, 2);
  finding.frames = ClothJumps(checked.motion.times, positions, kLeastClothJump * checked.spacing + noise + fall);
  finding.value = finding.frames.empty() ? "none" : "into " + Named("frame", finding.frames);
  if (!finding.frames.empty()) {
    finding.severity = Severity::kWarning;
    finding.hint =
        "points as a whole go farther than in the frames around: a grid that was placed anew, frames out of "
        "order, or very fast motion; a robust loss bounds what they do";
  }
  return finding;
}

// Off the line between the frames before and after [3]; NaN where one of the three is not seen.
Eigen::Vector3d Deviation(const Eigen::VectorXd& times, const Eigen::MatrixXd& positions, int frame, int point) {
  const Eigen::Index middle = std::clamp<Eigen::Index>(frame, 1, positions.cols() - 2);
  const double share = (times[middle] - times[middle - 1]) / (times[middle + 1] - times[middle - 1]);
  const auto at = [&](Eigen::Index column) -> Eigen::Vector3d { return positions.block<3, 1>(3 * point, column); };
  return at(middle) - (1.0 - share) * at(middle - 1) - share * at(middle + 1);
}

// Whether the points around one leave their paths as it does: then the cloth does, as where it hits something.
bool MovesWithNeighbours(const CheckedMotion& checked, const Eigen::MatrixXd& positions, int frame, int point) {
  std::array<std::vector<double>, 3> around;
  for (const PointPair& pair : checked.pairs) {
    if (pair.first != point && pair.second != point) continue;
    const Eigen::Vector3d deviation =
        Deviation(checked.motion.times, positions, frame, pair.first == point ? pair.second : pair.first);
    for (int k = 0; k < 3 && deviation.allFinite(); ++k) around[k].push_back(deviation[k]);
  }
  if (around[0].empty()) return false;
  Eigen::Vector3d usual;
  for (int k = 0; k < 3; ++k) {
    usual[k] = Median(Eigen::Map<Eigen::VectorXd>(around[k].data(), static_cast<Eigen::Index>(around[k].size())));
  }
  const Eigen::Vector3d own = Deviation(checked.motion.times, positions, frame, point);
  return (own - usual).norm() < kOwnShare * own.norm();
}

// In how many successive frames, one of which is beside `frame`, a point is far from most of its neighbours; at
// least 1.
int FramesAway(const CheckedMotion& checked, const Eigen::MatrixXd& positions, int frame, int point) {
  std::vector<PointPair> pairs;
  for (const PointPair& pair : checked.pairs) {
    if (pair.first == point || pair.second == point) pairs.push_back(pair);
  }
  Eigen::MatrixXd ratios = LengthRatios(pairs, positions);
  for (Eigen::Index i = 0; i < ratios.rows(); ++i) ratios.row(i) /= Median(ratios.row(i).transpose());
  const int num_frames = static_cast<int>(ratios.cols());
  const auto is_away = [&](int at) {
    const auto num_seen = ratios.rows() - ratios.col(at).array().isNaN().count();
    return 2 * (ratios.col(at).array() > kLongEdge).count() > num_seen;
  };
  int longest = 1;
  for (int first = std::max(0, frame - 1); first <= std::min(frame + 1, num_frames - 1); ++first) {
    if (!is_away(first)) continue;
    int begin = first, end = first;
    while (begin > 0 && is_away(begin - 1)) --begin;
    while (end < num_frames && is_away(end)) ++end;
    longest = std::max(longest, end - begin);
  }
  return longest;
}

Finding JumpsOfPoints(const CheckedMotion& checked, Eigen::MatrixXd positions, const std::vector<int>& cloth_jumps) {
  Finding finding;
  finding.what = "jumps of points";
  for (const int frame : cloth_jumps) positions.col(frame).setConstant(std::numeric_limits<double>::quiet_NaN());
  std::set<int> frames, points;
  std::string first;
  int count = 0, longest = 1;
  for (const auto& [frame, point] : PointJumps(checked.motion.times, positions, checked.point_jump_floor())) {
    if (MovesWithNeighbours(checked, positions, frame, point)) continue;
    frames.insert(frame);
    points.insert(point);
    longest = std::max(longest, FramesAway(checked, positions, frame, point));
    if (++count <= 3) first += (first.empty() ? "" : ", ") + std::to_string(point) + " in " + std::to_string(frame);
  }
  finding.frames.assign(frames.begin(), frames.end());
  finding.points.assign(points.begin(), points.end());
  finding.value = count == 0 ? "none" : std::to_string(count) + ", point " + first + (count > 3 ? ", .." : "");
  if (count > 0) {
    finding.severity = Severity::kWarning;
    finding.hint =
        "they leave their path for one frame and return, as points do that were taken for others; remove "
        "them, or fit with a robust loss";
  }
  if (longest > 1) {
    finding.value += "; away from their neighbours for up to " + std::to_string(longest) + " frames (" +
                     Rounded(longest * checked.median_interval) + " s)";
    finding.hint =
        "they leave their path, as points do that were taken for others; remove them, or fit with a robust loss";
  }
  return finding;
}

}  // namespace

Finding CheckNoise(const CheckedMotion& checked) {
  Finding finding;
  finding.what = "noise";
  const NoiseEstimate& noise = checked.noise;
  if (!noise.is_known) {
    finding.value = "not known: less than four frames in succession";
    return finding;
  }
  const Eigen::VectorXd& sigma = checked.motion.sigma;
  const double stated = sigma.size() > 0 ? Median(sigma) : 0.0;
  finding.value = "at most " + Rounded(1e3 * noise.sigma[0]) + ", " + Rounded(1e3 * noise.sigma[1]) + ", " +
                  Millimetres(noise.sigma[2]) + " along its principal directions";
  finding.value += stated > 0.0 ? "; the file says " + Millimetres(stated) : "; the file says nothing";
  const bool quiet = noise.rms() < kQuiet * checked.cloth_size;
  if (stated == 0.0 && !quiet) {
    finding.severity = Severity::kNote;
    finding.hint = "motion convert --sigma gives the points a standard deviation, which robust losses need";
  } else if (stated > 0.0 && noise.rms() > kSigmaFactor * stated && !quiet) {
    finding.severity = Severity::kNote;
    finding.hint = "more than the file says: points jump, or move faster than the frame rate shows";
  } else if (stated > kSigmaFactor * noise.rms()) {
    finding.severity = Severity::kNote;
    finding.hint = "less than the file says: intervals will be wider than they need to be";
  }
  // A simulation that was given the noise of another sensor has none at all.
  if (stated > kWrongSigma * noise.rms() && stated > kCoarse * checked.spacing) {
    finding.severity = Severity::kWarning;
    finding.hint = "far less than the file says: --sigma and the tensor `sigma` are in m";
  }
  if (noise.rms() > kCoarse * checked.spacing) {
    finding.severity = Severity::kWarning;
    finding.hint =
        "neighbouring points are hardly farther apart than the noise; fewer points or a coarser mesh lose "
        "nothing";
  }
  return finding;
}

Finding CheckOrder(const CheckedMotion& checked) {
  Finding finding;
  finding.what = "order of points";
  finding.value = "the same in every frame";
  std::set<int> frames;
  std::string how;
  if (checked.rest_points.cols() <= kMaxOrderPoints) {
    const std::vector<std::vector<int>> orders = GridOrders(checked.rest_points);
    const std::vector<int> flipped = FlippedFrames(checked.motion.positions, orders, checked.spacing);
    if (!flipped.empty()) how = "turned or mirrored in " + Named("frame", flipped);
    frames.insert(flipped.begin(), flipped.end());
  }
  std::vector<int> torn;
  for (const int frame : TornFrames(checked)) {
    if (frames.insert(frame).second) torn.push_back(frame);
  }
  if (!torn.empty()) how += (how.empty() ? "" : "; ") + ("neighbours torn apart in " + Named("frame", torn));
  finding.frames.assign(frames.begin(), frames.end());
  if (frames.empty()) return finding;
  finding.value = how;
  finding.severity = Severity::kWarning;
  finding.hint = "points are taken for others there: put them in order, or leave these frames out";
  return finding;
}

std::vector<Finding> CheckJumps(const CheckedMotion& checked, const std::vector<int>& left_out) {
  Eigen::MatrixXd positions = checked.motion.positions;
  for (const int frame : left_out) positions.col(frame).setConstant(std::numeric_limits<double>::quiet_NaN());
  const Finding of_cloth = JumpsOfCloth(checked, positions);
  return {of_cloth, JumpsOfPoints(checked, positions, of_cloth.frames)};
}

}  // namespace clothid
