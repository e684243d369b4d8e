// What a run does beside its joint fit, or in place of it, where its recordings are repetitions of one experiment
// (`RunOptions::repeat`), or predict each other (`RunOptions::transfer`).
#ifndef CLOTHID_IDENTIFY_REPEATED_RUN_H_
#define CLOTHID_IDENTIFY_REPEATED_RUN_H_

#include <functional>
#include <string>
#include <vector>

#include "identify/prediction/transfer.h"
#include "identify/repetition/repetitions.h"
#include "identify/run_options.h"

namespace clothid {

// `Identify` (identify/run.h), which this is a part of.
using RunCall = std::function<RunResult(const RunOptions& options)>;

// What fits of every recording for itself have found.
struct EachFit {
  std::vector<SingleFit> fits;
  Transfer transfer;  // with `RunOptions::transfer`
};

// Fits every recording of `options` for itself, as a run of its own would that writes nothing: side by side on
// `FitOptions::num_threads`, each on one. Parameters that a recording does not have are left out of its fit, of bounds
// and the like "drag@2" counts for the second recording alone. Nothing is looked at beside these fits but what counts
// in their intervals, and `RunOptions::resume` does not keep them: a resumed run fits them again. With
// `RunOptions::transfer` each predicts the others. Empty where `cancel` ended it. Throws `Error` where `identify` does
// for one of them.
EachFit FitEach(const RunOptions& options, const RunCall& identify);

// The estimates of a run of one recording.
SingleFit DescribeSingleFit(const std::string& name, const std::string& sha256, const RunResult& result);

// The parameters that all recordings of a joint fit share, but frozen ones and knots of the wind.
std::vector<std::string> SharedParameters(const FitSummary& summary);

// Pools finished fits, whose folders are `RunOptions::target_paths` (identify/repetition/finished_fits.h), and writes
// result.json, report.html and exports. `FitOptions::parameters` chooses what is pooled, `FitOptions::each` leaves out.
// `RunResult::summary` has the means as its estimates, and nothing else of a fit. Throws `Error` as `Identify`.
RunResult JudgeFinishedFits(const RunOptions& options);

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_REPEATED_RUN_H_
