// Point tracks as a table with one row per time and point ("tidy" or long form):
//   t,id,x,y,z
//   0,corner,0.1,0.2,0.3
//
// It is a table of sim/base/table.h. t is in s. An id is a name or a number. A point that is not seen has no row at
// that time, or one with empty or NaN coordinates, or with a number below 0 in a column `residual`, as in C3D files.
#ifndef CLOTHID_DATASETS_FORMATS_TRACKS_CSV_H_
#define CLOTHID_DATASETS_FORMATS_TRACKS_CSV_H_

#include <cstdint>
#include <string>

#include "datasets/formats/point_tracks.h"

namespace clothid {

inline constexpr std::uint64_t kMaxTracksCsvBytes = std::uint64_t{1} << 29;

// Reads such a file. Rows come in any order, as long as those of one time stand together; frames are sorted by time.
// Points are sorted by id in natural order, in which runs of digits count as numbers (NaturalLess of
// sim/base/frame_names.h): the order of the rows, and who is missing in which frame, do not matter. Labels are
// the ids, or none where these are 0, 1, .., P - 1. Throws `Error`: kIo where the file cannot be read, else kBadData
// naming file, line and column, also for a file of more than kMaxTracksCsvBytes.
PointTracks ReadTracksCsv(const std::string& path);

// The text of a file from which `ReadTracksCsv` makes the same times and positions, bit for bit, the points sorted by
// label. Points without a label are called 0, 1, .. `tracks` must have times, and labels that differ and are free of
// control characters; else throws `Error` (kUsage). A point that is not seen has no row, except in the first frame,
// which names every point, and where the frame would have no row at all.
std::string TracksCsvText(const PointTracks& tracks);

}  // namespace clothid

#endif  // CLOTHID_DATASETS_FORMATS_TRACKS_CSV_H_
