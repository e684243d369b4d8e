#include "datasets/motion/motion_name.h"

#include <filesystem>

#include "datasets/files/atomic_file.h"
#include "sim/base/error.h"

namespace clothid {

bool IsMotionName(const std::string& path) { return std::filesystem::path(path).extension() == ".bin"; }

void ExpectMotionName(const std::string& path) {
  if (IsMotionName(path) || IsStream(path)) return;
  throw Error(ErrorKind::kUsage,
              path + ": expected a name that ends in .bin for a recording; `motion convert` makes other formats of it");
}

}  // namespace clothid
