// The `sequence` of an obstacle of scene.json.
#ifndef CLOTHID_SIM_SCENE_SEQUENCE_JSON_H_
#define CLOTHID_SIM_SCENE_SEQUENCE_JSON_H_

#include <Eigen/Core>
#include <memory>
#include <string>
#include <vector>

#include "sim/base/json_document.h"
#include "sim/obstacle/obstacle.h"
#include "sim/obstacle/surface_sequence.h"

namespace clothid {

// Reads the object `node`, the places over time of the vertices of `shape`, a TriangulatedSurface. Relative names of
// files in it start at `folder`. `recorded` [3V x T] (may be null): those that a recording brings itself, which stand
// where the text names no file. Throws `Error` naming key and line, and file and frame (kBadData), or a file that
// cannot be read (kIo).
std::shared_ptr<const SurfaceSequence> ReadSequence(const JsonNode& node, const Obstacle& shape,
                                                    const Eigen::MatrixXd* recorded, const std::string& folder);

// The files that a `file` of a sequence stands for: itself, or the OBJ files of a pattern or of a folder, as far as
// there are any.
std::vector<std::string> FilesOfSequence(const std::string& path);

}  // namespace clothid

#endif  // CLOTHID_SIM_SCENE_SEQUENCE_JSON_H_
