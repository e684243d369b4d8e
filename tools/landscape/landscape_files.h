// Writes the output folder of a scan, which identify/landscape/landscape_folder.h reads.
#ifndef CLOTHID_TOOLS_LANDSCAPE_LANDSCAPE_FILES_H_
#define CLOTHID_TOOLS_LANDSCAPE_LANDSCAPE_FILES_H_

#include <string>

#include "identify/base/output_folder.h"
#include "identify/landscape/landscape_folder.h"

namespace clothid {

// Whether `WriteLandscape` writes files of this name.
bool IsLandscapeFile(const std::string& name);

// plan.json, landscape.csv, timing.csv and of a whole scan summary.json (tools/landscape/landscape_summary.h), under
// temporary names until `folder->Commit()`, which also removes those of them that are not written. All cells of the
// shard must have been evaluated; only they are written.
void WriteLandscape(const Landscape& landscape, const LandscapeOrigin& origin, OutputFolder* folder);

}  // namespace clothid

#endif  // CLOTHID_TOOLS_LANDSCAPE_LANDSCAPE_FILES_H_
