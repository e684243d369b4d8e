// Reads the output folder of a scan of the program `landscape`: plan.json, landscape.csv and timing.csv, and of a whole
// scan summary.json.
//
// landscape.csv has a row per cell, in the order of the cells (identify/landscape/landscape_row.h); equal landscapes
// are equal files. plan.json says what was scanned and has the digest of landscape.csv.
#ifndef CLOTHID_IDENTIFY_LANDSCAPE_LANDSCAPE_FOLDER_H_
#define CLOTHID_IDENTIFY_LANDSCAPE_LANDSCAPE_FOLDER_H_

#include <cstdint>
#include <map>
#include <optional>
#include <string>

#include "identify/landscape/landscape.h"
#include "identify/landscape/scanned_fit.h"

namespace clothid {

inline constexpr std::uint64_t kMaxCsvBytes = std::uint64_t{4} << 30;
inline constexpr char kLandscapeSchema[] = "clothid.landscape/1";
inline constexpr char kLandscapeCsv[] = "landscape.csv";
inline constexpr char kTimingCsv[] = "timing.csv";
inline constexpr char kPlanJson[] = "plan.json";
inline constexpr char kSummaryJson[] = "summary.json";
inline constexpr char kCellStore[] = ".landscape_cells";  // the cells of a scan that has not come to its end

// What a landscape was made of, and which part of it this is.
struct LandscapeOrigin {
  std::string version, git;             // of the program
  std::string input_sha256;             // of the recording
  std::map<std::string, double> truth;  // the parameters that the measured data was simulated with; empty: none
  std::string fingerprint;              // of everything that determines the cells of all shards [64 digits]
  LandscapeShard shard;
  std::optional<LandscapeSigma> sigma;  // of the residuals; absent in scans of clothid 0.1
  std::optional<ScannedFit> fit;        // absent: of no fit
};

struct LandscapePart {
  Landscape landscape;  // the cells of other shards are as `LandscapeCell` is made
  LandscapeOrigin origin;
};

// Whether the folder holds a finished landscape or shard.
bool HasLandscape(const std::string& folder);

// The finished landscape or shard in a folder. Of the counts of cells there are those that have a column. Throws
// `Error`: kIo where a file cannot be opened, kBadData where one is damaged or the folder holds a scan that was
// stopped.
LandscapePart ReadLandscapePart(const std::string& folder);

// The same, of a whole scan alone: kBadData where it is a shard.
LandscapePart ReadWholeLandscape(const std::string& folder);

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_LANDSCAPE_LANDSCAPE_FOLDER_H_
