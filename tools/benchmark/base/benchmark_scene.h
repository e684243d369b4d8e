// The scenes of the speed benchmarks, on square grids of any size. The first two are the extremes of section 5.4 of the
// DiffCloth paper: hardly a contact, and every node in contact.
//
//   wind    6 x 6 m, hung by two corners, 0.054 kg/m^2, a constant force of (0, 0.0043, 0.0043) N on each of 576 nodes
//           (scaled by 576/N on other grids); no bending, no drag, no obstacle
//   slope   1 x 1 m, 0.2 kg/m^2, on a plane inclined by 42.3 degrees with mu = 0.5: every node slips
//   sphere  1 x 1 m, 0.2 kg/m^2, k_b = 1e-3 N m, dropped on a sphere of radius 0.3 m with mu = 0.4: nodes join, stick,
//           slip
//   fold    0.3 x 0.3 m, 0.2 kg/m^2, k_b = 2e-5 N m, drag and damping 0.05, on a table with mu = 0.5; a gripper takes
//   an
//           edge over to the other half within 0.6 s, puts it down and drags it to and fro until 1.2 s. mu.self = 0.3,
//           thickness 3 mm
//   fold_through  the same cloth without contact with itself: the layers pass through each other
#ifndef CLOTHID_TOOLS_BENCHMARK_BASE_BENCHMARK_SCENE_H_
#define CLOTHID_TOOLS_BENCHMARK_BASE_BENCHMARK_SCENE_H_

#include <memory>
#include <string>
#include <vector>

#include "sim/scene/scene.h"

namespace clothid {

inline const std::vector<std::string> kBenchmarkScenes = {"wind", "slope", "sphere"};
// Of the benchmark of steps besides.
inline const std::vector<std::string> kForwardScenes = {"wind", "slope", "sphere", "fold", "fold_through"};

// Scene `name` with nodes x nodes nodes, gravity along -z, lengths in m. Throws `Error` (kUsage), naming --scene or
// --nodes, for an unknown name and fewer than 2 nodes.
Scene MakeBenchmarkScene(const std::string& name, int nodes, double stretch_stiffness, double time_step);

void AddObstacle(const std::string& name, std::shared_ptr<const Obstacle> shape, double friction_coefficient,
                 Scene* scene);

}  // namespace clothid

#endif  // CLOTHID_TOOLS_BENCHMARK_BASE_BENCHMARK_SCENE_H_
