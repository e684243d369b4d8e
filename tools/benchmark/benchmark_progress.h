// What a benchmark under way tells on stderr, and where a signal ends it.
#ifndef CLOTHID_TOOLS_BENCHMARK_BENCHMARK_PROGRESS_H_
#define CLOTHID_TOOLS_BENCHMARK_BENCHMARK_PROGRESS_H_

#include "tools/benchmark/accuracy/benchmark_accuracy.h"
#include "tools/benchmark/derivatives/benchmark_backprop.h"
#include "tools/benchmark/derivatives/benchmark_jacobian.h"
#include "tools/benchmark/fits/benchmark_coverage.h"
#include "tools/benchmark/fits/benchmark_fields.h"
#include "tools/benchmark/steps/benchmark_forward.h"
#include "tools/benchmark/steps/benchmark_stability.h"

namespace clothid {

// Thrown out of a benchmark after a signal: it ends with the item that it is at.
struct Interrupted {};

// Have the benchmark print a line per item, how many are done and how long the rest takes where items are of a size.
// The callbacks throw `Interrupted`.
void ReportProgress(JacobianBenchmarkOptions* options);
void ReportProgress(CoverageOptions* options);
void ReportProgress(ForwardBenchmarkOptions* options);
void ReportProgress(BackpropOptions* options);
void ReportProgress(AccuracyOptions* options);
void ReportProgress(FieldsOptions* options);
void ReportProgress(StabilityOptions* options);

}  // namespace clothid

#endif  // CLOTHID_TOOLS_BENCHMARK_BENCHMARK_PROGRESS_H_
