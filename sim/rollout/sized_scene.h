// A cloth of another size at rest than its scene says.
//
// A factor s for each of the two axes of the front of the rest shape, unit vectors e_1 and e_2: the columns' and the
// rows' direction of sim/scene/material_field.h, so of a grid along two of the axes x, y, z the first and the second of
// these. The rest shape X [m] is stretched by them about its middle, the mean of its nodes C:
//   X -> X + (s_1 - 1) e_1 e_1^T (X - C) + (s_2 - 1) e_2 e_2^T (X - C)
// Of a mesh with a rest place per corner they are the axes of u and v, and X those places; the nodes stay.
// All that follows from the rest shape does as well: strain, bending, masses, the areas that the air acts on, and the
// places at rest at which a wind is given. Warp directions stay as they are. So does the start of the motion, which was
// measured, or stands in the scene: a cloth that the scene lays out flat is strained by 1/s where its size is s.
#ifndef CLOTHID_SIM_ROLLOUT_SIZED_SCENE_H_
#define CLOTHID_SIM_ROLLOUT_SIZED_SCENE_H_

#include <array>

#include "sim/scene/scene.h"

namespace clothid {

// `scene` with that rest shape. Throws `Error` (kBadData) where the rest shape has no front.
Scene SizedScene(const Scene& scene, const std::array<double, 2>& size);

}  // namespace clothid

#endif  // CLOTHID_SIM_ROLLOUT_SIZED_SCENE_H_
