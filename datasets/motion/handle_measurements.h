// How handles were measured whose place a recording tells, and not its scene.
#ifndef CLOTHID_DATASETS_MOTION_HANDLE_MEASUREMENTS_H_
#define CLOTHID_DATASETS_MOTION_HANDLE_MEASUREMENTS_H_

#include <Eigen/Core>

#include "datasets/motion/recorded_motion.h"

namespace clothid {

// Handles that stand still get a path of one knot in the scene of `motion`: the mean of what their points show over all
// frames, without what is far off; where no point shows them they stay where the scene has them, give or take a
// twentieth of the cloth's size. `sigma` [P] m: of the points. Empty where that is all exact.
HandleMeasurements MeasureStandingHandles(const Eigen::VectorXd& sigma, RecordedMotion* motion);

// Handles whose measured path is known: at times [K] s the positions [3H x K] m that the scene's path was smoothed
// from. Their noise is estimated from their own scatter. Empty where there is none, or too little to tell.
HandleMeasurements MeasureHandlePath(const Eigen::VectorXd& times, const Eigen::MatrixXd& positions,
                                     const Scene& scene);

}  // namespace clothid

#endif  // CLOTHID_DATASETS_MOTION_HANDLE_MEASUREMENTS_H_
