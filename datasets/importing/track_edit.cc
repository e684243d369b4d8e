#include "datasets/importing/track_edit.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

#include "sim/base/error.h"
#include "sim/base/text_file.h"

namespace clothid {
namespace {

void RequirePositive(double value, const std::string& what) {
  if (std::isfinite(value) && value > 0.0) return;
  throw Error(ErrorKind::kUsage, what + " " + ShortestText(value) + ": expected a finite number > 0");
}

void Check(const TrackEdit& edit) {
  RequirePositive(edit.scale, "scale");
  RequirePositive(edit.time_scale, "time_scale");
  if (edit.frame_rate != 0.0) RequirePositive(edit.frame_rate, "frame_rate");
  if (edit.frame_rate != 0.0 && edit.times.size() > 0) {
    throw Error(ErrorKind::kUsage, "frame_rate: expected without times of another file");
  }
  if (edit.start_at && !std::isfinite(*edit.start_at)) {
    throw Error(ErrorKind::kUsage, "start_at: expected a finite number (s)");
  }
}

// The file that the times of frames come from.
std::string TimesName(const PointTracks& tracks, const TrackEdit& edit) {
  const std::string& name = edit.times.size() > 0 ? edit.times_name : tracks.times_name;
  return name.empty() || edit.frame_rate > 0.0 ? tracks.name : name;
}

Eigen::VectorXd TimesOf(const PointTracks& tracks, const TrackEdit& edit) {
  const Eigen::Index count = tracks.num_frames();
  Eigen::VectorXd times =
      edit.times.size() > 0 ? TimesOfNumbers(edit.times, tracks.frame_numbers) : Eigen::VectorXd(tracks.times);
  if (edit.frame_rate > 0.0) times = TimesAtRate(edit.frame_rate, count, tracks.frame_numbers, tracks.name);
  if (times.size() == 0) {
    throw Error(ErrorKind::kUsage, tracks.name + ": holds no times; expected a frame rate or a file of times");
  }
  const std::string source = TimesName(tracks, edit);
  if (times.size() != count) {
    FailOnData(source, "expected " + std::to_string(count) + " times, one per frame of " + tracks.name + ", found " +
                           std::to_string(times.size()));
  }
  times *= edit.time_scale;
  for (Eigen::Index i = 0; i < count; ++i) {
    if (std::isfinite(times[i]) && (i == 0 || times[i] > times[i - 1])) continue;
    FailOnData(source, "expected the time of frame " + std::to_string(i) + " to be finite and after the one before");
  }
  return times;
}

std::vector<int> KeptFrames(const PointTracks& tracks, const TrackEdit& edit, int end) {
  for (const int frame : edit.skipped_frames) {
    if (frame < edit.first_frame || frame >= end) {
      throw Error(ErrorKind::kUsage, tracks.name + ": frame " + std::to_string(frame) +
                                         " cannot be skipped: it is not among the frames " +
                                         std::to_string(edit.first_frame) + " to " + std::to_string(end - 1));
    }
  }
  std::vector<bool> is_skipped(static_cast<std::size_t>(tracks.num_frames()), false);
  for (const int frame : edit.skipped_frames) is_skipped[frame] = true;
  std::vector<int> kept;
  for (int frame = edit.first_frame; frame < end; ++frame) {
    if (!is_skipped[frame]) kept.push_back(frame);
  }
  if (kept.empty()) throw Error(ErrorKind::kUsage, tracks.name + ": every frame is skipped");
  return kept;
}

// Those of the frames kept, from 0 on.
void KeepNumbers(const std::vector<int>& frames, std::vector<long long>* numbers) {
  if (numbers->empty()) return;
  std::vector<long long> kept;
  for (const int frame : frames) kept.push_back((*numbers)[frame] - (*numbers)[frames.front()]);
  *numbers = std::move(kept);
}

// A product with NaN is NaN, also in the coordinates that a turn about an axis leaves alone.
void Transform(const TrackEdit& edit, Eigen::MatrixXd* positions) {
  *positions *= edit.scale;
  if (edit.transform.matrix() == Eigen::Matrix4d::Identity()) return;
  for (Eigen::Index frame = 0; frame < positions->cols(); ++frame) {
    for (Eigen::Index p = 0; p < positions->rows(); p += 3) {
      const Eigen::Vector3d position = positions->col(frame).segment<3>(p);
      positions->col(frame).segment<3>(p) = edit.transform * position;
    }
  }
}

}  // namespace

Eigen::VectorXd TimesAtRate(double frame_rate, Eigen::Index count, const std::vector<long long>& numbers,
                            const std::string& source) {
  Eigen::VectorXd times(count);
  for (Eigen::Index i = 0; i < count; ++i) {
    times[i] = static_cast<double>(numbers.empty() ? i : numbers[static_cast<std::size_t>(i)]) / frame_rate;
  }
  const long long num_missing = numbers.empty() ? 0 : numbers.back() + 1 - count;
  if (num_missing <= count) return times;
  throw Error(ErrorKind::kBadData, source + ": the numbers in the names of its " + std::to_string(count) +
                                       " files leave out " + std::to_string(num_missing) +
                                       "; expected numbers of frames, or times of the files instead of a frame rate");
}

Eigen::VectorXd TimesOfNumbers(const Eigen::VectorXd& times, const std::vector<long long>& numbers) {
  return !numbers.empty() && times.size() == numbers.back() + 1 ? Eigen::VectorXd(times(numbers)) : times;
}

EditedTracks EditTracks(const PointTracks& tracks, const TrackEdit& edit) {
  Check(edit);
  const int end = std::min(edit.end_frame, tracks.num_frames());
  if (edit.first_frame < 0 || edit.first_frame >= end) {
    throw Error(ErrorKind::kUsage, tracks.name + ": has " + std::to_string(tracks.num_frames()) +
                                       " frames; expected to keep at least one of them");
  }
  EditedTracks result;
  result.frames = KeptFrames(tracks, edit, end);
  result.tracks = tracks;
  result.tracks.times = TimesOf(tracks, edit)(result.frames);
  result.tracks.times_name = TimesName(tracks, edit);
  result.tracks.positions = tracks.positions(Eigen::all, result.frames);
  KeepNumbers(result.frames, &result.tracks.frame_numbers);
  edit.missing.Erase(tracks.units_per_metre, &result.tracks.positions);
  Transform(edit, &result.tracks.positions);
  if (edit.start_at) {
    const double first = result.tracks.times[0];
    result.time_shift = *edit.start_at - first;
    Eigen::VectorXd since = result.tracks.times;
    if (edit.times_since_first.size() > 0) {
      since = TimesOfNumbers(edit.times_since_first, tracks.frame_numbers)(result.frames) * edit.time_scale;
    }
    // Of times since 1970 the difference is exact, their sum with the shift is not.
    result.tracks.times = *edit.start_at + (since.array() - since[0]);
  }
  return result;
}

}  // namespace clothid
