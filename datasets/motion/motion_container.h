// The container of motion.bin (datasets/motion/motion_file.h), verified. Internal to datasets/.
#ifndef CLOTHID_DATASETS_MOTION_MOTION_CONTAINER_H_
#define CLOTHID_DATASETS_MOTION_MOTION_CONTAINER_H_

#include <string>

#include "datasets/motion/motion_tensors.h"

namespace clothid {

struct VerifiedMotion {
  MotionTensors tensors;
  std::string sha256;  // of the whole file
};

// Throws `Error` as `ReadMotion` does for the container.
VerifiedMotion ReadVerifiedMotion(const std::string& path);

}  // namespace clothid

#endif  // CLOTHID_DATASETS_MOTION_MOTION_CONTAINER_H_
