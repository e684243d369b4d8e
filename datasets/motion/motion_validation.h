// Whether the numbers of a recording can be what they are said to be.
#ifndef CLOTHID_DATASETS_MOTION_MOTION_VALIDATION_H_
#define CLOTHID_DATASETS_MOTION_MOTION_VALIDATION_H_

#include <string>

#include "datasets/motion/motion_tensors.h"
#include "datasets/motion/recorded_motion.h"

namespace clothid {

// The most steps of the scene that a recording may last: those of a rollout are counted by int, also where a fitted
// time offset lets it go on for as long again.
inline constexpr int kMaxRecordedSteps = 1 << 29;

// For recordings that a program makes: whatever predicts one (datasets/observation/observation.h) calls it first.
// Throws `Error` (kBadData), "NAME: FIELD[INDEX] .." with what was expected, unless sizes agree, indices are in range
// and numbers are usable: at least one time, all of them finite, increasing, not before the start of the scene and not
// farther than kMaxRecordedSteps behind it; positions finite or NaN; points of one or three nodes of the mesh whose
// weights sum to 1 within 1e-6; sigma > 0; clouds, where there are any, one per time, finite, with a point at least; a
// valid mesh, start state and handles of its size. No points only beside clouds. What a scene must be beside that,
// `ValidateScene` says.
void ValidateMotion(const RecordedMotion& motion);

// For what stands in a file. Throws `Error` (kBadData), "PATH: tensor 'NAME': ..", unless sizes agree, indices are in
// range and numbers are usable: at least two times, strictly increasing; a valid mesh; positions finite or NaN; points
// given by at most one of node_index and face_index + barycentric (rows that sum to 1 within 1e-6), by neither only
// where P = N; handles distinct and their paths finite; sigma > 0; clouds, where there are any, one per time, with a
// point at least and all of them finite. P = 0 only beside clouds.
void ValidateMotionTensors(const MotionTensors& tensors, const std::string& path);

}  // namespace clothid

#endif  // CLOTHID_DATASETS_MOTION_MOTION_VALIDATION_H_
