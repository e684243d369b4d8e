// Scene texts that stand on their own.
#ifndef CLOTHID_DATASETS_MOTION_SCENE_TEXT_H_
#define CLOTHID_DATASETS_MOTION_SCENE_TEXT_H_

#include <string>

#include "sim/scene/obstacle_json.h"
#include "sim/scene/scene.h"

namespace clothid {

// `scene_text`, the JSON that `scene` was read from, with the vertices and faces of its triangulated obstacles, the
// paths of those that move and of what takes handles along, the times of those that deform, the directions of its warp
// and the triangles of its pieces in place of the files that they are from; unchanged where it names none. Numbers read
// back exactly. Throws `Error` (kBadData) where they are too many for one JSON text.
std::string WithInlineLists(const std::string& scene_text, const Scene& scene);

// The places over time of the vertices of its obstacles that deform: what a recording carries in tensors, and
// WithInlineLists leaves out.
RecordedSequences SequencesOf(const Scene& scene);

// `scene_text` with its handles as a recording has them, whose tensors have their paths: nodes, and clamps with what
// turns them. Unchanged where it has no others. Throws `Error` (kBadData) where it is no JSON object.
std::string WithRecordedHandles(const std::string& scene_text);

// The text of a recording of `scene`, which was read from `scene_text`: every value of the original, without the names
// of files and with an explicit start. Surfaces, paths and directions come into it as by WithInlineLists; mesh and
// paths of handles go into the recording's tensors, clamps stay. A start read from a file goes: the first frame has to
// take its place, and `*start_is_first_frame` says so. Throws `Error` (kBadData) where WithInlineLists does and where
// the text is no JSON object.
std::string SelfContainedText(const Scene& scene, const std::string& scene_text, bool* start_is_first_frame);

}  // namespace clothid

#endif  // CLOTHID_DATASETS_MOTION_SCENE_TEXT_H_
