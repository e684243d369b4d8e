// How handles were measured whose place a recording tells, and not its scene.
#ifndef CLOTHID_DATASETS_MOTION_HANDLE_MEASUREMENTS_H_
#define CLOTHID_DATASETS_MOTION_HANDLE_MEASUREMENTS_H_

#include <Eigen/Core>
#include <vector>

#include "datasets/motion/motion_tensors.h"
#include "datasets/motion/recorded_motion.h"
#include "sim/scene/scene.h"

namespace clothid {

// For a scene whose handles come from `tensors`, with sigma [P] m of its points. Handles that stand still get a path of
// one knot: the mean of what their points show over all frames, without what is far off; where no point shows them they
// stay where the scene has them, give or take a twentieth of the cloth's size. Handles whose measured path is part of
// the recording keep that path; what it was smoothed by is left over, and its noise is estimated from its own scatter.
// Empty where nothing is left open: no handles, a path from the scene's own file, or one without noise.
HandleMeasurements MeasureHandles(const MotionTensors& tensors, const std::vector<ObservedPoint>& points,
                                  const Eigen::VectorXd& sigma, Scene* scene);

}  // namespace clothid

#endif  // CLOTHID_DATASETS_MOTION_HANDLE_MEASUREMENTS_H_
