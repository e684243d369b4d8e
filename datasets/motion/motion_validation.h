// Whether the numbers of a recording can be what they are said to be.
#ifndef CLOTHID_DATASETS_MOTION_MOTION_VALIDATION_H_
#define CLOTHID_DATASETS_MOTION_MOTION_VALIDATION_H_

#include <string>

#include "datasets/motion/motion_tensors.h"

namespace clothid {

// Throws `Error` (kBadData), prefixed by `path`, unless sizes agree, indices are in range and numbers are usable: at
// least two times, strictly increasing; a valid mesh; positions finite or NaN; points given by at most one of
// node_index and face_index + barycentric (rows that sum to 1 within 1e-6), by neither only where P = N; handles
// distinct and their paths finite; sigma > 0; clouds, where there are any, one per time, with a point at least and all
// of them finite. P = 0 only beside clouds.
void ValidateMotionTensors(const MotionTensors& tensors, const std::string& path);

}  // namespace clothid

#endif  // CLOTHID_DATASETS_MOTION_MOTION_VALIDATION_H_
