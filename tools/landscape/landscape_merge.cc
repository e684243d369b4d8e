#include "tools/landscape/landscape_merge.h"

#include <map>
#include <utility>

#include "sim/base/error.h"

namespace clothid {
namespace {

[[noreturn]] void FailOnFolder(const std::string& folder, const std::string& problem) {
  throw Error(ErrorKind::kUsage, folder + ": " + problem);
}

std::string NameOf(const LandscapeShard& shard) {
  return "shard " + std::to_string(shard.index) + " of " + std::to_string(shard.count);
}

}  // namespace

LandscapePart MergeLandscapes(const std::vector<std::string>& folders) {
  if (folders.empty()) throw Error(ErrorKind::kUsage, "expected the folders of the shards; see landscape --help");
  LandscapePart merged;
  std::map<int, std::string> folder_of_shard;
  for (const std::string& folder : folders) {
    LandscapePart part = ReadLandscapePart(folder);
    const LandscapeShard shard = part.origin.shard;
    if (folder_of_shard.empty()) merged = part;
    if (part.origin.fingerprint != merged.origin.fingerprint) {
      FailOnFolder(folder, "is of another scan than " + folders.front() + ": recording, scene, program or flags differ");
    }
    if (shard.count != merged.origin.shard.count) {
      FailOnFolder(folder, "is " + NameOf(shard) + ", but " + folders.front() + " is " + NameOf(merged.origin.shard));
    }
    const auto [found, is_new] = folder_of_shard.emplace(shard.index, folder);
    if (!is_new) FailOnFolder(folder, "is " + NameOf(shard) + ", as " + found->second + " is");
    for (const int cell : shard.Cells(merged.landscape.plan)) {
      merged.landscape.cells[cell] = std::move(part.landscape.cells[cell]);
    }
  }
  for (LandscapeShard shard = {0, merged.origin.shard.count}; shard.index < shard.count; ++shard.index) {
    if (folder_of_shard.count(shard.index) == 0) throw Error(ErrorKind::kUsage, NameOf(shard) + " is missing");
  }
  merged.origin.shard = {};
  return merged;
}

}  // namespace clothid
