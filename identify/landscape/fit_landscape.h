// A landscape of the cost beside a fit of the same recording, for a report: what the program `landscape` scanned.
#ifndef CLOTHID_IDENTIFY_LANDSCAPE_FIT_LANDSCAPE_H_
#define CLOTHID_IDENTIFY_LANDSCAPE_FIT_LANDSCAPE_H_

#include <limits>
#include <string>
#include <vector>

#include "costs/prediction/parameter_block.h"
#include "datasets/motion/recorded_motion.h"
#include "identify/landscape/landscape.h"

namespace clothid {

// One of both axes as a parameter of the fit.
struct LandscapeParameter {
  int index = -1;        // among the parameters of the fit
  ParameterBlock block;  // the same
};

struct FitLandscape {
  std::string folder;            // for messages
  int recording = 0;             // the fitted one that was scanned, counted from 0
  Landscape landscape;           // one setting: the scene as it is, in the contact mode of the fit; all windows
  int num_other_settings = 0;    // left out
  bool has_other_sigma = false;  // than the fit
  ScannedFit fit;                // whose cost was scanned; holds and weighs nothing: of none
  // m: rmse of a cell = this sqrt(cost). NaN where the cost does not tell the rmse: points differ in sigma, frames in
  // weight, or the scan does not say what it had.
  double rmse_of_root_cost = std::numeric_limits<double>::quiet_NaN();
  LandscapeParameter x, y;          // by `MatchLandscape`
  std::vector<std::string> others;  // fitted as well, but held in all cells; by `MatchLandscape`
};

// The landscape in a folder, of one of `motions`, which must be as they were read: nothing held out yet. Throws
// `Error`: where `ReadWholeLandscape` does; kIo where the folder holds no landscape; kUsage where it is of none of
// these recordings, of motion that was simulated (`landscape --set`), or of other scenes or contact modes alone.
FitLandscape ReadFitLandscape(const std::string& folder, const std::vector<RecordedMotion>& motions);

// Finds both axes among the parameters of a fit. Throws `Error` (kUsage), naming the folder, where one is not fitted.
void MatchLandscape(const std::vector<ParameterBlock>& blocks, FitLandscape* landscape);

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_LANDSCAPE_FIT_LANDSCAPE_H_
