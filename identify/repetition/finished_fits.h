// Estimates of fits that are done, from the folders that they wrote: what a Slurm array fits, one recording a task, is
// judged by one call.
#ifndef CLOTHID_IDENTIFY_REPETITION_FINISHED_FITS_H_
#define CLOTHID_IDENTIFY_REPETITION_FINISHED_FITS_H_

#include <string>
#include <vector>

#include "identify/repetition/repetitions.h"

namespace clothid {

// The folders of fits that `paths` stand for, in their order: a folder with a result.json is one; of another one every
// sub-folder, but hidden ones, sorted by name. Throws `Error`: kIo for what is no folder or cannot be read, kBadData
// for one without any fit, and where sub-folders have no result.json, naming them: what is missing is not judged as if
// it had not been asked for.
std::vector<std::string> FindFinishedFits(const std::vector<std::string>& paths);

// Of folders with a result.json each. One that has not converged, or whose estimates must not be used (exit codes 3 and
// 6), says so in `why_not_used`. Throws `Error`: kIo where a result.json cannot be read; kBadData, naming file and key,
// where it is not one of this schema, of a fit that was interrupted, of recordings that were judged together, of
// another version of clothid than the first, or has no estimates, standard deviations and scales.
std::vector<SingleFit> ReadFinishedFits(const std::vector<std::string>& folders);

// The parameters to pool: those of `chosen`, or all where it is empty, without those of `own`, which every recording
// has for itself, knots of the wind and frozen ones. Both may have shift, turn and the like (`ExpandAlignmentNames`).
// Throws `Error` (kBadData, naming the folder and the key) where the fits have different parameters, or not one that is
// chosen.
std::vector<std::string> SharedParameters(const std::vector<SingleFit>& fits, const std::vector<std::string>& chosen,
                                          const std::vector<std::string>& own);

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_REPETITION_FINISHED_FITS_H_
