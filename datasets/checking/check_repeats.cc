#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>
#include <string>
#include <unordered_map>
#include <utility>

#include "datasets/checking/check_clouds.h"
#include "datasets/checking/check_coverage.h"
#include "datasets/checking/finding_words.h"
#include "sim/base/text_file.h"

namespace clothid {
namespace {

constexpr int kFewestRepeats = 3;       // of a place, that are no chance
constexpr int kSeveralPoints = 3;       // that are not taken for the one that is in this place
constexpr double kFarOff = 2.0;         // a pair over what is usual: its points are not where the cloth is
constexpr double kUsualLength = 0.3;    // of the pairs are shorter, where many are torn, too
constexpr double kLeap = 1.0;           // of the spacing: no point comes to rest, or starts, that abruptly
constexpr double kLoneLeap = 0.3;       // of the cloth's size: likewise, where no neighbour is seen
constexpr std::size_t kMostNamed = 3;   // places
constexpr double kCopies = 4.0;         // of the usual number of points in one place: rounding makes copies, too
constexpr double kLeastShare = 0.002;   // of the points of a cloud: likewise
constexpr double kFar = 3.0;            // of the median distance from the middle: outside of the cloud
constexpr double kFewFar = 0.02;        // of the points: more are surroundings that were seen, too
constexpr double kShareOfFrames = 0.2;  // in which a place has to be seen to be no stray

using Place = std::array<double, 3>;

struct PlaceHash {
  std::size_t operator()(const Place& place) const {
    std::size_t hash = 0;
    for (const double x : place) hash = 31 * hash + std::hash<double>()(x);
    return hash;
  }
};

template <typename Point>
Place PlaceOf(const Point& point) {
  return {point[0], point[1], point[2]};
}

// Where points are that cannot be there.
struct Repeat {
  int count = 0;
  std::set<int> frames, points;
};
using Repeats = std::vector<std::pair<Place, Repeat>>;

// The one finding of the places; `flag` makes gaps of them.
Finding FindingOf(Repeats repeats, double num_seen, const std::string& flag) {
  std::stable_sort(repeats.begin(), repeats.end(),
                   [](const auto& a, const auto& b) { return a.second.count > b.second.count; });
  Finding finding;
  finding.what = "repeated places";
  finding.severity = Severity::kProblem;
  std::set<int> frames, points;
  std::string given;
  int count = 0;
  for (std::size_t i = 0; i < repeats.size(); ++i) {
    const auto& [place, repeat] = repeats[i];
    count += repeat.count;
    frames.insert(repeat.frames.begin(), repeat.frames.end());
    points.insert(repeat.points.begin(), repeat.points.end());
    if (i >= kMostNamed) continue;
    const std::string x = ShortestText(place[0] + 0.0), y = ShortestText(place[1] + 0.0),
                      z = ShortestText(place[2] + 0.0);
    finding.value += (i == 0 ? "(" : ", (") + x + ", " + y + ", " + z + ")";
    given += (i == 0 ? "" : ":") + x + "," + y + "," + z;
  }
  finding.frames.assign(frames.begin(), frames.end());
  finding.points.assign(points.begin(), points.end());
  if (repeats.size() > kMostNamed) finding.value += ", .. (" + std::to_string(repeats.size()) + " places)";
  finding.value += ": " + std::to_string(count) + " times to the last bit (" + Rounded(100.0 * count / num_seen) +
                   " % of what is seen), in " + Named("frame", finding.frames);
  if (!points.empty()) finding.value += ", of " + Named("point", finding.points);
  finding.hint = "the cloth is not there: does it stand for points that were not seen? " + flag + " " + given +
                 " makes gaps of it (the numbers are those of the file that is converted)";
  return finding;
}

// Tells points of tracks that are far from their neighbours.
class TornPoints {
 public:
  explicit TornPoints(const CheckedMotion& checked)
      : checked_(checked),
        positions_(checked.motion.positions),
        ratios_(LengthRatios(checked.pairs, positions_)),
        pairs_of_(checked.motion.points.size()) {
    for (std::size_t i = 0; i < checked.pairs.size(); ++i) {
      pairs_of_[checked.pairs[i].first].push_back(static_cast<Eigen::Index>(i));
      pairs_of_[checked.pairs[i].second].push_back(static_cast<Eigen::Index>(i));
    }
    std::vector<double> lengths;
    for (const double ratio : ratios_.reshaped()) {
      if (ratio > 0.0) lengths.push_back(ratio);
    }
    if (lengths.empty()) return;
    const auto place =
        lengths.begin() + static_cast<std::ptrdiff_t>(kUsualLength * static_cast<double>(lengths.size()));
    std::nth_element(lengths.begin(), place, lengths.end());
    usual_ = *place;
  }

