// What the reading and the writing of motion.bin share. Internal to datasets/.
#ifndef CLOTHID_DATASETS_MOTION_MOTION_CONTAINER_H_
#define CLOTHID_DATASETS_MOTION_MOTION_CONTAINER_H_

#include <string>

#include "datasets/motion/motion_file.h"

namespace clothid {

struct VerifiedMotion {
  MotionTensors tensors;
  std::string sha256;  // of the whole file
};

// ReadMotionTensors together with the checksum of the file.
VerifiedMotion ReadVerifiedMotion(const std::string& path);

// Throws `Error` (kBadData), prefixed by `path`, unless sizes agree, indices are in range and numbers are usable: at
// least two times, strictly increasing; a valid mesh; positions finite or NaN; points given by at most one of
// node_index and face_index + barycentric (rows that sum to 1 within 1e-6), by neither only where P = N; handles
// distinct and their paths finite; sigma > 0; clouds, where there are any, one per time, with a point at least and all
// of them finite. P = 0 only beside clouds.
void ValidateMotionTensors(const MotionTensors& tensors, const std::string& path);

}  // namespace clothid

#endif  // CLOTHID_DATASETS_MOTION_MOTION_CONTAINER_H_
