// Repetitions in words.
#ifndef CLOTHID_IDENTIFY_VERDICT_REPETITION_TEXT_H_
#define CLOTHID_IDENTIFY_VERDICT_REPETITION_TEXT_H_

#include <string>

#include "identify/repetition/repetitions.h"

namespace clothid {

// The line of the verdict: whether the recordings differ in `parameter` by more than their intervals say and by how
// much, its mean, and the next specimen; or that too few recordings tell it.
std::string RepetitionLine(const PooledParameter& parameter);

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_VERDICT_REPETITION_TEXT_H_
