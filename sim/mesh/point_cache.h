// Point caches of Blender, Houdini and 3ds Max (.pc2, version 1). Little-endian:
//   "POINTCACHE2\0"  i32 version  i32 number of points  f32 first frame  f32 frames per sample  i32 number of samples
// then the positions as f32, sample by sample. The file counts in frames of an animation and knows no seconds, no faces
// and no names.
#ifndef CLOTHID_SIM_MESH_POINT_CACHE_H_
#define CLOTHID_SIM_MESH_POINT_CACHE_H_

#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <string>

namespace clothid {

inline constexpr std::uint64_t kMaxPc2Bytes = std::uint64_t{1} << 31;

struct PointCache {
  Eigen::MatrixXd positions;  // [3P x T] in the file's own unit; NaN: not seen
  double first_frame = 0.0, frames_per_sample = 1.0;
};

// Reads such a file. `check_size`, which may throw, is asked with its numbers of points and samples before memory is
// taken for them; may be empty. Throws `Error`: kIo where the file cannot be read, else kBadData naming file and fault,
// also for a file of more than kMaxPc2Bytes.
PointCache ReadPointCache(const std::string& path,
                          const std::function<void(std::uint64_t points, std::uint64_t samples)>& check_size = {});

}  // namespace clothid

#endif  // CLOTHID_SIM_MESH_POINT_CACHE_H_
