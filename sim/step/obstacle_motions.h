// Where the obstacles of a scene are in a solve, and how they move over it.
//
// With A(t) an obstacle's pose at its placement and A' its rate, t_n and t_{n+1} the ends of a step of size h, eta and
// gamma as in stage.h, t_1 = t_n + eta:
//   backward Euler   A_0 = A(t_n),                             E = (A(t_{n+1}) - A(t_n))/h
//   first stage      A_0 = A(t_n),                             E = A'(t_1)
//   second stage     A_0 = A_s = A(t_n) + (1 - gamma) h A'(t_1),   E = (A(t_{n+1}) - A_s)/eta
// So a node that sticks to a point p of an obstacle ends the step exactly where that point is, A(t_{n+1}) p: the second
// stage starts with it at A_s p, where the state of the cloth is taken to by the first (second_start.h), and its E is
// A'(t_{n+1}) but for terms of second order in h. In the first stage the mean (A(t_1) - A(t_n))/eta would leave an
// error of first order. What stops an impact there is told by the change of V from A'(t_n) on. Of a surface that
// deforms A is the map of each of its faces (sim/obstacle/deformed_surface.h).
#ifndef CLOTHID_SIM_STEP_OBSTACLE_MOTIONS_H_
#define CLOTHID_SIM_STEP_OBSTACLE_MOTIONS_H_

#include <functional>
#include <vector>

#include "sim/obstacle/obstacle_motion.h"
#include "sim/scene/parameters.h"
#include "sim/scene/scene.h"
#include "sim/step/stage.h"

namespace clothid {

// One per obstacle; empty where none moves.
std::vector<ObstacleMotion> ObstacleMotions(const Scene& scene, const Parameters& parameters, const SolveTimes& times);

// What a part of the placement of an obstacle that moves changes at places. Keeps references to `obstacle` and
// `motion`, its motion over the solve.
class ObstacleChange {
 public:
  ObstacleChange(const SceneObstacle& obstacle, const ObstacleMotion& motion, const Placement& placement,
                 PlacementPart part, const SolveTimes& times);

  // At a node where n and dn/dx are those.
  MotionChange At(const Eigen::Vector3d& position, const Eigen::Vector3d& normal,
                  const Eigen::Matrix3d& normal_gradient) const;

 private:
  const ObstacleMotion& motion_;
  SolveMaps maps_;                            // of a rigid body
  std::function<SolveMaps(int face)> faces_;  // of what deforms
};

}  // namespace clothid

#endif  // CLOTHID_SIM_STEP_OBSTACLE_MOTIONS_H_
