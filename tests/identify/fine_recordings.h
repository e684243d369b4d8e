// Recordings of a cloth that was simulated with finer steps, or on a finer mesh, than the scene they come with.
#ifndef CLOTHID_TESTS_IDENTIFY_FINE_RECORDINGS_H_
#define CLOTHID_TESTS_IDENTIFY_FINE_RECORDINGS_H_

#include <map>
#include <memory>
#include <string>

#include "sim/scene/refinement.h"
#include "tests/costs/synthetic_motion.h"

namespace clothid {

// 4 x 4 nodes sliding down a plane of 30 degrees, by backward Euler, whose steps err by far more than noise.
inline Scene SlopeScene() {
  Scene scene = ClothScene(4, 30);
  scene.integrator = Integrator::kEuler;
  scene.gravity = 9.81 * Eigen::Vector3d(0.5, 0.0, -std::sqrt(0.75));
  SceneObstacle plane;
  plane.name = "plane";
  plane.shape = std::make_shared<Plane>(Eigen::Vector3d::Zero(), Eigen::Vector3d::UnitZ());
  plane.friction_coefficient = 0.2;
  scene.obstacles = {plane};
  return scene;
}

// A recording of the cloth of `scene` on a mesh refined `levels` times, with steps of h/`divisor`; seen at the nodes of
// the coarse mesh, which keep their numbers, with `noise`, in m.
inline RecordedMotion RecordFinely(const Scene& scene, int divisor, int levels,
                                   const std::map<std::string, double>& values, double noise = 1e-3) {
  Scene fine = scene;
  fine.time_step /= divisor;
  for (int level = 0; level < levels; ++level) fine = RefineScene(fine, RefineMesh(fine.mesh));
  MotionOptions truth;
  truth.true_values = values;
  truth.frame_interval = scene.time_step;
  truth.noise = truth.sigma = noise;
  RecordedMotion motion = MakeMotion(fine, truth);
  const int num_nodes = scene.mesh.num_nodes();
  motion.scene = scene;
  motion.points.resize(static_cast<std::size_t>(num_nodes));
  motion.sigma = motion.sigma.head(num_nodes).eval();
  motion.positions = motion.positions.topRows(3 * num_nodes).eval();
  return motion;
}

}  // namespace clothid

#endif  // CLOTHID_TESTS_IDENTIFY_FINE_RECORDINGS_H_
