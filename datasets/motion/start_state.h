// Where a recorded cloth starts: a shape that it can have, near what its first frames show.
//
// A noisy frame is no shape of a cloth: edges are stretched by the noise over their length, nodes stand inside
// obstacles, and a simulation that starts there jumps. So the start is the minimum over the free nodes of
//   1/2 sum_p rho(w_p |x_p - y_p|^2) + a_s E_s(x) + a_b E_b(x)    with  phi >= 0  at every node,
// y_p and 1/w_p position and variance of a point at the first frame (datasets/motion/frame_trend.h), rho the Cauchy
// loss of three standard deviations, E_s the ARAP stretch energy and E_b the bending energy of sim/ by the scene's
// law, both without their stiffness. Handles stand on their path.
//   a_s = 1/(e^2 mean triangle area),  e = 0.02: a strain of 2 % is as likely as an error of one standard deviation;
//   a_b: the largest of a grid that keeps median and upper tenth of w_p |x_p - y_p|^2 within what noise makes of them
//        (Morozov 1966) and throws no further point off.
// Layers of a cloth that meets itself are then pushed apart to its thickness.
// So little noise leaves the measured shape as it is. What was not seen takes the shape that costs least.
#ifndef CLOTHID_DATASETS_MOTION_START_STATE_H_
#define CLOTHID_DATASETS_MOTION_START_STATE_H_

#include <Eigen/Core>
#include <vector>

#include "datasets/motion/frame_trend.h"
#include "datasets/motion/recorded_motion.h"
#include "sim/scene/scene.h"

namespace clothid {

// [3N] m. `scene`: mesh, obstacles and handles; its initial positions are where the search starts for nodes that are no
// points, and where handles stay. `points` [P] with their `trend`. Obstacles are penetrated nowhere but by handles.
Eigen::VectorXd SmoothStartPositions(const Scene& scene, const std::vector<ObservedPoint>& points,
                                     const FrameTrend& trend);

// [3N] m/s: the minimum of 1/2 sum_p |v_p - velocity_p|^2/variance_p + b E_b(v), b as much as the data weigh per
// node, handles at the velocity of their path. Zero where the trend has no velocities.
Eigen::VectorXd SmoothStartVelocities(const Scene& scene, const std::vector<ObservedPoint>& points,
                                      const FrameTrend& trend);

}  // namespace clothid

#endif  // CLOTHID_DATASETS_MOTION_START_STATE_H_
