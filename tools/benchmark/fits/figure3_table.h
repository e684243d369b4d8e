// What `benchmark figure3` tells of its landscapes and fits.
#ifndef CLOTHID_TOOLS_BENCHMARK_FITS_FIGURE3_TABLE_H_
#define CLOTHID_TOOLS_BENCHMARK_FITS_FIGURE3_TABLE_H_

#include <string>

#include "tools/benchmark/fits/benchmark_figure3.h"
#include "tools/benchmark/fits/rank_correlation.h"

namespace clothid {

// Does roughness (off_quadratic) grow with the contact changes per rollout? Over the offsets in velocity mode with
// `touch`, in one window.
RankCorrelation RoughnessAgainstEvents(const Figure3& figure, double touch, int window);

// Per setting: contact events in the smallest zoom, roughness in all of them, fits that found the truth; then the rank
// correlations, and how much smoother gap mode is.
std::string Figure3Table(const Figure3& figure);
std::string Figure3Csv(const Figure3& figure);      // a row per window
std::string Figure3FitsCsv(const Figure3& figure);  // a row per fit

}  // namespace clothid

#endif  // CLOTHID_TOOLS_BENCHMARK_FITS_FIGURE3_TABLE_H_
