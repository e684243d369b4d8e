// The laws of a cloth in the words of a scene, as result.json has them: constants mean something under one law alone.
#ifndef CLOTHID_IDENTIFY_BASE_CLOTH_LAWS_H_
#define CLOTHID_IDENTIFY_BASE_CLOTH_LAWS_H_

#include "datasets/fabric/fabric_card.h"
#include "sim/scene/scene.h"

namespace clothid {

// "edges", "patches"; null of a cloth that does not bend.
inline const char* BendingWord(const Scene& scene) {
  if (!scene.has_bending()) return nullptr;
  return scene.bending.law == BendingLaw::kPatches ? "patches" : "edges";
}

// "arap", "orthotropic", "yarn".
inline const char* MembraneWord(const Scene& scene) { return MembraneName(scene.membrane); }

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_BASE_CLOTH_LAWS_H_