  // Whether a point, which is seen, cannot be where it is: all its neighbours are far off or in the very same place,
  // and it came there, or leaves it, by a leap. In a frame that copies another an outlier is copied, too.
  bool IsAstray(int point, int frame, bool is_copy) const {
    bool is_shared = false, has_neighbours = false;
    for (const Eigen::Index i : pairs_of_[point]) {
      const double ratio = ratios_(i, frame);
      if (std::isnan(ratio)) continue;
      if (ratio > 0.0 && ratio <= kFarOff * usual_) return false;
      has_neighbours = true;
      is_shared = is_shared || ratio == 0.0;
    }
    if (is_shared || is_copy) return is_shared;
    const double leap = kLeap * usual_ * checked_.spacing;
    return Leap(point, frame) > (has_neighbours ? leap : std::max(leap, kLoneLeap * checked_.cloth_size));
  }

 private:
  // How far off the point is where it is seen elsewhere next, before or after, m.
  double Leap(int point, int frame) const {
    const Eigen::Vector3d place = At(point, frame);
    double leap = 0.0;
    for (const int step : {-1, 1}) {
      for (int other = frame + step; other >= 0 && other < positions_.cols(); other += step) {
        const double distance = (At(point, other) - place).norm();
        leap = std::fmax(leap, distance);
        if (distance > 0.0) break;
      }
    }
    return leap;
  }
  Eigen::Vector3d At(int point, Eigen::Index frame) const { return positions_.col(frame).segment<3>(3 * point); }

