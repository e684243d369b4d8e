#include "datasets/checking/check_coverage.h"

#include <algorithm>
#include <limits>
#include <set>

namespace clothid {
namespace {

constexpr double kRegular = 0.1;       // longest and shortest interval off the median, by share: still regular
constexpr double kManyMissing = 0.05;  // share of points
constexpr double kManySteps = 100.0;   // per frame

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
  if (longest > (1.0 + kRegular) * checked.median_interval || shortest < (1.0 - kRegular) * checked.median_interval) {
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
  std::vector<int> never;
  std::set<int> frames;
  long long num_missing = 0;
  for (int p = 0; p < motion.num_points(); ++p) {
    const auto track = motion.positions.middleRows<3>(3 * p);
    int num_unseen = 0;
    for (int frame = 0; frame < motion.num_frames(); ++frame) {
      if (!track.col(frame).hasNaN()) continue;
      ++num_unseen;
      frames.insert(frame);
    }
    num_missing += num_unseen;
    if (num_unseen > 0) finding.points.push_back(p);
    if (num_unseen == motion.num_frames()) never.push_back(p);
  }
  const double share =
      static_cast<double>(num_missing) / (static_cast<double>(motion.num_points()) * motion.num_frames());
  finding.value = std::to_string(num_missing) + " (" + Rounded(100.0 * share) + " %)";
  if (num_missing == 0) return finding;
  finding.frames.assign(frames.begin(), frames.end());
  finding.value += ", in " + Named("frame", finding.frames) + ", of " + Named("point", finding.points);
  finding.severity = share > kManyMissing || !never.empty() ? Severity::kWarning : Severity::kNote;
  finding.hint = never.empty() ? "a point that is not seen is not compared; intervals grow by what is missing"
                               : Named("point", never) + " never seen: is the mesh larger than what was recorded?";
  return finding;
}

}  // namespace

std::vector<Finding> CheckCoverage(const CheckedMotion& checked) {
  return {CheckFrameRate(checked), CheckGaps(checked), CheckMissing(checked)};
}

std::vector<Finding> CheckTimes(const CheckedMotion& checked) {
  return {CheckFrameRate(checked), CheckGaps(checked), CheckTimeStep(checked)};
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
    finding.hint = "a time step that is larger makes fits faster; identify --check_step says what it costs";
  }
  return finding;
}

}  // namespace clothid
