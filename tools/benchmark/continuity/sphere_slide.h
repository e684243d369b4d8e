// The scene of Figure 2 of the DiffCloth paper: a piece of cloth on a static, frictional sphere, which sticks, slides
// or takes off as friction has it.
//
// The sphere has a radius of 1 m; the cloth, 0.2 x 0.2 m, 0.3 kg/m^2, lies 10 degrees off its top. It slides for 200
// steps of 4 ms, 2.5 times the time sqrt(R/g) in which a sliding point is e times as far from the top: without friction
// it leaves the sphere shortly before the end, and with mu = 0.35 every node sticks from the start. At rest it has the
// shape in which it starts, so that what it shows is contact, not buckling: on the sphere it slides as it is.
#ifndef CLOTHID_TOOLS_BENCHMARK_CONTINUITY_SPHERE_SLIDE_H_
#define CLOTHID_TOOLS_BENCHMARK_CONTINUITY_SPHERE_SLIDE_H_

#include <array>
#include <string>
#include <vector>

#include "sim/scene/scene.h"

namespace clothid {

// What stands for the sphere.
struct SlideSurface {
  std::string name;
  int num_splits = 0;  // of the icosahedron inscribed in the sphere; negative: the sphere itself
};

inline const std::vector<SlideSurface> kSlideSurfaces = {{"analytic", -1}, {"faces_320", 2}, {"faces_1280", 3}};

// Whose velocities are looked at.
inline constexpr std::array<const char*, 3> kSlideNodeNames = {"corner", "edge_centre", "centre"};

struct SphereSlide {
  Scene scene;
  std::array<int, 3> watched_nodes;  // as in kSlideNodeNames
};

// With a grid of nodes x nodes nodes, which must be odd and at least 3. Every node starts at rest, on the surface: a
// grid, rolled onto the sphere along its radii, and from there moved to the closest points.
SphereSlide MakeSphereSlide(const SlideSurface& surface, int nodes, ContactMode contact_mode);

}  // namespace clothid

#endif  // CLOTHID_TOOLS_BENCHMARK_CONTINUITY_SPHERE_SLIDE_H_
