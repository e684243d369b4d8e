#include "datasets/checking/check_coverage.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <memory>
#include <set>
#include <utility>

#include "datasets/checking/finding_words.h"

namespace clothid {
namespace {

constexpr double kRegular = 0.1;       // longest and shortest interval off the median, by share: still regular
constexpr double kManyMissing = 0.05;  // share of points
constexpr double kManySteps = 100.0;   // per frame
constexpr double kSlowFrames = 0.5;    // s between frames: slower than any motion of a cloth that a fit can use
constexpr double kTooSlowFrames = 5.0;
constexpr double kFastFrames = 1e-4;     // s
constexpr std::size_t kTrackStart = 30;  // coordinates
constexpr double kHole = 3.0;            // of the usual interval of the path
constexpr double kMovedAcross = 0.25;    // of the spacing: what handles moved within a hole
constexpr Eigen::Index kFewSamples = 5;  // at an end of a path, that tell its speed
constexpr double kMoving = 0.2;          // of the median step: the cloth did not come to rest
constexpr double kOnObstacle = 1e-6;     // of the cloth's size, from an obstacle: on it

Finding CheckFrameRate(const CheckedMotion& checked) {
  const Eigen::VectorXd& times = checked.motion.times;
  Finding finding;
  finding.what = "frame rate";
  double shortest = std::numeric_limits<double>::infinity(), longest = 0.0;
  for (Eigen::Index i = 1; i < times.size(); ++i) {
    const double interval = times[i] - times[i - 1];
    shortest = std::min(shortest, interval);
    if (interval <= kGapFactor * checked.median_interval) longest = std::max(longest, interval);
  }
  finding.value = Rounded(1.0 / checked.median_interval) + " Hz (median), intervals of " + Rounded(1e3 * shortest) +
                  " to " + Rounded(1e3 * longest) + " ms";
  if (checked.median_interval > kSlowFrames) {
    finding.severity = checked.median_interval > kTooSlowFrames ? Severity::kProblem : Severity::kWarning;
    finding.hint = "are the times in ms? motion convert --time_scale 0.001, or --frame_rate";
  } else if (checked.median_interval < kFastFrames) {
    finding.severity = Severity::kWarning;
    finding.hint = "times are in s: motion convert --time_scale, or --frame_rate";
  } else if (longest > (1.0 + kRegular) * checked.median_interval ||
             shortest < (1.0 - kRegular) * checked.median_interval) {
    finding.severity = Severity::kNote;
    finding.hint = "irregular: each frame is compared at its own time; check that times are those of the exposure";
  }
  return finding;
}

Finding CheckGaps(const CheckedMotion& checked) {
  const Eigen::VectorXd& times = checked.motion.times;
  Finding finding;
  finding.what = "gaps";
  double longest = 0.0;
  for (Eigen::Index i = 1; i < times.size(); ++i) {
    const double interval = times[i] - times[i - 1];
    longest = std::max(longest, interval);
    if (interval > kGapFactor * checked.median_interval) finding.frames.push_back(static_cast<int>(i) - 1);
  }
  finding.value = finding.frames.empty()
                      ? "none"
                      : "after " + Named("frame", finding.frames) + ", up to " + Rounded(longest) + " s";
  if (!finding.frames.empty()) {
    finding.severity = Severity::kNote;
    finding.hint = "nothing is compared within a gap";
    // Handles that are known where the cloth was seen, and nowhere else.
    const HandlePath& path = checked.motion.scene.handles.path;
    if (path.num_handles() > 0 && path.times().size() == times.size() && path.times() == times) {
      finding.hint += ", and paths of handles are guessed there by a smooth curve";
    }
  }
  return finding;
}

Finding CheckMissing(const CheckedMotion& checked) {
  const RecordedMotion& motion = checked.motion;
  Finding finding;
  finding.what = "missing points";
  std::vector<int> never;  // of those that are compared
  std::set<int> frames;
  long long num_missing = 0, num_compared_missing = 0;
  int num_compared = 0;  // points
  for (int p = 0; p < motion.num_points(); ++p) {
    const auto track = motion.positions.middleRows<3>(3 * p);
    int num_unseen = 0;
    // Along an axis that is never seen, as of a width, nothing is missing.
    const Eigen::Array3d never_seen = track.array().isNaN().rowwise().all().cast<double>();
    for (int frame = 0; frame < motion.num_frames(); ++frame) {
      const auto is_unseen = track.col(frame).array().isNaN() && never_seen == 0.0;
      if (!is_unseen.any() && (never_seen == 0.0).any()) continue;
      ++num_unseen;
      frames.insert(frame);
    }
    num_missing += num_unseen;
    if (num_unseen > 0) finding.points.push_back(p);
    if (checked.is_held[p]) continue;
    ++num_compared;
    num_compared_missing += num_unseen;
    if (track.array().isNaN().all()) never.push_back(p);
  }
  const double share =
      static_cast<double>(num_missing) / (static_cast<double>(motion.num_points()) * motion.num_frames());
  finding.value = std::to_string(num_missing) + " (" + Rounded(100.0 * share) + " %)";
  if (num_missing == 0) return finding;
  finding.frames.assign(frames.begin(), frames.end());
  finding.value += ", in " + Named("frame", finding.frames) + ", of " + Named("point", finding.points);
  if (static_cast<int>(never.size()) == num_compared && motion.clouds.empty() && !motion.forces.is_empty()) {
    finding.value += ": nothing is seen beside handles; the forces at these are compared";
    return finding;
  }
  if (motion.positions.array().isNaN().all()) {
    finding.severity = motion.clouds.empty() ? Severity::kProblem : Severity::kWarning;
    finding.hint = "no point is seen in any frame: were the columns of the file read as they are meant?";
    return finding;
  }
  const Eigen::Index num_before = motion.num_frames() - 1;
  if (num_before > 0 && motion.positions.leftCols(num_before).array().isNaN().all()) {
    finding.value += ": the last frame alone is seen, as of cloth at rest";
    return finding;
  }
  const bool is_much = static_cast<double>(num_compared_missing) > kManyMissing * num_compared * motion.num_frames();
  finding.severity = is_much || !never.empty() ? Severity::kWarning : Severity::kNote;
  finding.hint = never.empty() ? "a point that is not seen is not compared; intervals grow by what is missing"
                               : Named("point", never) + " never seen: is the mesh larger than what was recorded?";
  return finding;
}

// Whether what is seen in both columns is the same to the last bit. Something has to be.
bool IsCopy(const Eigen::VectorXd& first, const Eigen::VectorXd& second) {
  bool is_seen = false;
  for (Eigen::Index i = 0; i < first.size(); ++i) {
    if (first[i] == second[i]) is_seen = true;
    if (first[i] != second[i] && !(std::isnan(first[i]) && std::isnan(second[i]))) return false;
  }
  return is_seen;
}

// Whether a frame sees a point that is no handle. Handles alone may be at rest while the cloth moves.
bool SeesCloth(const CheckedMotion& checked, int frame) {
  for (int p = 0; p < checked.motion.num_points(); ++p) {
    if (!checked.is_held[p] && !checked.motion.positions.col(frame).segment<3>(3 * p).hasNaN()) return true;
  }
  return false;
}

// Whether all that is seen lies on obstacles.
bool LiesOnObstacles(const CheckedMotion& checked, int frame) {
  const Eigen::Matrix3Xd places = checked.Places(frame);
  Eigen::VectorXd gaps = Eigen::VectorXd::Constant(places.cols(), std::numeric_limits<double>::infinity());
  for (const SceneObstacle& obstacle : checked.motion.scene.obstacles) {
    const std::shared_ptr<const Obstacle> shape = obstacle.ShapeAt(checked.motion.times[frame]);
    for (Eigen::Index i = 0; i < places.cols(); ++i) {
      gaps[i] = std::min(gaps[i], shape->Closest(places.col(i)).gap - obstacle.contact_distance);
    }
  }
  return (gaps.array() < kOnObstacle * checked.cloth_size).all();
}

// Frames that repeat the one before although the cloth moves. A cloth that comes to rest slows down first, unless it
// lands flat, as a simulated one may.
std::vector<int> RepeatedFrames(const CheckedMotion& checked) {
  const RecordedMotion& motion = checked.motion;
  const int num_frames = motion.num_frames();
  Eigen::VectorXd steps = Eigen::VectorXd::Zero(num_frames + 1);  // into a frame, m
  std::vector<double> moved;
  for (int frame = 1; frame < num_frames; ++frame) {
    if (!SeesCloth(checked, frame - 1) || !SeesCloth(checked, frame)) {
      steps[frame] = std::numeric_limits<double>::quiet_NaN();
      continue;
    }
    if (IsCopy(motion.positions.col(frame - 1), motion.positions.col(frame))) continue;
    const Eigen::VectorXd difference = motion.positions.col(frame) - motion.positions.col(frame - 1);
    steps[frame] = Median(difference.reshaped(3, motion.num_points()).colwise().norm().transpose());
    moved.push_back(steps[frame]);
  }
  const double least = kMoving * Median(std::move(moved));
  std::vector<int> repeated;
  for (int frame = 1; frame < num_frames; ++frame) {
    if (steps[frame] != 0.0) continue;
    int end = frame;
    while (end < num_frames && steps[end] == 0.0) ++end;
    const bool moves = std::fmax(steps[frame - 1], steps[end]) > least;
    if (moves && !(end == num_frames && LiesOnObstacles(checked, end - 1))) {
      for (int k = frame; k < end; ++k) repeated.push_back(k);
    }
    frame = end;
  }
  return repeated;
}

// Points that are where another one is in every frame.
std::vector<int> RepeatedPoints(const RecordedMotion& motion) {
  std::map<std::vector<double>, int> starts;  // of tracks, so that few are compared as a whole
  std::vector<int> repeated;
  for (int p = 0; p < motion.num_points(); ++p) {
    const auto track = motion.positions.middleRows<3>(3 * p);
    std::vector<double> start;
    for (Eigen::Index frame = 0; frame < track.cols() && start.size() < kTrackStart; ++frame) {
      if (!track.col(frame).hasNaN()) start.insert(start.end(), track.col(frame).begin(), track.col(frame).end());
    }
    if (start.empty()) continue;
    const auto [same, is_new] = starts.emplace(std::move(start), p);
    if (!is_new && IsCopy(motion.positions.middleRows<3>(3 * same->second).reshaped(), track.reshaped())) {
      repeated.push_back(p);
    }
  }
  return repeated;
}

std::vector<Finding> CheckCopies(const CheckedMotion& checked) {
  std::vector<Finding> findings;
  Finding finding;
  finding.severity = Severity::kWarning;
  finding.frames = RepeatedFrames(checked);
  if (!finding.frames.empty()) {
    finding.what = "repeated frames";
    finding.value = Named("frame", finding.frames) + " copied from the frame before";
    finding.hint = "the cloth moved on: leave them out (motion convert --skip_frames)";
    findings.push_back(finding);
  }
  const std::vector<Finding> places = CheckRepeatedPlaces(checked, finding.frames);
  finding.frames.clear();
  finding.points = RepeatedPoints(checked.motion);
  if (!finding.points.empty()) {
    finding.what = "repeated points";
    finding.value = Named("point", finding.points) + " where another point is, in every frame";
    finding.hint = "two nodes cannot be in one place: set one of both to NaN";
    findings.push_back(finding);
  }
  findings.insert(findings.end(), places.begin(), places.end());
  return findings;
}

}  // namespace

std::vector<Finding> CheckCoverage(const CheckedMotion& checked) {
  std::vector<Finding> findings = {CheckFrameRate(checked), CheckGaps(checked), CheckMissing(checked)};
  const std::vector<Finding> copies = CheckCopies(checked);
  findings.insert(findings.end(), copies.begin(), copies.end());
  return findings;
}

std::vector<Finding> CheckTimes(const CheckedMotion& checked) { return {CheckFrameRate(checked), CheckGaps(checked)}; }

std::string UnknownTimes(const CheckedMotion& checked, const Eigen::VectorXd& times, const Eigen::MatrixXd& positions) {
  const RecordedMotion& motion = checked.motion;
  const double first = motion.times[0], last = motion.times[motion.num_frames() - 1];
  const Eigen::VectorXd intervals = times.tail(times.size() - 1) - times.head(times.size() - 1);
  const double usual = Median(intervals);
  const auto moved = [&](Eigen::Index from, Eigen::Index to) {
    const Eigen::VectorXd step = positions.col(to) - positions.col(from);
    return step.reshaped(3, step.size() / 3).colwise().norm().maxCoeff();
  };
  const double least = kMovedAcross * checked.spacing + checked.noise_floor;
  std::string holes;
  const auto add = [&](const std::string& hole) { holes += (holes.empty() ? "" : ", ") + hole; };
  for (Eigen::Index i = 0; i < intervals.size(); ++i) {
    if (intervals[i] <= kHole * usual || times[i + 1] <= first || times[i] >= last || moved(i, i + 1) <= least)
      continue;
    add(Rounded(intervals[i]) + " s from " + Rounded(times[i]) + " s on");
  }
  // A path that ends where what follows it stands says all there is.
  const Eigen::Index end = times.size() - 1, few = std::min<Eigen::Index>(kFewSamples, end);
  const auto speed = [&](Eigen::Index from, Eigen::Index to) { return moved(from, to) / (times[to] - times[from]); };
  if (speed(end - few, end) * (last - times[end]) > least) add("all after its end at " + Rounded(times[end]) + " s");
  if (speed(0, few) * (times[0] - first) > least) add("all before its start at " + Rounded(times[0]) + " s");
  return holes;
}

std::vector<Finding> CheckPathTimes(const CheckedMotion& checked) {
  const RecordedMotion& motion = checked.motion;
  const Eigen::VectorXd& times = motion.scene.handles.path.times();
  if (times.size() < 3 || (times.size() == motion.times.size() && times == motion.times)) return {};
  const std::string holes = UnknownTimes(checked, times, motion.scene.handles.path.positions());
  if (holes.empty()) return {};
  Finding finding;
  finding.what = "path of handles";
  finding.severity = Severity::kWarning;
  finding.value = "not known for " + holes;
  finding.hint =
      "a smooth curve, or a standstill, is put there: leave these frames out (motion convert --frames, "
      "--skip_frames), or complete the path";
  return {finding};
}

Finding CheckTimeStep(const CheckedMotion& checked) {
  const Scene& scene = checked.motion.scene;
  Finding finding;
  finding.what = "time step";
  const double steps = checked.median_interval / scene.time_step;
  finding.value = Rounded(steps) + " steps of " + Rounded(1e3 * scene.time_step) + " ms per frame, " +
                  std::to_string(scene.num_steps()) + " in all";
  if (steps < 0.99) {
    finding.severity = Severity::kWarning;
    finding.hint =
        "several frames within one step are compared with a straight line; a smaller time step in the scene "
        "shows what they say";
  } else if (steps > kManySteps) {
    finding.severity = Severity::kNote;
    finding.hint = "a time step that is larger makes fits faster; identify --discretization step says what it costs";
  }
  return finding;
}

}  // namespace clothid
