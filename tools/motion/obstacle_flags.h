// The flags of motion convert that are about paths of obstacles.
#ifndef CLOTHID_TOOLS_MOTION_OBSTACLE_FLAGS_H_
#define CLOTHID_TOOLS_MOTION_OBSTACLE_FLAGS_H_

#include <string>
#include <vector>

#include "datasets/importing/obstacle_tracks.h"

namespace clothid {

// Empty without --obstacle. Throws `Error`: kUsage, naming the flag, or where `ReadTransform` does.
std::vector<ObstacleFile> ObstacleFilesFromFlags();

// The files that they name, empty names among them.
std::vector<std::string> ObstacleInputs();

// NAME=FILE,.. without the folders of the files.
std::string ObstacleWords();

}  // namespace clothid

#endif  // CLOTHID_TOOLS_MOTION_OBSTACLE_FLAGS_H_
