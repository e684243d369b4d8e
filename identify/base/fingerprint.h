// What journals belong to.
#ifndef CLOTHID_IDENTIFY_BASE_FINGERPRINT_H_
#define CLOTHID_IDENTIFY_BASE_FINGERPRINT_H_

#include <ostream>
#include <string>
#include <vector>

#include "costs/prediction/parameter_block.h"
#include "datasets/motion/recorded_motion.h"
#include "identify/base/options.h"

namespace clothid {

// Writes the program and its version, and a recording with its scene as it is simulated: the file decides, and what was
// made of it, as a scene's text names further files and flags change the scene. Numbers exactly.
void DescribeProgram(std::ostream* text);
void DescribeMotion(const RecordedMotion& motion, std::ostream* text);

// The SHA-256 of everything that determines the evaluations of a fit: the program, the recordings with their scenes as
// they are simulated, the parameters, and the options of the optimiser. Not the number of threads, which changes
// nothing.
std::string FitFingerprint(const std::vector<RecordedMotion>& motions, const std::vector<ParameterBlock>& blocks,
                           const FitOptions& options);

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_BASE_FINGERPRINT_H_
