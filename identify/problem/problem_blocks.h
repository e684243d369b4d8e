// The parameter blocks of a fit: which parameters of which recordings are one.
#ifndef CLOTHID_IDENTIFY_PROBLEM_PROBLEM_BLOCKS_H_
#define CLOTHID_IDENTIFY_PROBLEM_PROBLEM_BLOCKS_H_

#include <string>
#include <vector>

#include "costs/prediction/parameter_block.h"
#include "datasets/motion/recorded_motion.h"
#include "identify/base/options.h"

namespace clothid {

// A block for every parameter of `options`, the levels of fields among them, which all recordings share that have it,
// or, of `FitOptions::each`, one per recording that has it. Starting values and bounds come from the first recording
// that has the parameter. Knots of the wind are linked to those before them (`FitOptions::wind_smoothness`). Throws
// `Error` for what `MakeParameterBlock` rejects, for overrides of parameters that are not fitted, priors among them,
// and where every parameter is frozen.
std::vector<ParameterBlock> MakeBlocks(const std::vector<RecordedMotion>& motions, const FitOptions& options);

// Makes every field that is to be fitted one of every scene: flat, at the starting value of its level, for which the
// first recording speaks. Throws `Error` (kUsage) where the scene does not have such a constant.
void SetFlatFields(const FitOptions& options, std::vector<RecordedMotion>* motions);

// Whether parameter `name`, with or without the suffix of a recording, exists in `scene`: all but `mu.NAME` always do.
bool HasParameter(const Scene& scene, const std::string& name);

// Whether `block` is a parameter of `motion`, which is recording number `recording`, counted from 0.
bool Concerns(const ParameterBlock& block, const RecordedMotion& motion, int recording);

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_PROBLEM_PROBLEM_BLOCKS_H_
