// Point caches of Blender, Houdini and 3ds Max (.pc2, version 1). Little-endian:
//   "POINTCACHE2\0"  i32 version  i32 number of points  f32 first frame  f32 frames per sample  i32 number of samples
// then the positions as f32, sample by sample. The file counts in frames of an animation and knows no seconds, no faces
// and no names.
#ifndef CLOTHID_DATASETS_FORMATS_PC2_FILE_H_
#define CLOTHID_DATASETS_FORMATS_PC2_FILE_H_

#include <cstdint>
#include <string>

#include "datasets/formats/point_tracks.h"

namespace clothid {

inline constexpr std::uint64_t kMaxPc2Bytes = std::uint64_t{1} << 31;

// Reads such a file; NaN: not seen. Throws `Error`: kIo where the file cannot be read, else kBadData naming file and
// fault, also for a file of more than kMaxPc2Bytes.
PointTracks ReadPc2(const std::string& path);

// The bytes of a file with these positions, rounded to f32, one sample per frame from frame 0. Throws `Error` (kUsage)
// for a coordinate beyond f32.
std::string Pc2Bytes(const PointTracks& tracks);

}  // namespace clothid

#endif  // CLOTHID_DATASETS_FORMATS_PC2_FILE_H_
