// The scenes of `benchmark stability`. Those of the grid: a square of cloth, 1 x 1 m, 0.2 kg/m^2, k_b = 1e-3 N m, for
// 0.3 s.
//
//   drape  thrown at 1 m/s on a sphere of radius 0.3 m, off its middle: nodes join, stick, slip and take off
//   push   the same on a ball that goes sideways with 1 m/s, out from under it, and turns with 10 rad/s
//   slope  thrown at 0.5 m/s on a plane inclined by 25 degrees, one edge first: slips up to mu = 0.47, else sticks
//   fold   lies folded on a table of mu = 0.35, its upper part thrown down at 1 m/s and across at 0.5 m/s on the lower
//          one; friction is that of the cloth with itself, which is 5 mm thick; contact by gap alone
//   wind   hung by two corners in a gusty wind, c_d = 0.4 kg/(m^2 s): no obstacle, so neither friction nor contact mode
// The cloth has at rest the shape in which it starts (fold: before it was folded), waves of 5 mm: a flat cloth that is
// compressed in its plane stands at a bifurcation, where rounding alone decides how it buckles.
#ifndef CLOTHID_TOOLS_BENCHMARK_STEPS_STABILITY_SCENE_H_
#define CLOTHID_TOOLS_BENCHMARK_STEPS_STABILITY_SCENE_H_

#include <Eigen/Core>
#include <functional>
#include <string>
#include <vector>

#include "sim/scene/scene.h"

namespace clothid {

inline const std::vector<std::string> kStabilityScenes = {"drape", "push", "slope", "fold", "wind"};

// One cell of the grid.
struct StabilityCell {
  std::string scene;
  ContactMode contact_mode = ContactMode::kGap;
  double stretch_stiffness = 0.0;  // k, N/m
  double time_step = 0.0;          // h, s
  double friction_coefficient = 0.0;
  Integrator integrator = Integrator::kEuler;
  double stiffening = 0.0;  // > 0: a membrane of yarns with it, k_warp = k_weft = k and k_shear = k/2; else isotropic
};

// Whether friction and contact mode make a difference.
bool StabilitySceneHasObstacle(const std::string& name);
// Whether the friction is that of the cloth with itself, and contact by gap.
bool StabilitySceneMeetsItself(const std::string& name);

// Of a cell, with nodes x nodes nodes, at least 2 x 2.
Scene MakeStabilityScene(const StabilityCell& cell, int nodes);

// The cloth of the grid, at rest where it starts, its middle at `center`; no handles, obstacles, air or velocity.
// `scene->mesh` has nodes x nodes nodes; the axes are directions.
Scene MakeStabilityCloth(int nodes, const Eigen::Vector3d& center, const Eigen::Vector3d& first_axis,
                         const Eigen::Vector3d& second_axis);

// Lets the cloth start where `scene->mesh` is at rest, every node with the same velocity [m/s].
void StartAtRestShape(const Eigen::Vector3d& velocity, Scene* scene);

// The last obstacle, whose shape is about its origin, is at `place`(t), m, and turned by `spin` t rad about x; t
// in s, up to the end of the scene.
void MoveLastObstacle(const std::function<Eigen::Vector3d(double)>& place, double spin, Scene* scene);

struct StabilityExtreme {
  std::string name;
  std::function<Scene(int nodes)> scene;  // with `nodes` nodes along an axis, at least 4, where it is a grid
};

// Scenes at the limits of what a simulator of cloth may be given, each the drape with k = 1000 N/m, h = 5 ms, mu = 0.35
// in gap mode but for what its name says, in the order of the table
// (stability_extremes.cc).
const std::vector<StabilityExtreme>& StabilityExtremes();

}  // namespace clothid

#endif  // CLOTHID_TOOLS_BENCHMARK_STEPS_STABILITY_SCENE_H_
