// A whole fit as one call: recordings in, a folder of results out. The program `identify` is its command line.
//
//   RunOptions options;
//   options.target_paths = {"drape.motion.bin"};
//   options.fit.parameters = {"mu", "k_stretch"};
//   options.output = "/tmp/drape";
//   const RunResult result = Identify(options);
//   if (result.exit_code == kExitSuccess) Use(result.summary.values());
//
// What happens, in this order: the recordings are read and checked, frames are held out, the gradients compared, of
// repetitions each is fitted for itself, the fit is run, from one start or several, and where it chooses the time step,
// again with that, then the profiles, the fits with other steps and meshes and the prediction of what was held out,
// then the files are written, all or none (but see `WriteReport`).
#ifndef CLOTHID_IDENTIFY_RUN_H_
#define CLOTHID_IDENTIFY_RUN_H_

#include "identify/run_options.h"

namespace clothid {

// Throws `Error`: kUsage for what `Validate` rejects, for parameters that are not fitted or not known, and for an input
// that a result would replace; kIo and kBadData for files and for recordings in which a check finds a problem. Nothing
// is left behind then, nor where anything else is thrown: an internal error, or what a callback has thrown. How the fit
// itself ends never throws: see `exit_code`. The same on any number of threads but for the seconds.
RunResult Identify(const RunOptions& options);

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_RUN_H_
