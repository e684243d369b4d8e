// Scene texts that stand on their own.
#ifndef CLOTHID_DATASETS_SCENE_TEXT_H_
#define CLOTHID_DATASETS_SCENE_TEXT_H_

#include <string>

#include "sim/scene.h"

namespace clothid {

// `scene_text`, the JSON that `scene` was read from, with the vertices and faces of its triangulated obstacles in place
// of the names of their files; unchanged where it has none. Numbers read back exactly, so that the surfaces are the
// same. Throws `Error` (kBadData) where they are too large for one JSON text.
std::string WithInlineSurfaces(const std::string& scene_text, const Scene& scene);

}  // namespace clothid

#endif  // CLOTHID_DATASETS_SCENE_TEXT_H_
