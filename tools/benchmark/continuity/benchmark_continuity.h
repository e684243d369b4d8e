// benchmark continuity: which parts of a contact law make the motion jump (section 5.1 and Figure 2 of the DiffCloth
// paper).
//
// A cloth on a sphere (tools/benchmark/continuity/sphere_slide.h), the sphere itself and triangulated ones, in two
// scans: over friction, 200 steps each (tools/benchmark/continuity/friction_scan.h), and one step along lines of start
// states (tools/benchmark/continuity/line_scan.h). Both are run again at half the distance between their points: a
// continuous function then has half the largest jump.
#ifndef CLOTHID_TOOLS_BENCHMARK_CONTINUITY_BENCHMARK_CONTINUITY_H_
#define CLOTHID_TOOLS_BENCHMARK_CONTINUITY_BENCHMARK_CONTINUITY_H_

#include <array>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "tools/benchmark/continuity/friction_scan.h"
#include "tools/benchmark/continuity/line_scan.h"

namespace clothid {

inline constexpr double kLargestFriction = 0.35;  // of the scan over friction, from 0

struct ContinuityOptions {
  int nodes = 9;                // along each axis, odd
  int num_cells = 512;          // steps of the scan over friction; it is also run with twice as many
  std::string contact = "gap";  // of the scan over friction; or velocity
  int num_lines = 8;
  std::uint64_t seed = 1;  // of the lines
  int num_threads = 1;     // rollouts, or lines, side by side; results do not depend on it
  // After every scan. May be empty.
  std::function<void(const std::string& scan, int num_done, int num_scans)> on_scan;

  // Throws `Error` (kUsage) naming the first flag out of range.
  void Validate() const;
};

// One curve v(mu).
struct CurveContinuity {
  double turning_friction = 0.0;  // see TurningFriction
  double coarse_jump = 0.0;       // the largest one of the scan, m/s
  double fine_jump = 0.0;         // and at half its step
  int num_jumps = 0;              // see CurveJumps

  double jump_ratio() const { return fine_jump / coarse_jump; }
  int num_segments() const { return num_jumps + 1; }
};

// The scan over friction on one surface.
struct SurfaceContinuity {
  std::string surface;
  std::vector<SlideSample> scan;  // at half the step
  std::array<CurveContinuity, kNumCurves> curves;
  std::array<double, kSlideNodeNames.size()> moving_friction;  // see LargestFrictionThatMoves
  RolloutCounts counts;                                        // of all rollouts
  int num_rollouts = 0;
  double seconds = 0.0;  // of all rollouts, processor time
};

// One step along lines, on one surface in one contact mode.
struct LineContinuity {
  std::string contact, surface;
  LineScan scan;
};

struct ContinuityBenchmark {
  ContinuityOptions options;
  std::vector<SurfaceContinuity> surfaces;  // as in kSlideSurfaces
  std::vector<LineContinuity> lines;        // gap mode first
};

// Throws `Error` for options that cannot be used. Steps that fail are counted.
ContinuityBenchmark RunContinuityBenchmark(const ContinuityOptions& options);

// What the scan `scan` on `slide` says, with rollouts of its own that look closer at jumps.
SurfaceContinuity AnalyzeSurface(const SlideSurface& surface, const SphereSlide& slide, std::vector<SlideSample> scan,
                                 int num_threads);

// Four tables: curves, rollouts, branches over friction, lines.
std::string ContinuityTable(const ContinuityBenchmark& benchmark);

// One row per surface and friction, which tools/plots/plot_continuity draws.
std::string ContinuityCsv(const ContinuityBenchmark& benchmark);

// One row per contact mode, surface and distance of points.
std::string ContinuityLinesCsv(const ContinuityBenchmark& benchmark);

}  // namespace clothid

#endif  // CLOTHID_TOOLS_BENCHMARK_CONTINUITY_BENCHMARK_CONTINUITY_H_
