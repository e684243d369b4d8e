// Evaluates the cells of a landscape.
//
// A cell is one rollout of its setting with the values of the axes: its cost L = 1/2 |e|^2 as of costs/rollout_cost.h
// without a robust loss, at the scene's full precision, and on request the adjoint gradient. Cells know nothing of each
// other: their values depend neither on the number of threads, nor on the order, nor on which others are evaluated.
#ifndef CLOTHID_TOOLS_LANDSCAPE_LANDSCAPE_SCAN_H_
#define CLOTHID_TOOLS_LANDSCAPE_LANDSCAPE_SCAN_H_

#include <atomic>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "datasets/motion/recorded_motion.h"
#include "identify/landscape/landscape.h"
#include "identify/landscape/scanned_fit.h"

namespace clothid {

struct LandscapeScanOptions {
  LandscapePlan plan;
  // One for each of plan.settings, in their order: the scene, with the setting's contact mode, and the measured data.
  std::vector<RecordedMotion> motions;
  // Parameters on no axis, also of the recording itself, that differ from their nominal values, by name.
  std::map<std::string, double> held;
  ModelError model_error;                     // that frames are weighed by
  Assimilation assimilation;                  // how the recording corrects the rollouts of cells
  std::optional<std::vector<int>> cells;      // which to evaluate; nothing: all
  int num_threads = 1;                        // cells side by side
  const std::atomic<bool>* cancel = nullptr;  // may be null; true ends the scan with the cells that are done
  // After every cell that is done, never two at a time; `num_done` of `num_cells`, those of `cells`. May be empty.
  // What it throws ends the scan and is thrown on.
  std::function<void(int cell, const LandscapeCell& result, int num_done, int num_cells)> on_cell;

  // Throws `Error` (kUsage) where numbers do not fit each other, a parameter is held that is, or is part of, one on
  // an axis, or a recording is to correct rollouts that cannot.
  void Validate() const;
};

// Cells that were not evaluated are as `LandscapeCell` is made: no cost and no failure. Throws `Error` where `Validate`
// and `RecordingModel` do; a rollout that fails is a cell's failure.
Landscape ScanLandscape(const LandscapeScanOptions& options);

// Has the cells be of the cost of `fit`, which is of this recording: frames are weighed as there, and what is on no
// axis is held. Throws `Error` (kUsage), naming --result, where `Validate` does for what is held.
void FollowFit(const ScannedFit& fit, LandscapeScanOptions* options);

// Replaces what was measured in every one of `options->motions` by what the true parameters predict there, at its
// points and frames and in its contact mode; what was not seen stays unseen. `truth`: by parameter name; what is
// missing has the scene's nominal value. Those on no axis become `options->held`, so a cell with exactly the true
// parameters has the cost 0. Once cancelled, what is left stays as it was. Throws `Error`: kUsage where the truth is
// out of range (naming --set), kBadData where it cannot be simulated.
void MeasureTruth(const std::map<std::string, double>& truth, LandscapeScanOptions* options);

}  // namespace clothid

#endif  // CLOTHID_TOOLS_LANDSCAPE_LANDSCAPE_SCAN_H_
