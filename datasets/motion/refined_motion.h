// The same recording of the same cloth on a mesh of twice the density (sim/scene/refinement.h).
#ifndef CLOTHID_DATASETS_MOTION_REFINED_MOTION_H_
#define CLOTHID_DATASETS_MOTION_REFINED_MOTION_H_

#include "datasets/motion/recorded_motion.h"

namespace clothid {

// Measurements stay as they are. An observed node keeps its number; a point on a triangle becomes the same material
// point of one of the four smaller ones. A handle between two others counts as not measured: what they show is all that
// is known of it. `scene_text` stays that of the coarse mesh. Throws `Error` where `ExpectRefinable` does.
RecordedMotion RefineMotion(const RecordedMotion& motion);

}  // namespace clothid

#endif  // CLOTHID_DATASETS_MOTION_REFINED_MOTION_H_
