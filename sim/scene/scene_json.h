// scene.json: see datasets/scene.md for every key. The same text stands inside motion.bin.
#ifndef CLOTHID_SIM_SCENE_SCENE_JSON_H_
#define CLOTHID_SIM_SCENE_SCENE_JSON_H_

#include <string>
#include <vector>

#include "sim/scene/obstacle_json.h"
#include "sim/scene/scene.h"

namespace clothid {

// Parts of a scene that a recording brings itself, so its scene text may leave them out.
struct SceneDefaults {
  bool has_mesh = false;  // the recording's tensors give mesh, start, duration and handle paths
  Mesh mesh;
  Eigen::VectorXd initial_positions;  // [3N] the first frame, completed; used where the text has no `initial`
  double start_time = 0.0;
  double duration = 0.0;
  Handles handles;  // used for the path where the recording carries one
  RecordedSequences sequences;
};

// Reads the text of a scene. `source` names it in errors ("scene.json" or "motion.bin: scene"); `folder` is where
// relative file names in the text start. Every error is an `Error` (kBadData, or kIo for a file that cannot be opened)
// of the form "SOURCE:LINE: key 'obstacles[0].mu': expected a number >= 0". Unknown keys, wrong types, values out of
// range and files that do not fit are errors.
Scene ParseScene(const std::string& text, const std::string& source, const std::string& folder,
                 const SceneDefaults& defaults = {});

// ParseScene of a file's content. Throws `Error` (kIo) where it cannot be read.
Scene ReadScene(const std::string& path);

// The scene.json `path` and the files that it names, there or not: of meshes, of a path of handles, of a start. For
// programs that must not write over them. Of a pipe, which is read once, it alone. Throws `Error` where `path` cannot
// be read or is no JSON; keys that are wrong are left to ReadScene.
std::vector<std::string> FilesOfScene(const std::string& path);

}  // namespace clothid

#endif  // CLOTHID_SIM_SCENE_SCENE_JSON_H_
