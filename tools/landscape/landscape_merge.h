// The shards of a scan as one landscape.
#ifndef CLOTHID_TOOLS_LANDSCAPE_LANDSCAPE_MERGE_H_
#define CLOTHID_TOOLS_LANDSCAPE_LANDSCAPE_MERGE_H_

#include <string>
#include <vector>

#include "identify/landscape/landscape_folder.h"

namespace clothid {

// `folders` hold the shards, each of them once, in any order. Apart from the times, the landscape, and the files that
// `WriteLandscape` makes of it, are those of a scan that was not divided. Throws `Error`: kUsage where the shards are
// not of one scan or one is missing or there twice, and what `ReadLandscapePart` does.
LandscapePart MergeLandscapes(const std::vector<std::string>& folders);

}  // namespace clothid

#endif  // CLOTHID_TOOLS_LANDSCAPE_LANDSCAPE_MERGE_H_
