// Motion capture's TRC files (Track Row Column), as Motion Analysis, OpenSim and others write them. Lines with tabs:
//   PathFileType  4  (X/Y/Z)  NAME
//   DataRate  CameraRate  NumFrames  NumMarkers  Units  OrigDataRate  OrigDataStartFrame  OrigNumFrames
//   the values of these
//   Frame#  Time  LABEL  (blank)  (blank)  LABEL  ..
//   (blank)  (blank)  X1  Y1  Z1  X2  ..
// an empty line, which some leave out, then a row per frame: its number, its time (s), three cells per marker. Blank
// cells: not seen.
#ifndef CLOTHID_DATASETS_FORMATS_TRC_FILE_H_
#define CLOTHID_DATASETS_FORMATS_TRC_FILE_H_

#include <cstdint>
#include <string>

#include "datasets/formats/point_tracks.h"

namespace clothid {

inline constexpr std::uint64_t kMaxTrcBytes = std::uint64_t{1} << 29;

// Reads such a file; positions are converted to metres from the unit that it names (m, cm or mm, or spelt out). Throws
// `Error`: kIo where the file cannot be read, else kBadData naming file and line: also where the rows are not as many
// as NumFrames, not as long as NumMarkers, or do not come at the DataRate, and for a file of more than kMaxTrcBytes.
PointTracks ReadTrc(const std::string& path);

// The text of a file, in metres, from which `ReadTrc` makes the same times, positions and labels, bit for bit. Points
// without a label are called point_0, point_1, .. `tracks` must have times and labels that are free of control
// characters, blanks at their ends and repetitions; else throws `Error` (kUsage).
std::string TrcText(const PointTracks& tracks);

}  // namespace clothid

#endif  // CLOTHID_DATASETS_FORMATS_TRC_FILE_H_
