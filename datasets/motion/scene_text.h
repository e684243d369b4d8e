// Scene texts that stand on their own.
#ifndef CLOTHID_DATASETS_MOTION_SCENE_TEXT_H_
#define CLOTHID_DATASETS_MOTION_SCENE_TEXT_H_

#include <string>

#include "sim/scene/scene.h"

namespace clothid {

// `scene_text`, the JSON that `scene` was read from, with the vertices and faces of its triangulated obstacles in place
// of the names of their files; unchanged where it has none. Numbers read back exactly, so that the surfaces are the
// same. Throws `Error` (kBadData) where they are too large for one JSON text.
std::string WithInlineSurfaces(const std::string& scene_text, const Scene& scene);

// The text of a recording of `scene`, which was read from `scene_text`: every value of the original, without the names
// of files and with an explicit start. Surfaces come into it as by WithInlineSurfaces; mesh and handle paths go into
// the recording's tensors. A start read from a file goes: the first frame has to take its place, and
// `*start_is_first_frame` says so. Throws `Error` (kBadData) where WithInlineSurfaces does and where the text is no
// JSON object.
std::string SelfContainedText(const Scene& scene, const std::string& scene_text, bool* start_is_first_frame);

}  // namespace clothid

#endif  // CLOTHID_DATASETS_MOTION_SCENE_TEXT_H_