  const CheckedMotion& checked_;
  const Eigen::MatrixXd& positions_;
  const Eigen::MatrixXd ratios_;                     // [pairs x T]
  std::vector<std::vector<Eigen::Index>> pairs_of_;  // by point
  double usual_ = 1.0;
};

// Those of tracked points; `copies`: frames that repeat others.
Repeats RepeatsOfTracks(const CheckedMotion& checked, const std::vector<int>& copies) {
  const RecordedMotion& motion = checked.motion;
  const TornPoints torn(checked);
  const auto seen_at = [&](int point, int frame) { return motion.positions.col(frame).segment<3>(3 * point); };
  std::unordered_map<Place, Repeat, PlaceHash> strays;
  for (int frame = 0; frame < motion.num_frames(); ++frame) {
    const bool is_copy = std::binary_search(copies.begin(), copies.end(), frame);
    for (int point = 0; point < motion.num_points(); ++point) {
      if (!seen_at(point, frame).allFinite() || !torn.IsAstray(point, frame, is_copy)) continue;
      Repeat& repeat = strays[PlaceOf(seen_at(point, frame))];
      ++repeat.count;
      repeat.frames.insert(frame);
      repeat.points.insert(point);
    }
  }
  std::map<Place, Repeat> repeats;
  for (const auto& [place, repeat] : strays) {
    if (repeat.count >= kFewestRepeats) repeats.emplace(place, repeat);
  }
  // A point that was taken for one that rests has the place of that one.
  std::map<Place, int> others;
  for (int frame = 0; frame < motion.num_frames() && !repeats.empty(); ++frame) {
    for (int point = 0; point < motion.num_points(); ++point) {
      if (!seen_at(point, frame).allFinite()) continue;
      const auto found = repeats.find(PlaceOf(seen_at(point, frame)));
      if (found != repeats.end() && found->second.points.count(point) == 0) ++others[found->first];
    }
  }
  for (const auto& [place, count] : others) {
    const Repeat& repeat = repeats[place];
    if (static_cast<int>(repeat.points.size()) < kSeveralPoints && count >= repeat.count) repeats.erase(place);
  }
  return {repeats.begin(), repeats.end()};
}

// How often a cloud has each place.
std::unordered_map<Place, int, PlaceHash> Counts(const Eigen::Matrix3Xd& cloud) {
  std::unordered_map<Place, int, PlaceHash> counts;
  for (const auto& point : cloud.colwise()) ++counts[PlaceOf(point)];
  return counts;
}

// How many points a place of a cloud has: in the median of the clouds, for one of which nothing was seen has but one.
double UsualCopies(const std::vector<Eigen::Matrix3Xd>& clouds) {
  std::vector<double> copies;
  for (const Eigen::Matrix3Xd& cloud : clouds) {
    if (cloud.cols() > 0)
      copies.push_back(static_cast<double>(cloud.cols()) / static_cast<double>(Counts(cloud).size()));
  }
  return copies.empty() ? 1.0 : Median(std::move(copies));
}

// The points of a cloud that are far from the others, if they are few.
std::vector<Place> FarPoints(const Eigen::Matrix3Xd& cloud) {
  const Eigen::Vector3d middle(Median(cloud.row(0).transpose()), Median(cloud.row(1).transpose()),
                               Median(cloud.row(2).transpose()));
  const Eigen::VectorXd distances = (cloud.colwise() - middle).colwise().norm().transpose();
  const double far = kFar * Median(distances);
  std::vector<Place> places;
  for (Eigen::Index i = 0; i < cloud.cols(); ++i) {
    if (distances[i] > far) places.push_back(PlaceOf(cloud.col(i)));
  }
  return static_cast<double>(places.size()) <= 1.0 + kFewFar * static_cast<double>(cloud.cols()) ? places
                                                                                                 : std::vector<Place>();
}

// Places that many points of a cloud have, or that a far point has in many clouds.
Repeats RepeatsOfClouds(const std::vector<Eigen::Matrix3Xd>& clouds) {
  std::map<Place, Repeat> crowded, far;
  const auto add = [](const Place& place, int count, std::size_t frame, std::map<Place, Repeat>* repeats) {
    Repeat& repeat = (*repeats)[place];
    repeat.count += count;
    repeat.frames.insert(static_cast<int>(frame));
  };
  const double usual = UsualCopies(clouds);
  for (std::size_t frame = 0; frame < clouds.size(); ++frame) {
    if (clouds[frame].cols() == 0) continue;
    const auto counts = Counts(clouds[frame]);
    const auto num_points = static_cast<double>(clouds[frame].cols());
    const double least = std::max({1.0 * kFewestRepeats, kLeastShare * num_points, kCopies * usual});
    for (const auto& [place, count] : counts) {
      if (count >= least) add(place, count, frame, &crowded);
    }
    for (const Place& place : FarPoints(clouds[frame])) add(place, 1, frame, &far);
  }
  const double least = std::max(1.0 * kFewestRepeats, kShareOfFrames * static_cast<double>(clouds.size()));
  for (const auto& [place, repeat] : far) {
    if (repeat.count >= least) crowded.emplace(place, repeat);
  }
  return {crowded.begin(), crowded.end()};
}

}  // namespace

std::vector<Finding> CheckRepeatedPlaces(const CheckedMotion& checked, const std::vector<int>& repeated_frames) {
  const Repeats repeats = RepeatsOfTracks(checked, repeated_frames);
  if (repeats.empty()) return {};
  const Eigen::MatrixXd& positions = checked.motion.positions;
  const double num_seen = static_cast<double>(positions.size() - positions.array().isNaN().count()) / 3.0;
  return {FindingOf(repeats, num_seen, "motion convert --missing")};
}

std::vector<Finding> CheckRepeatedPlacesOfClouds(const CheckedMotion& checked) {
  const Repeats repeats = RepeatsOfClouds(checked.motion.clouds);
  if (repeats.empty()) return {};
  double num_seen = 0.0;
  for (const Eigen::Matrix3Xd& cloud : checked.motion.clouds) num_seen += static_cast<double>(cloud.cols());
  return {FindingOf(repeats, num_seen, "motion convert_clouds --missing")};
}

}  // namespace clothid
