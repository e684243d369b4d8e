// The flags of `benchmark`, as options of its commands.
#ifndef CLOTHID_TOOLS_BENCHMARK_FLAGS_H_
#define CLOTHID_TOOLS_BENCHMARK_FLAGS_H_

#include "tools/benchmark_accuracy.h"
#include "tools/benchmark_backprop.h"
#include "tools/benchmark_continuity.h"
#include "tools/benchmark_coverage.h"
#include "tools/benchmark_discretization.h"
#include "tools/benchmark_figure3.h"
#include "tools/benchmark_forward.h"
#include "tools/benchmark_jacobian.h"
#include "tools/benchmark_stability.h"
#include "tools/benchmark_thresholds.h"

namespace clothid {

// Each throws `Error` (kUsage), naming the flag, for text that is no number or list; what is out of range is left to
// the options' Validate().
JacobianBenchmarkOptions JacobianOptionsFromFlags();
DiscretizationOptions DiscretizationOptionsFromFlags();
CoverageOptions CoverageOptionsFromFlags();
ForwardBenchmarkOptions ForwardOptionsFromFlags();
BackpropOptions BackpropOptionsFromFlags();
ThresholdOptions ThresholdOptionsFromFlags();
AccuracyOptions AccuracyOptionsFromFlags();
ContinuityOptions ContinuityOptionsFromFlags();
Figure3Options Figure3OptionsFromFlags();
StabilityOptions StabilityOptionsFromFlags();

}  // namespace clothid

#endif  // CLOTHID_TOOLS_BENCHMARK_FLAGS_H_
