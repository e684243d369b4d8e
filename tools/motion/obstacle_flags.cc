#include "tools/motion/obstacle_flags.h"

#include <gflags/gflags.h>

#include <filesystem>

#include "datasets/importing/transform_file.h"
#include "sim/base/error.h"
#include "sim/base/text_file.h"

DEFINE_string(obstacle, "", "convert: NAME=FILE, the path of an obstacle");
DEFINE_string(obstacle_transform, "", "convert: file with a rigid transform of the paths of obstacles");
DEFINE_double(obstacle_time_offset, 0.0, "convert: clock of --obstacle minus that of the recording, s");

namespace clothid {
namespace {

std::vector<ObstacleFile> NamedFiles() {
  std::vector<ObstacleFile> files;
  if (FLAGS_obstacle.empty()) return files;
  for (const std::string& item : Split(FLAGS_obstacle, ',')) {
    const std::size_t equals = item.find('=');
    if (equals == std::string::npos || equals == 0 || equals + 1 == item.size()) {
      throw Error(ErrorKind::kUsage,
                  "--obstacle: expected NAME=FILE, or several with commas, got '" + Printable(item) + "'");
    }
    files.push_back({item.substr(0, equals), item.substr(equals + 1)});
  }
  return files;
}

}  // namespace

std::vector<ObstacleFile> ObstacleFilesFromFlags() {
  std::vector<ObstacleFile> files = NamedFiles();
  for (ObstacleFile& file : files) {
    file.time_offset = FLAGS_obstacle_time_offset;
    if (!FLAGS_obstacle_transform.empty()) file.transform = ReadTransform(FLAGS_obstacle_transform);
  }
  return files;
}

std::vector<std::string> ObstacleInputs() {
  std::vector<std::string> inputs = {FLAGS_obstacle_transform};
  for (const ObstacleFile& file : NamedFiles()) inputs.push_back(file.path);
  return inputs;
}

std::string ObstacleWords() {
  std::string words;
  for (const ObstacleFile& file : NamedFiles()) {
    words += (words.empty() ? "" : ",") + file.name + "=" + std::filesystem::path(file.path).filename().string();
  }
  return words;
}

}  // namespace clothid
