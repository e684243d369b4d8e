// The output folder of a scan: plan.json, landscape.csv and timing.csv, and of a whole scan summary.json.
//
// landscape.csv has a row per cell, in the order of the cells (tools/landscape_row.h); equal landscapes are equal
// files.
#ifndef CLOTHID_TOOLS_LANDSCAPE_FILES_H_
#define CLOTHID_TOOLS_LANDSCAPE_FILES_H_

#include <cstdint>
#include <map>
#include <string>

#include "identify/output_folder.h"
#include "tools/landscape.h"
#include "tools/landscape_plan.h"

namespace clothid {

inline constexpr std::uint64_t kMaxCsvBytes = std::uint64_t{4} << 30;
inline constexpr char kLandscapeCsv[] = "landscape.csv";
inline constexpr char kTimingCsv[] = "timing.csv";
inline constexpr char kPlanJson[] = "plan.json";
inline constexpr char kSummaryJson[] = "summary.json";  // tools/landscape_summary.h

// What a landscape was made of, and which part of it this is.
struct LandscapeOrigin {
  std::string version, git;             // of the program
  std::string input_sha256;             // of the recording
  std::map<std::string, double> truth;  // the parameters that the measured data was simulated with; empty: none
  std::string fingerprint;              // of everything that determines the cells of all shards [64 digits]
  LandscapeShard shard;
};

struct LandscapePart {
  Landscape landscape;  // the cells of other shards are as `LandscapeCell` is made
  LandscapeOrigin origin;
};

// Under temporary names until `folder->Commit()`. All cells of the shard must have been evaluated; only they are
// written.
void WriteLandscape(const Landscape& landscape, const LandscapeOrigin& origin, OutputFolder* folder);

// Whether the folder holds a finished landscape or shard.
bool HasLandscape(const std::string& folder);

// The finished landscape in a folder. Of the counts of cells there are those that have a column. Throws `Error`: kIo
// where a file cannot be opened, kBadData where one is damaged or the folder holds a shard or a scan that was stopped.
Landscape ReadLandscape(const std::string& folder);

// The same, of any shard.
LandscapePart ReadLandscapePart(const std::string& folder);

}  // namespace clothid

#endif  // CLOTHID_TOOLS_LANDSCAPE_FILES_H_
