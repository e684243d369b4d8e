// A scan whose cells are kept on disk while it runs, so that it can be stopped and continued at any time.
#ifndef CLOTHID_TOOLS_LANDSCAPE_LANDSCAPE_RUN_H_
#define CLOTHID_TOOLS_LANDSCAPE_LANDSCAPE_RUN_H_

#include <functional>
#include <map>
#include <string>
#include <vector>

#include "datasets/motion/recorded_motion.h"
#include "tools/landscape/landscape_files.h"
#include "tools/landscape/landscape_scan.h"

namespace clothid {

// The SHA-256 of everything that determines the cells, beside the shard: the program, the recording with the scenes of
// the settings as it was read (before `MeasureTruth`), the plan, the truth and what a fit weighs and holds.
std::string LandscapeFingerprint(const LandscapeScanOptions& scan, const LandscapeOrigin& origin);

struct LandscapeRunOptions {
  LandscapeScanOptions scan;  // without `cells` and `on_cell`
  LandscapeOrigin origin;
  std::string folder;   // for the output; made where it is missing
  bool resume = false;  // takes over what an earlier run of the same shard of the same scan has left in the folder
  // After every cell: so many of `num_cells` are done, of them `num_kept` by earlier runs. May be empty.
  std::function<void(int num_done, int num_cells, int num_kept)> on_progress;
};

struct LandscapeRunResult {
  LandscapePart part;
  int num_cells = 0;     // of the shard
  int num_kept = 0;      // of them, done by earlier runs
  int num_done = 0;      // with this run
  double seconds = 0.0;  // of this run

  bool is_complete() const { return num_done == num_cells; }
};

// Scans a shard and writes its files, all or none. Where it is cancelled or fails, its finished cells stay in the
// folder for `resume`. Throws `Error` where `ScanLandscape`, `OutputFolder` and `LandscapeStore` do, and (kUsage)
// naming --output where the folder holds the cells of a scan that was stopped and is not to be resumed, or where what
// is to be resumed is another scan.
LandscapeRunResult RunLandscape(LandscapeRunOptions options);

}  // namespace clothid

#endif  // CLOTHID_TOOLS_LANDSCAPE_LANDSCAPE_RUN_H_
