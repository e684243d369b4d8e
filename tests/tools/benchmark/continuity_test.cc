// `benchmark continuity`: the motion of a cloth on a sphere depends continuously on friction and on the start of a
// step, through all branches of the contact law, in gap mode; on triangulated spheres, and in velocity mode, it jumps.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "tests/tools/tool_test.h"
#include "tools/benchmark/continuity/benchmark_continuity.h"
#include "tools/benchmark/continuity/icosphere.h"

namespace clothid {
namespace {

constexpr int kNodes = 5;

// Nearly halved, and not.
constexpr double kContinuous = 0.6;
constexpr double kJumps = 0.85;

SphereSlide MakeSlide(std::size_t surface, ContactMode mode = ContactMode::kGap) {
  return MakeSphereSlide(kSlideSurfaces[surface], kNodes, mode);
}

// Samples whose first curve is v(mu), the others still.
std::vector<SlideSample> MakeScan(int num_cells, double (*v)(double mu)) {
  std::vector<SlideSample> scan(num_cells + 1);
  for (int i = 0; i <= num_cells; ++i) {
    scan[i].friction_coefficient = static_cast<double>(i) / num_cells;
    scan[i].velocities.fill(Eigen::Vector3d::Zero());
    scan[i].velocities[0][1] = v(scan[i].friction_coefficient);
    scan[i].displacement.fill(0.0);
  }
  return scan;
}

double JumpRatio(const std::vector<SlideSample>& scan, int curve) {
  return LargestJump(scan, curve, 1) / LargestJump(scan, curve, 2);
}

TEST(IcosphereTest, IsAClosedSurfaceOnTheSphere) {
  for (int num_splits = 0; num_splits <= 3; ++num_splits) {
    const Mesh mesh = MakeIcosphere(num_splits);
    ValidateMesh(mesh, "icosphere");
    EXPECT_EQ(mesh.num_faces(), 20 << (2 * num_splits));
    // Euler's formula, with one and a half edges per triangle.
    EXPECT_EQ(mesh.num_nodes() - mesh.num_faces() / 2, 2);
    EXPECT_LE((mesh.rest_positions.colwise().norm().array() - 1.0).abs().maxCoeff(), 1e-15);
    double volume = 0.0;
    for (int f = 0; f < mesh.num_faces(); ++f) {
      const Eigen::Vector3d a = mesh.rest_positions.col(mesh.faces(0, f)),
                            b = mesh.rest_positions.col(mesh.faces(1, f)),
                            c = mesh.rest_positions.col(mesh.faces(2, f));
      EXPECT_GT(a.cross(b).dot(c), 0.0);  // outwards
      volume += a.cross(b).dot(c) / 6.0;
    }
    // Inscribed, and nearer to the sphere by a factor of four with every split.
    const double missing = 1.0 - volume / (4.0 / 3.0 * std::acos(-1.0));
    EXPECT_GT(missing, 0.3 / (1 << (2 * num_splits)));
    EXPECT_LT(missing, 0.6 / (1 << (2 * num_splits)));
  }
}

TEST(SphereSlideTest, EveryNodeStartsOnTheSurfaceAndMaySlipOrStick) {
  for (std::size_t s = 0; s < kSlideSurfaces.size(); ++s) {
    const SphereSlide slide = MakeSphereSlide(kSlideSurfaces[s], 9, ContactMode::kGap);
    const Obstacle& shape = *slide.scene.obstacles.front().shape;
    double largest_slope = 0.0, smallest_slope = 1.0;
    for (int node = 0; node < slide.scene.mesh.num_nodes(); ++node) {
      const SurfacePoint point = shape.Closest(slide.scene.initial_positions.segment<3>(3 * node));
      EXPECT_LE(std::abs(point.gap), 1e-15);
      const double slope = point.normal.head<2>().norm() / point.normal[2];
      largest_slope = std::max(largest_slope, slope);
      smallest_slope = std::min(smallest_slope, slope);
    }
    EXPECT_LT(largest_slope, kLargestFriction) << kSlideSurfaces[s].name;
    EXPECT_GT(smallest_slope, 0.0) << kSlideSurfaces[s].name;
    EXPECT_EQ(slide.scene.num_steps(), kWatchedSteps.back());
  }
}

TEST(FrictionScanTest, TellsKinksFromJumps) {
  const std::vector<SlideSample> kink = MakeScan(64, [](double mu) { return std::max(0.0, 0.3 - mu); });
  EXPECT_NEAR(JumpRatio(kink, 0), 0.5, 1e-12);
  EXPECT_EQ(LargestJump(kink, 1, 1), 0.0);
  EXPECT_EQ(LargestValue(kink, 0), 0.3);
  EXPECT_EQ(TurningFriction(kink, 0), 19.0 / 64.0);
  EXPECT_TRUE(std::isnan(TurningFriction(kink, 1)));
  EXPECT_TRUE(std::isnan(LargestFrictionThatMoves(kink, 0)));
  const std::vector<SlideSample> step = MakeScan(64, [](double mu) { return mu < 0.3 ? 1.0 : 0.0; });
  EXPECT_EQ(JumpRatio(step, 0), 1.0);
}

TEST(FrictionScanTest, AFailedRolloutIsNoJump) {
  std::vector<SlideSample> scan = MakeScan(4, [](double mu) { return mu; });
  scan[2].velocities[0].setConstant(std::nan(""));
  EXPECT_EQ(LargestJump(scan, 0, 1), 0.25);
  EXPECT_EQ(LargestValue(scan, 0), 1.0);
  EXPECT_EQ(TurningFriction(scan, 0), 1.0);
}

TEST(FrictionScanTest, OnTheSphereVelocitiesAreContinuousAndGoToZero) {
  const SphereSlide slide = MakeSlide(0);
  const SurfaceContinuity result =
      AnalyzeSurface(kSlideSurfaces[0], slide, ScanFriction(slide, 0.0, kLargestFriction, 64, 1), 1);
  EXPECT_EQ(result.counts.failed_steps, 0);
  EXPECT_EQ(result.counts.substeps, 0);
  EXPECT_GT(result.counts.branch_switches, 0);
  EXPECT_GT(result.counts.nodes_left, 0);
  for (int c = 0; c < kNumCurves; ++c) {
    EXPECT_LE(result.curves[c].jump_ratio(), kContinuous) << c;
    EXPECT_EQ(result.curves[c].num_jumps, 0) << c;
    EXPECT_GT(result.scan.front().velocities[c].norm(), 0.3) << c;
  }
  EXPECT_EQ(result.scan.front().branches[1].free, kNodes * kNodes);
  EXPECT_EQ(result.scan.back().branches[1].stick, kNodes * kNodes);
  for (const double speed : result.scan.back().largest_speed) EXPECT_LE(speed, 1e-12);
  // The corner lies lower than the other two, where the sphere is steeper.
  EXPECT_GT(result.moving_friction[0], result.moving_friction[1]);
  EXPECT_GT(result.moving_friction[0], result.moving_friction[2]);
}

// A window in which every node slips until it takes off: only edges of triangles are left to make it jump.
TEST(FrictionScanTest, OnTriangulatedSpheresVelocitiesJump) {
  for (std::size_t s = 0; s < kSlideSurfaces.size(); ++s) {
    const SphereSlide slide = MakeSlide(s);
    const SurfaceContinuity result =
        AnalyzeSurface(kSlideSurfaces[s], slide, ScanFriction(slide, 0.12, 0.13, 32, 1), 1);
    EXPECT_EQ(result.counts.failed_steps, 0);
    for (const int c : {1, 3, 5}) {  // near the end, when every node has crossed edges
      if (kSlideSurfaces[s].num_splits < 0) {
        EXPECT_LE(result.curves[c].jump_ratio(), kContinuous) << c;
        EXPECT_EQ(result.curves[c].num_segments(), 1) << c;
      } else {
        EXPECT_GE(result.curves[c].jump_ratio(), kJumps) << kSlideSurfaces[s].name << " " << c;
        EXPECT_GE(result.curves[c].num_segments(), 2) << kSlideSurfaces[s].name << " " << c;
      }
    }
  }
}

class LineScanTest : public testing::TestWithParam<std::pair<std::size_t, ContactMode>> {};

TEST_P(LineScanTest, TheLargestJumpHalvesOnTheSphereInGapModeAlone) {
  const auto [surface, mode] = GetParam();
  LineScanOptions options;
  options.num_lines = 3;
  const LineScan scan = ScanLines(MakeSlide(surface, mode), options);
  EXPECT_EQ(scan.num_steps, 3 * (8 * 64 + 1));
  EXPECT_EQ(scan.failed_steps, 0);
  EXPECT_EQ(scan.substeps, 0);
  EXPECT_GT(scan.stick_slip, 0);
  EXPECT_GT(scan.slip_free, 0);
  ASSERT_EQ(scan.velocity_jumps.size(), 4u);
  for (std::size_t i = 1; i < scan.velocity_jumps.size(); ++i) {
    const double of_positions = scan.position_jumps[i] / scan.position_jumps[i - 1];
    const double of_velocities = scan.velocity_jumps[i] / scan.velocity_jumps[i - 1];
    if (surface == 0 && mode == ContactMode::kGap) {
      EXPECT_LE(of_positions, kContinuous) << i;
      EXPECT_LE(of_velocities, kContinuous) << i;
    } else if (i + 1 == scan.velocity_jumps.size()) {  // once what is continuous has shrunk to less than the jumps
      EXPECT_GE(of_velocities, kJumps);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Surfaces, LineScanTest,
                         testing::Values(std::pair(0, ContactMode::kGap), std::pair(1, ContactMode::kGap),
                                         std::pair(2, ContactMode::kGap), std::pair(0, ContactMode::kVelocity)));

class ContinuityTest : public ToolTest {};

TEST_F(ContinuityTest, ResultsDoNotDependOnThreads) {
  ContinuityOptions options;
  options.nodes = 3;
  options.num_cells = 4;
  options.num_lines = 2;
  const ContinuityBenchmark one = RunContinuityBenchmark(options);
  options.num_threads = 2;
  const ContinuityBenchmark two = RunContinuityBenchmark(options);
  EXPECT_EQ(ContinuityCsv(two), ContinuityCsv(one));
  EXPECT_EQ(ContinuityLinesCsv(two), ContinuityLinesCsv(one));
}

TEST_F(ContinuityTest, PrintsTablesAndWritesEveryRollout) {
  const ToolResult result =
      Run("benchmark continuity --nodes 3 --cells 3 --contact velocity --lines 1 --seed 2 --output out");
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_NE(result.out.find("3 x 3 nodes, velocity mode, mu from 0 to 0.35 in 3 steps"), std::string::npos)
      << result.out;
  EXPECT_NE(result.out.find("\nfaces_1280  edge_centre   200"), std::string::npos) << result.out;
  EXPECT_NE(result.err.find("scan 9 of 9"), std::string::npos) << result.err;
  const std::string csv = ReadBytes(folder() / "out" / "continuity.csv");
  EXPECT_EQ(csv.rfind("surface,contact,mu,corner_50_vx,corner_50_vy,corner_50_vz,corner_50_speed,", 0), 0u) << csv;
  EXPECT_EQ(std::count(csv.begin(), csv.end(), '\n'), 1 + 3 * 7) << csv;
  EXPECT_NE(csv.find("\nfaces_320,velocity,"), std::string::npos) << csv;
  const std::string lines = ReadBytes(folder() / "out" / "continuity_lines.csv");
  EXPECT_EQ(std::count(lines.begin(), lines.end(), '\n'), 1 + 2 * 3 * 4) << lines;
}

TEST_F(ContinuityTest, RefusesWhatItCannotRun) {
  ExpectRefused("benchmark continuity --nodes 1", 1, "--nodes");
  ExpectRefused("benchmark continuity --nodes 8", 1, "--nodes: expected one odd number");
  ExpectRefused("benchmark continuity --nodes 5,9", 1, "--nodes");
  ExpectRefused("benchmark continuity --cells 0", 1, "--cells");
  ExpectRefused("benchmark continuity --contact both", 1, "--contact: 'both'");
  ExpectRefused("benchmark continuity --lines 0", 1, "--lines");
  ExpectRefused("benchmark continuity --threads 0", 1, "--threads");
}

}  // namespace
}  // namespace clothid
