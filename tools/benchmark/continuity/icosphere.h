// Triangulated spheres: an icosahedron whose triangles are split into four again and again.
#ifndef CLOTHID_TOOLS_BENCHMARK_CONTINUITY_ICOSPHERE_H_
#define CLOTHID_TOOLS_BENCHMARK_CONTINUITY_ICOSPHERE_H_

#include "sim/scene/mesh.h"

namespace clothid {

// 20 * 4^num_splits triangles with their corners on the unit sphere around the origin, oriented outwards. Faces of the
// same surface: no node is there twice. `num_splits` from 0 to 8.
Mesh MakeIcosphere(int num_splits);

}  // namespace clothid

#endif  // CLOTHID_TOOLS_BENCHMARK_CONTINUITY_ICOSPHERE_H_
