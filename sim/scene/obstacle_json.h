// The `obstacles` of scene.json.
#ifndef CLOTHID_SIM_SCENE_OBSTACLE_JSON_H_
#define CLOTHID_SIM_SCENE_OBSTACLE_JSON_H_

#include <Eigen/Core>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "sim/base/json_document.h"
#include "sim/scene/scene.h"

namespace clothid {

// The places over time of the vertices of surfaces [3V x T] m, by the names of their obstacles.
using RecordedSequences = std::map<std::string, Eigen::MatrixXd>;

// Reads the array `list`. Relative names of files in it start at `folder`. `recorded`: what a recording brings of
// sequences, which stand where the text names no file of them. Obstacles without a name get that of their
// type, made unique: "sphere", "sphere2", ... Throws `Error` naming key and line (kBadData) or a file that cannot be
// read (kIo).
std::vector<SceneObstacle> ReadObstacles(const JsonNode& list, const RecordedSequences& recorded,
                                         const std::string& folder);

// The path of a body: a file (sim/path/pose_csv.h), or a list of its rows. Throws likewise.
std::shared_ptr<const RigidPath> ReadBodyPath(const JsonNode& node, const std::string& folder);

}  // namespace clothid

#endif  // CLOTHID_SIM_SCENE_OBSTACLE_JSON_H_
