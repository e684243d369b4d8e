// What `benchmark --help` prints.
#ifndef CLOTHID_TOOLS_BENCHMARK_BENCHMARK_HELP_H_
#define CLOTHID_TOOLS_BENCHMARK_BENCHMARK_HELP_H_

namespace clothid {

extern const char kBenchmarkHelp[];

}  // namespace clothid

#endif  // CLOTHID_TOOLS_BENCHMARK_BENCHMARK_HELP_H_
