// Point tracks in point caches (sim/mesh/point_cache.h).
#ifndef CLOTHID_DATASETS_FORMATS_PC2_FILE_H_
#define CLOTHID_DATASETS_FORMATS_PC2_FILE_H_

#include <string>

#include "datasets/formats/point_tracks.h"
#include "sim/mesh/point_cache.h"

namespace clothid {

// Reads such a file; NaN: not seen. Throws `Error`: kIo where the file cannot be read, else kBadData naming file and
// fault, also for a file of more than kMaxPc2Bytes.
PointTracks ReadPc2(const std::string& path);

// The bytes of a file with these positions, rounded to f32, one sample per frame from frame 0. Throws `Error` (kUsage)
// for a coordinate beyond f32.
std::string Pc2Bytes(const PointTracks& tracks);

}  // namespace clothid

#endif  // CLOTHID_DATASETS_FORMATS_PC2_FILE_H_
