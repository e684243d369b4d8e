// One step as a function of the state that it starts from, along random lines: whether it jumps.
//
// Section 5.1 of the DiffCloth paper: with the contact set and the local frames held, (x_n+1, v_n+1) is a continuous
// function of (x_n, v_n), whichever branches of the contact law a step switches between. Here the function itself is
// scanned, (x_n, v_n) = (x, v) + a + s b for s from -1 to 1, the start (x, v) of a cloth on a sphere and random a and
// b: every node moves along the surface with all others and by itself off the surface, with a velocity of its own; all
// of the size at which nodes stick, slip and take off. The largest difference between successive values of s halves
// with their distance where the step is continuous.
#ifndef CLOTHID_TOOLS_BENCHMARK_CONTINUITY_LINE_SCAN_H_
#define CLOTHID_TOOLS_BENCHMARK_CONTINUITY_LINE_SCAN_H_

#include <cstdint>
#include <vector>

#include "tools/benchmark/continuity/sphere_slide.h"

namespace clothid {

struct LineScanOptions {
  int num_lines = 8;
  int num_cells = 64;    // of the coarsest scan of a line
  int num_halvings = 3;  // of the distance between its points
  std::uint64_t seed = 1;
  int num_threads = 1;  // lines side by side; results do not depend on it
};

// Over all lines.
struct LineScan {
  // The largest change of any node from one point to the next: of the coarsest scan, then after every halving.
  std::vector<double> position_jumps;  // m
  std::vector<double> velocity_jumps;  // m/s
  // Nodes that are on one branch at a point and on the other at the next one, of the finest scan.
  int stick_slip = 0, stick_free = 0, slip_free = 0;
  int num_steps = 0;
  int failed_steps = 0;
  int substeps = 0;  // of difficult steps, each of which is another function
};

// Steps are solved to a relative residual of 1e-12, or to what rounding allows where that is more.
LineScan ScanLines(const SphereSlide& slide, const LineScanOptions& options);

}  // namespace clothid

#endif  // CLOTHID_TOOLS_BENCHMARK_CONTINUITY_LINE_SCAN_H_
