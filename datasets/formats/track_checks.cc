#include "datasets/formats/track_checks.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <unordered_set>

#include "sim/base/error.h"
#include "sim/base/text_file.h"
#include "sim/mesh/mesh.h"

namespace clothid {
namespace {

[[noreturn]] void FailToWrite(const PointTracks& tracks, const std::string& message) {
  throw Error(ErrorKind::kUsage, tracks.name + ": " + message);
}

std::string FrameAndPoint(const PointTracks& tracks, Eigen::Index frame, Eigen::Index point) {
  std::string text = "frame " + std::to_string(frame) + ", point " + std::to_string(point);
  if (!tracks.labels.empty()) text += " '" + Printable(tracks.labels[static_cast<std::size_t>(point)]) + "'";
  return text;
}

void CheckTimes(const PointTracks& tracks) {
  if (tracks.times.size() == 0) return;
  if (tracks.times.size() != tracks.num_frames()) {
    FailOnData(tracks.name, "has " + std::to_string(tracks.times.size()) + " times for " +
                                std::to_string(tracks.num_frames()) + " frames");
  }
  CheckIncreasing(tracks.name, tracks.times);
}

void CheckNumbers(const PointTracks& tracks) {
  const std::vector<long long>& numbers = tracks.frame_numbers;
  if (numbers.empty()) return;
  const bool increase = std::adjacent_find(numbers.begin(), numbers.end(), std::greater_equal<>()) == numbers.end();
  if (numbers.size() != static_cast<std::size_t>(tracks.num_frames()) || numbers.front() != 0 || !increase) {
    FailOnData(tracks.name, "expected increasing numbers of its frames from 0 on");
  }
}

void CheckPositions(const PointTracks& tracks) {
  for (Eigen::Index frame = 0; frame < tracks.positions.cols(); ++frame) {
    if (!tracks.positions.col(frame).array().isInf().any()) continue;
    Eigen::Index row = 0;
    while (!std::isinf(tracks.positions(row, frame))) ++row;
    FailOnData(tracks.name,
               FrameAndPoint(tracks, frame, row / 3) + ": expected finite numbers, or NaN where it is not seen");
  }
}

void CheckFaces(const PointTracks& tracks) {
  for (Eigen::Index face = 0; face < tracks.faces.cols(); ++face) {
    for (const int point : {tracks.faces(0, face), tracks.faces(1, face), tracks.faces(2, face)}) {
      if (point >= 0 && point < tracks.num_points()) continue;
      FailOnData(tracks.name, "triangle " + std::to_string(face) + " refers to point " + std::to_string(point) +
                                  "; expected 0 to " + std::to_string(tracks.num_points() - 1));
    }
  }
}

}  // namespace

void CheckIncreasing(const std::string& source, const Eigen::VectorXd& times) {
  for (Eigen::Index i = 0; i < times.size(); ++i) {
    const std::string frame = "the time of frame " + std::to_string(i);
    if (!std::isfinite(times[i])) FailOnData(source, frame + " is not finite");
    if (i > 0 && !(times[i] > times[i - 1])) {
      FailOnData(source, frame + ", " + ShortestText(times[i]) + " s, is not after the one before it, " +
                             ShortestText(times[i - 1]) + " s");
    }
  }
}

void CheckTrackSize(const std::string& source, std::uint64_t num_points, std::uint64_t num_frames) {
  const auto check = [&](std::uint64_t count, std::uint64_t most, const std::string& what) {
    if (count == 0) FailOnData(source, "holds no " + what);
    if (count > most) FailOnData(source, "has more than " + std::to_string(most) + " " + what + "s");
  };
  check(num_points, kMaxNodes, "point");
  check(num_frames, kMaxFrames, "frame");
  if (num_points * num_frames > kMaxTrackBytes / (3 * sizeof(double))) {
    FailOnData(source, std::to_string(num_points) + " points in " + std::to_string(num_frames) +
                           " frames are more than the limit of " + std::to_string(kMaxTrackBytes) + " bytes");
  }
}

void CheckTracks(const PointTracks& tracks) {
  if (tracks.positions.rows() % 3 != 0) FailOnData(tracks.name, "expected three coordinates for every point");
  CheckTrackSize(tracks.name, static_cast<std::uint64_t>(tracks.positions.rows() / 3),
                 static_cast<std::uint64_t>(tracks.positions.cols()));
  if (!tracks.labels.empty() && tracks.labels.size() != static_cast<std::size_t>(tracks.num_points())) {
    FailOnData(tracks.name, "has " + std::to_string(tracks.labels.size()) + " labels for " +
                                std::to_string(tracks.num_points()) + " points");
  }
  CheckTimes(tracks);
  CheckNumbers(tracks);
  CheckPositions(tracks);
  CheckFaces(tracks);
}

void RequireTimes(const PointTracks& tracks, const std::string& format) {
  if (tracks.times.size() == 0) FailToWrite(tracks, "has no times, and " + format + " needs them");
}

void RequireEveryPoint(const PointTracks& tracks, const std::string& format) {
  for (Eigen::Index frame = 0; frame < tracks.positions.cols(); ++frame) {
    if (!tracks.positions.col(frame).hasNaN()) continue;
    Eigen::Index row = 0;
    while (!std::isnan(tracks.positions(row, frame))) ++row;
    FailToWrite(tracks, FrameAndPoint(tracks, frame, row / 3) + " is not seen, and " + format +
                            " has no word for that; .npy, PLY, PC2, CSV and TRC have");
  }
}

void RequirePlainLabels(const PointTracks& tracks, const std::string& format) {
  std::unordered_set<std::string> known;
  for (const std::string& label : tracks.labels) {
    for (const char c : label) {
      if (static_cast<unsigned char>(c) >= 0x20 && c != 0x7f) continue;
      FailToWrite(tracks, "label '" + Printable(label) + "' holds control characters, which " + format + " cannot");
    }
    if (label.empty()) FailToWrite(tracks, "a point has an empty label, which " + format + " cannot hold");
    if (!known.insert(label).second) {
      FailToWrite(tracks, "two points are called '" + Printable(label) + "', which " + format + " cannot tell apart");
    }
  }
}

}  // namespace clothid
