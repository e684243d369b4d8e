// The flags of `benchmark`, as options of its commands.
#ifndef CLOTHID_TOOLS_BENCHMARK_BENCHMARK_FLAGS_H_
#define CLOTHID_TOOLS_BENCHMARK_BENCHMARK_FLAGS_H_

#include "tools/benchmark/accuracy/benchmark_accuracy.h"
#include "tools/benchmark/derivatives/benchmark_backprop.h"
#include "tools/benchmark/steps/benchmark_forward.h"
#include "tools/benchmark/steps/benchmark_stability.h"

namespace clothid {

// Each throws `Error` (kUsage), naming the flag, for text that is no number or list; what is out of range is left to
// the options' Validate().
ForwardBenchmarkOptions ForwardOptionsFromFlags();
BackpropOptions BackpropOptionsFromFlags();
AccuracyOptions AccuracyOptionsFromFlags();
StabilityOptions StabilityOptionsFromFlags();

}  // namespace clothid

#endif  // CLOTHID_TOOLS_BENCHMARK_BENCHMARK_FLAGS_H_
