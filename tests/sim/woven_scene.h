// A scene of a woven cloth.
#ifndef CLOTHID_TESTS_SIM_WOVEN_SCENE_H_
#define CLOTHID_TESTS_SIM_WOVEN_SCENE_H_

#include <Eigen/Core>
#include <utility>

#include "sim/scene/scene.h"

namespace clothid {

// Warp and weft at an angle to the mesh, in membrane and bending.
inline Scene Woven(Scene scene) {
  const Material nominal = scene.nominal_parameters().material;
  const double k = nominal.stretch_stiffness, bend = nominal.bending_stiffness;
  for (const char* name : {"k_stretch", "k_bend"}) scene.parameters.erase(name);
  scene.membrane = MembraneLaw::kOrthotropic;
  scene.bending = {BendingLaw::kPatches, 0.2, true};
  scene.warp = {Eigen::Vector3d(1.0, 0.2, 0.3), 30.0};
  Material& material = scene.material;
  material.stretch_stiffness = material.bending_stiffness = 0.0;
  material.warp_stiffness = 1.3 * k;
  material.weft_stiffness = 0.8 * k;
  material.shear_stiffness = 0.3 * k;
  material.poisson_stiffness = 0.25 * k;
  material.warp_bending = 2.0 * bend;
  material.weft_bending = 0.7 * bend;
  material.twist_bending = 0.5 * bend;
  return scene;
}

// The same with a membrane of yarns that stiffen.
inline Scene Knitted(Scene scene) {
  Scene knit = Woven(std::move(scene));
  knit.membrane = MembraneLaw::kYarn;
  knit.material.warp_stiffening = 6.0;
  knit.material.weft_stiffening = 3.0;
  return knit;
}

}  // namespace clothid

#endif  // CLOTHID_TESTS_SIM_WOVEN_SCENE_H_
