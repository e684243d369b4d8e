// Writes the output folder of a scan, which identify/landscape/landscape_folder.h reads, and joins those of shards.
#ifndef CLOTHID_TOOLS_LANDSCAPE_LANDSCAPE_FILES_H_
#define CLOTHID_TOOLS_LANDSCAPE_LANDSCAPE_FILES_H_

#include <string>
#include <vector>

#include "identify/base/output_folder.h"
#include "identify/landscape/landscape_folder.h"

namespace clothid {

// Whether `WriteLandscape` writes files of this name.
bool IsLandscapeFile(const std::string& name);

// plan.json, landscape.csv, timing.csv and of a whole scan summary.json (tools/landscape/landscape_summary.h), under
// temporary names until `folder->Commit()`, which also removes those of them that are not written. All cells of the
// shard must have been evaluated; only they are written.
void WriteLandscape(const Landscape& landscape, const LandscapeOrigin& origin, OutputFolder* folder);

// The shards of a scan as one landscape. `folders` hold the shards, each of them once, in any order. Apart from the
// times, the landscape, and the files that `WriteLandscape` makes of it, are those of a scan that was not divided.
// Throws `Error`: kUsage where the shards are not of one scan or one is missing or there twice, and what
// `ReadLandscapePart` does.
LandscapePart MergeLandscapes(const std::vector<std::string>& folders);

}  // namespace clothid

#endif  // CLOTHID_TOOLS_LANDSCAPE_LANDSCAPE_FILES_H_
