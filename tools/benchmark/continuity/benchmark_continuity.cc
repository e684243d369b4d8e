#include "tools/benchmark/continuity/benchmark_continuity.h"

#include <cmath>
#include <iomanip>
#include <iterator>
#include <limits>
#include <sstream>
#include <utility>

#include "sim/base/error.h"
#include "sim/base/text_file.h"
#include "tools/landscape/landscape_plan.h"

namespace clothid {
namespace {

constexpr int kMaxNodesPerAxis = 101;
constexpr int kMaxCells = 1000000;
constexpr int kLineCells = 64;  // of the coarsest scan of a line
constexpr int kLineHalvings = 3;
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

constexpr ContactMode kContactModes[] = {ContactMode::kGap, ContactMode::kVelocity};

void Require(bool condition, const std::string& message) {
  if (!condition) throw Error(ErrorKind::kUsage, message);
}

void Put(double value, int width, int digits, std::ostream& out) {
  out << std::setw(width) << std::fixed << std::setprecision(digits) << value << std::defaultfloat;
}

void PutScientific(double value, int width, std::ostream& out) {
  out << std::setw(width) << std::scientific << std::setprecision(1) << value << std::defaultfloat;
}

// NaN: none.
void PutFriction(double mu, int width, std::ostream& out) {
  if (std::isnan(mu)) {
    out << std::setw(width) << "-";
  } else {
    Put(mu, width, 4, out);
  }
}

void PutName(const std::string& name, int width, std::ostream& out) {
  out << std::left << std::setw(width) << name << std::right;
}

void WriteCurves(const ContinuityBenchmark& benchmark, std::ostream& out) {
  const ContinuityOptions& options = benchmark.options;
  out << options.nodes << " x " << options.nodes << " nodes, " << options.contact << " mode, mu from 0 to "
      << kLargestFriction << " in " << options.num_cells << " steps d and in " << 2 * options.num_cells << " of d/2\n"
      << "                                turning   moved    largest jump of v, m/s    jumps  continuous\n"
         "surface     node         step        mu   up to      at d    at d/2  ratio   > 1 %    segments\n";
  for (const SurfaceContinuity& surface : benchmark.surfaces) {
    for (int c = 0; c < kNumCurves; ++c) {
      const CurveContinuity& curve = surface.curves[c];
      PutName(surface.surface, 12, out);
      PutName(kSlideNodeNames[c / 2], 12, out);
      out << std::setw(5) << kWatchedSteps[c % 2];
      PutFriction(curve.turning_friction, 10, out);
      PutFriction(surface.moving_friction[c / 2], 8, out);
      Put(curve.coarse_jump, 10, 5, out);
      Put(curve.fine_jump, 10, 5, out);
      Put(curve.jump_ratio(), 7, 3, out);
      out << std::setw(8) << curve.num_jumps << std::setw(12) << curve.num_segments() << "\n";
    }
  }
}

void WriteRollouts(const ContinuityBenchmark& benchmark, std::ostream& out) {
  out << "\n                       failed  fallbacks  substeps  contact   fastest node at mu = " << kLargestFriction
      << ", m/s     ms per\n"
         "surface     rollouts    steps                       changes     step "
      << kWatchedSteps[0] << "        step " << kWatchedSteps[1] << "           rollout\n";
  for (const SurfaceContinuity& surface : benchmark.surfaces) {
    const RolloutCounts& counts = surface.counts;
    PutName(surface.surface, 12, out);
    out << std::setw(8) << surface.num_rollouts << std::setw(9) << counts.failed_steps << std::setw(11)
        << counts.fallbacks << std::setw(10) << counts.substeps << std::setw(9) << counts.contact_changes();
    PutScientific(surface.scan.back().largest_speed[0], 12, out);
    PutScientific(surface.scan.back().largest_speed[1], 16, out);
    Put(1e3 * surface.seconds / surface.num_rollouts, 18, 1, out);
    out << "\n";
  }
}

// Where along a scan the nodes are on which branch; NaN: nowhere.
struct BranchRanges {
  double all_free = kNaN, some_free = kNaN;    // the largest mu
  double some_stick = kNaN, all_stick = kNaN;  // the smallest mu; of the latter, of those from which on all stick
};

BranchRanges FindBranchRanges(const std::vector<SlideSample>& scan, std::size_t step) {
  BranchRanges ranges;
  for (const SlideSample& sample : scan) {
    if (sample.counts.failed_steps > 0) continue;
    const double mu = sample.friction_coefficient;
    const BranchNumbers& numbers = sample.branches[step];
    if (numbers.stick + numbers.slip == 0) ranges.all_free = mu;
    if (numbers.free > 0) ranges.some_free = mu;
    if (numbers.stick > 0 && std::isnan(ranges.some_stick)) ranges.some_stick = mu;
    if (numbers.slip + numbers.free > 0) {
      ranges.all_stick = kNaN;
    } else if (std::isnan(ranges.all_stick)) {
      ranges.all_stick = mu;
    }
  }
  return ranges;
}

void WriteBranches(const ContinuityBenchmark& benchmark, std::ostream& out) {
  out << "\n                    nodes, over mu: all are       some are  some stick  all stick\n"
         "surface      step        free up to     free up to        from       from\n";
  for (const SurfaceContinuity& surface : benchmark.surfaces) {
    for (std::size_t s = 0; s < kWatchedSteps.size(); ++s) {
      const BranchRanges ranges = FindBranchRanges(surface.scan, s);
      PutName(surface.surface, 12, out);
      out << std::setw(5) << kWatchedSteps[s];
      PutFriction(ranges.all_free, 18, out);
      PutFriction(ranges.some_free, 15, out);
      PutFriction(ranges.some_stick, 12, out);
      PutFriction(ranges.all_stick, 11, out);
      out << "\n";
    }
  }
}

void WriteLines(const ContinuityBenchmark& benchmark, std::ostream& out) {
  out << "\none step along " << benchmark.options.num_lines << " lines of start states, at " << kLineCells
      << " points and at twice as many, " << kLineHalvings << " times\n"
      << "                                 nodes that switch between   largest jump of v, m/s   ratio of v at each     "
         "ratio of x at each\n"
         "contact   surface      failed   stick-slip stick-free slip-free     first      last    halving              "
         "  halving\n";
  for (const LineContinuity& line : benchmark.lines) {
    const LineScan& scan = line.scan;
    PutName(line.contact, 10, out);
    PutName(line.surface, 12, out);
    out << std::setw(7) << scan.failed_steps << std::setw(13) << scan.stick_slip << std::setw(11) << scan.stick_free
        << std::setw(10) << scan.slip_free;
    Put(scan.velocity_jumps.front(), 10, 5, out);
    Put(scan.velocity_jumps.back(), 10, 5, out);
    for (const std::vector<double>* jumps : {&scan.velocity_jumps, &scan.position_jumps}) {
      out << "  ";
      for (std::size_t i = 1; i < jumps->size(); ++i) Put((*jumps)[i] / (*jumps)[i - 1], 7, 3, out);
    }
    out << "\n";
  }
}

}  // namespace

void ContinuityOptions::Validate() const {
  Require(nodes >= 3 && nodes <= kMaxNodesPerAxis && nodes % 2 == 1,
          "--nodes: expected one odd number from 3 to " + std::to_string(kMaxNodesPerAxis));
  Require(num_cells >= 1 && num_cells <= kMaxCells,
          "--cells: expected a number from 1 to " + std::to_string(kMaxCells));
  Require(contact == "gap" || contact == "velocity",
          "--contact: '" + Printable(contact) + "': expected gap or velocity");
  Require(num_lines >= 1, "--lines: expected a number >= 1");
  Require(num_threads >= 1, "--threads: expected a number >= 1");
}

SurfaceContinuity AnalyzeSurface(const SlideSurface& surface, const SphereSlide& slide, std::vector<SlideSample> scan,
                                 int num_threads) {
  SurfaceContinuity result;
  result.surface = surface.name;
  const CurveJumps jumps = FindJumps(slide, scan, num_threads);
  for (int c = 0; c < kNumCurves; ++c) {
    result.curves[c] = {TurningFriction(scan, c), LargestJump(scan, c, 2), LargestJump(scan, c, 1), jumps.num_jumps[c]};
  }
  for (std::size_t i = 0; i < result.moving_friction.size(); ++i) {
    result.moving_friction[i] = LargestFrictionThatMoves(scan, static_cast<int>(i));
  }
  result.counts = jumps.counts;
  result.seconds = jumps.seconds;
  for (const SlideSample& sample : scan) {
    result.counts += sample.counts;
    result.seconds += sample.seconds;
  }
  result.num_rollouts = jumps.num_rollouts + static_cast<int>(scan.size());
  result.scan = std::move(scan);
  return result;
}

ContinuityBenchmark RunContinuityBenchmark(const ContinuityOptions& options) {
  options.Validate();
  ContinuityBenchmark benchmark;
  benchmark.options = options;
  const int num_surfaces = static_cast<int>(kSlideSurfaces.size());
  const int num_scans = num_surfaces * (1 + static_cast<int>(std::size(kContactModes)));
  int num_done = 0;
  const auto report = [&](const std::string& scan) {
    if (options.on_scan) options.on_scan(scan, ++num_done, num_scans);
  };
  const ContactMode mode =
      options.contact == ContactModeName(ContactMode::kGap) ? ContactMode::kGap : ContactMode::kVelocity;
  for (const SlideSurface& surface : kSlideSurfaces) {
    const SphereSlide slide = MakeSphereSlide(surface, options.nodes, mode);
    benchmark.surfaces.push_back(AnalyzeSurface(
        surface, slide, ScanFriction(slide, 0.0, kLargestFriction, 2 * options.num_cells, options.num_threads),
        options.num_threads));
    report(surface.name + ", " + std::to_string(benchmark.surfaces.back().num_rollouts) + " rollouts");
  }
  const LineScanOptions line_options = {options.num_lines, kLineCells, kLineHalvings, options.seed,
                                        options.num_threads};
  for (const ContactMode line_mode : kContactModes) {
    const std::string contact = ContactModeName(line_mode);
    for (const SlideSurface& surface : kSlideSurfaces) {
      const SphereSlide slide = MakeSphereSlide(surface, options.nodes, line_mode);
      benchmark.lines.push_back({contact, surface.name, ScanLines(slide, line_options)});
      report(surface.name + ", " + contact + " mode, " + std::to_string(options.num_lines) + " lines");
    }
  }
  return benchmark;
}

std::string ContinuityTable(const ContinuityBenchmark& benchmark) {
  std::ostringstream out;
  WriteCurves(benchmark, out);
  WriteRollouts(benchmark, out);
  WriteBranches(benchmark, out);
  WriteLines(benchmark, out);
  return out.str();
}

std::string ContinuityCsv(const ContinuityBenchmark& benchmark) {
  std::ostringstream out;
  out << std::setprecision(std::numeric_limits<double>::max_digits10) << "surface,contact,mu";
  for (int c = 0; c < kNumCurves; ++c) {
    for (const char* component : {"_vx", "_vy", "_vz", "_speed"}) {
      out << "," << kSlideNodeNames[c / 2] << "_" << kWatchedSteps[c % 2] << component;
    }
  }
  for (const int step : kWatchedSteps) {
    for (const char* name : {"stick_", "slip_", "free_", "fastest_"}) out << "," << name << step;
  }
  for (const char* name : kSlideNodeNames) out << ",moved_" << name;
  out << ",contact_changes,failed_steps,substeps\n";
  for (const SurfaceContinuity& surface : benchmark.surfaces) {
    for (const SlideSample& sample : surface.scan) {
      out << surface.surface << "," << benchmark.options.contact << "," << sample.friction_coefficient;
      for (const Eigen::Vector3d& v : sample.velocities) {
        out << "," << v[0] << "," << v[1] << "," << v[2] << "," << v.norm();
      }
      for (std::size_t s = 0; s < kWatchedSteps.size(); ++s) {
        const BranchNumbers& numbers = sample.branches[s];
        out << "," << numbers.stick << "," << numbers.slip << "," << numbers.free << "," << sample.largest_speed[s];
      }
      for (const double displacement : sample.displacement) out << "," << displacement;
      out << "," << sample.counts.contact_changes() << "," << sample.counts.failed_steps << ","
          << sample.counts.substeps << "\n";
    }
  }
  return out.str();
}

std::string ContinuityLinesCsv(const ContinuityBenchmark& benchmark) {
  std::ostringstream out;
  out << std::setprecision(std::numeric_limits<double>::max_digits10)
      << "contact,surface,cells,position_jump_m,velocity_jump_m_per_s,stick_slip,stick_free,slip_free,steps,failed_"
         "steps,substeps\n";
  for (const LineContinuity& line : benchmark.lines) {
    const LineScan& scan = line.scan;
    for (std::size_t i = 0; i < scan.velocity_jumps.size(); ++i) {
      out << line.contact << "," << line.surface << "," << (kLineCells << i) << "," << scan.position_jumps[i] << ","
          << scan.velocity_jumps[i] << "," << scan.stick_slip << "," << scan.stick_free << "," << scan.slip_free << ","
          << scan.num_steps << "," << scan.failed_steps << "," << scan.substeps << "\n";
    }
  }
  return out.str();
}

}  // namespace clothid
