#include "tools/landscape/landscape_run.h"

#include <algorithm>
#include <ostream>
#include <sstream>
#include <utility>

#include "datasets/files/sha256.h"
#include "identify/base/fingerprint.h"
#include "identify/base/output_folder.h"
#include "sim/base/error.h"
#include "sim/base/phase_seconds.h"
#include "tools/landscape/landscape_store.h"

namespace clothid {
namespace {

void DescribeAxis(const LandscapeAxis& axis, std::ostream* text) {
  *text << " " << axis.parameter << " " << static_cast<int>(axis.scale) << " " << axis.lower << " " << axis.upper << " "
        << axis.num_cells;
}

// What the finished files in the folder hold, where there are any. Throws `Error` (kUsage) unless they are those of
// this shard of this scan.
std::vector<int> TakeOverFiles(const LandscapeRunOptions& options, Landscape* landscape) {
  if (!HasLandscape(options.folder)) return {};
  LandscapePart part = ReadLandscapePart(options.folder);
  const LandscapeShard &found = part.origin.shard, &wanted = options.origin.shard;
  const bool is_same = part.origin.fingerprint == options.origin.fingerprint && found.index == wanted.index &&
                       found.count == wanted.count;
  if (!is_same) {
    throw Error(ErrorKind::kUsage, "--output: " + options.folder +
                                       ": holds the landscape of another scan or shard; leave out --resume to replace "
                                       "it, or choose another folder");
  }
  *landscape = std::move(part.landscape);
  return wanted.Cells(landscape->plan);
}

// The cells of the shard without those of `done`.
std::vector<int> MissingCells(const LandscapePlan& plan, const LandscapeShard& shard, std::vector<int> done) {
  std::sort(done.begin(), done.end());
  std::vector<int> missing;
  for (const int cell : shard.Cells(plan)) {
    if (!std::binary_search(done.begin(), done.end(), cell)) missing.push_back(cell);
  }
  return missing;
}

void CheckFolder(const LandscapeRunOptions& options) {
  if (options.resume || !LandscapeStore::ExistsIn(options.folder)) return;
  throw Error(ErrorKind::kUsage, "--output: " + options.folder +
                                     ": holds the cells of a scan that was stopped; add --resume to go on with it, or "
                                     "remove the folder");
}

}  // namespace

std::string LandscapeFingerprint(const LandscapeScanOptions& scan, const LandscapeOrigin& origin) {
  const LandscapePlan& plan = scan.plan;
  std::ostringstream text;
  DescribeProgram(&text);
  for (const RecordedMotion& motion : scan.motions) DescribeMotion(motion, &text);
  for (const LandscapeSetting& setting : plan.settings) {
    text << "setting " << setting.name << " " << static_cast<int>(setting.contact_mode) << "\n";
  }
  for (const LandscapeWindow& window : plan.windows) {
    text << "window " << window.zoom;
    DescribeAxis(window.x, &text);
    DescribeAxis(window.y, &text);
    text << "\n";
  }
  text << "gradients " << plan.has_gradients << "\n";
  for (const auto& [name, value] : origin.truth) text << "true " << name << " " << value << "\n";
  if (origin.fit) text << "fit " << ScannedFitJson(*origin.fit).dump() << "\n";  // which has every digit
  return Sha256Hex({text.str()});
}

LandscapeRunResult RunLandscape(LandscapeRunOptions options) {
  LandscapeScanOptions& scan = options.scan;
  scan.Validate();
  OutputFolder folder(options.folder);
  CheckFolder(options);
  LandscapeRunResult result;
  result.part.origin = options.origin;
  Landscape& landscape = result.part.landscape;
  landscape.plan = scan.plan;
  landscape.cells.resize(static_cast<std::size_t>(scan.plan.num_cells()));
  std::vector<int> kept;
  if (options.resume && !LandscapeStore::ExistsIn(options.folder)) kept = TakeOverFiles(options, &landscape);
  LandscapeStore store(options.folder, scan.plan, options.origin);
  if (kept.empty()) kept = store.Replay(&landscape);

  scan.cells = MissingCells(scan.plan, options.origin.shard, kept);
  result.num_kept = result.num_done = static_cast<int>(kept.size());
  result.num_cells = result.num_kept + static_cast<int>(scan.cells->size());
  scan.on_cell = [&](int cell, const LandscapeCell& cell_result, int num_done, int) {
    store.Append(cell, cell_result);
    landscape.cells[cell] = cell_result;
    result.num_done = result.num_kept + num_done;
    if (options.on_progress) options.on_progress(result.num_done, result.num_cells, result.num_kept);
  };
  {
    const ScopedTimer timer(&result.seconds);
    ScanLandscape(scan);
  }
  if (!result.is_complete()) return result;
  WriteLandscape(landscape, options.origin, &folder);
  folder.Commit();
  store.Remove();
  return result;
}

}  // namespace clothid
