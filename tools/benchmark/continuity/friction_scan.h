// Velocities of a cloth on a sphere as a function of friction, and whether they jump: the mu scan of Figure 2 of the
// DiffCloth paper.
//
// There are six curves v(mu): the velocity [3] of each of three nodes at steps 50 and 200. A scan has even steps of mu;
// its largest jump is the largest |v(mu_i+1) - v(mu_i)|, which halves with the step where v is continuous with a
// bounded slope, kinks included, and stays where v jumps.
#ifndef CLOTHID_TOOLS_BENCHMARK_CONTINUITY_FRICTION_SCAN_H_
#define CLOTHID_TOOLS_BENCHMARK_CONTINUITY_FRICTION_SCAN_H_

#include <Eigen/Core>
#include <array>
#include <vector>

#include "sim/rollout/rollout.h"
#include "tools/benchmark/continuity/sphere_slide.h"

namespace clothid {

inline constexpr std::array<int, 2> kWatchedSteps = {50, 200};  // 1-based: after so many steps

// Curve c is that of watched node c / 2 at step c % 2.
inline constexpr int kNumCurves = 6;

struct BranchNumbers {
  int stick = 0, slip = 0, free = 0;  // nodes
};

// One rollout. Depends on scene and friction alone, but for the seconds.
struct SlideSample {
  double friction_coefficient = 0.0;
  std::array<Eigen::Vector3d, kNumCurves> velocities;        // m/s; NaN where the rollout failed, as the speeds are
  std::array<double, kWatchedSteps.size()> largest_speed;    // of any node, m/s
  std::array<BranchNumbers, kWatchedSteps.size()> branches;  // zero where the rollout failed
  std::array<double, kSlideNodeNames.size()> displacement;   // of the watched nodes at the end, m
  RolloutCounts counts;
  double seconds = 0.0;  // processor time
};

// `slide` with one friction coefficient.
SlideSample SimulateSlide(const SphereSlide& slide, double friction_coefficient);

// num_cells + 1 rollouts, `num_threads` side by side, with even steps from `lower` to `upper`, both included.
std::vector<SlideSample> ScanFriction(const SphereSlide& slide, double lower, double upper, int num_cells,
                                      int num_threads);

// Over every `stride`-th sample. Neighbours of failed rollouts are left out.
double LargestJump(const std::vector<SlideSample>& scan, int curve, int stride);

// The largest |v| of the curve.
double LargestValue(const std::vector<SlideSample>& scan, int curve);

// The turning point of a curve: the largest mu at which the node moves, faster than kStillSpeed; NaN: at none.
double TurningFriction(const std::vector<SlideSample>& scan, int curve);
inline constexpr double kStillSpeed = 1e-6;  // m/s

// The largest mu at which a watched node has moved at the end by more than kStillDistance; NaN: at none.
double LargestFrictionThatMoves(const std::vector<SlideSample>& scan, int watched_node);
inline constexpr double kStillDistance = 1e-9;  // m

// The jumps of the curves, told from steep slopes by looking closer: a step of the scan over which v changes by more
// than kVisibleJump times the largest value of the curve is halved kJumpHalvings times, each time going on with the
// half that changes more. A jump is a change that is still as large then. Of several jumps within one step of the scan
// one counts.
struct CurveJumps {
  std::array<int, kNumCurves> num_jumps = {};
  RolloutCounts counts;  // of the rollouts that looked closer
  int num_rollouts = 0;
  double seconds = 0.0;
};
inline constexpr double kVisibleJump = 0.01;
inline constexpr int kJumpHalvings = 5;

CurveJumps FindJumps(const SphereSlide& slide, const std::vector<SlideSample>& scan, int num_threads);

}  // namespace clothid

#endif  // CLOTHID_TOOLS_BENCHMARK_CONTINUITY_FRICTION_SCAN_H_
