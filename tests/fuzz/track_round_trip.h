// What the fuzz targets of point tracks share: what was read is consistent, and reads back the same when written.
#ifndef CLOTHID_TESTS_FUZZ_TRACK_ROUND_TRIP_H_
#define CLOTHID_TESTS_FUZZ_TRACK_ROUND_TRIP_H_

#include <string>

#include "datasets/formats/point_tracks.h"
#include "datasets/formats/track_checks.h"
#include "tests/fuzz/fuzz_target.h"

namespace clothid {

// Gives the input to `read`; what it accepts goes through `write` and `read` again, unless `write` refuses it.
inline void CheckRoundTrip(std::string_view input, PointTracks (*read)(const std::string& path),
                           std::string (*write)(const PointTracks& tracks)) {
  static const MemoryFile file, copy;
  file.Write(input);
  PointTracks tracks;
  if (!Accepts([&] { tracks = read(file.path()); }, file.path())) return;
  CheckTracks(tracks);
  std::string bytes;
  if (!Accepts([&] { bytes = write(tracks); }, file.path())) return;
  copy.Write(bytes);
  const PointTracks again = read(copy.path());
  Check(again.times == tracks.times, "the times that were written");
  Check(again.num_points() == tracks.num_points() && again.num_frames() == tracks.num_frames(), "the same sizes");
  Check((again.positions.array() == tracks.positions.array() ||
         (again.positions.array().isNaN() && tracks.positions.array().isNaN()))
            .all(),
        "the positions that were written");
}

}  // namespace clothid

#endif  // CLOTHID_TESTS_FUZZ_TRACK_ROUND_TRIP_H_
