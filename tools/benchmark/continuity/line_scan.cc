#include "tools/benchmark/continuity/line_scan.h"

#include <Eigen/Core>
#include <algorithm>
#include <random>
#include <utility>
#include <vector>

#include "identify/base/parallel_for.h"
#include "sim/rollout/segment.h"
#include "sim/rollout/simulator.h"

namespace clothid {
namespace {

constexpr double kStepTolerance = 1e-12;
constexpr double kFriction = 0.35;      // the largest of the scan over friction
constexpr double kSlideLength = 0.005;  // m, standard deviation along either axis of the shift that nodes share

// Where a step leads.
struct StepEnd {
  bool ok = false;
  StepState state;
  std::vector<ContactBranch> branches;  // [N]
};

// Velocities of the size that gravity gives in a step, positions off the surface of the size that it moves a node by.
StepState RandomDirection(const Scene& scene, std::mt19937_64* generator) {
  std::normal_distribution<double> normal;
  const double speed = scene.time_step * scene.gravity.norm();
  const auto random_vector = [&] {
    const double x = normal(*generator), y = normal(*generator), z = normal(*generator);
    return Eigen::Vector3d(x, y, z);
  };
  const Eigen::Vector3d shift = kSlideLength * random_vector();
  StepState direction{Eigen::VectorXd(scene.initial_positions.size()), Eigen::VectorXd(scene.initial_positions.size())};
  for (int node = 0; node < scene.mesh.num_nodes(); ++node) {
    const Eigen::Vector3d n =
        scene.obstacles.front().shape->Closest(scene.initial_positions.segment<3>(3 * node)).normal;
    const double lift = scene.time_step * speed * normal(*generator);
    direction.positions.segment<3>(3 * node) = shift - n.dot(shift) * n + lift * n;
    direction.velocities.segment<3>(3 * node) = speed * random_vector();
  }
  return direction;
}

double LargestChange(const Eigen::VectorXd& a, const Eigen::VectorXd& b) {
  const Eigen::VectorXd change = b - a;
  return Eigen::Map<const Eigen::Matrix3Xd>(change.data(), 3, change.size() / 3).colwise().norm().maxCoeff();
}

class LineScanner {
 public:
  LineScanner(const SphereSlide& slide, const LineScanOptions& options, int line)
      : simulator_(slide.scene), parameters_(slide.scene.nominal_parameters()), options_(options) {
    parameters_.friction_coefficients = {kFriction};
    std::seed_seq sequence{static_cast<std::uint32_t>(options.seed), static_cast<std::uint32_t>(options.seed >> 32),
                           static_cast<std::uint32_t>(line)};
    std::mt19937_64 generator(sequence);
    origin_ = RandomDirection(slide.scene, &generator);
    origin_.positions += slide.scene.initial_positions;
    origin_.velocities += slide.scene.initial_velocities;
    direction_ = RandomDirection(slide.scene, &generator);
  }

  LineScan Scan() {
    const int num_cells = options_.num_cells << options_.num_halvings;
    std::vector<StepEnd> ends;
    for (int i = 0; i <= num_cells; ++i) ends.push_back(StepFrom(2.0 * i / num_cells - 1.0));
    for (int halving = 0; halving <= options_.num_halvings; ++halving) {
      AddLargestJumps(ends, 1 << (options_.num_halvings - halving));
    }
    for (int i = 0; i < num_cells; ++i) CountSwitches(ends[i], ends[i + 1]);
    return result_;
  }

 private:
  StepEnd StepFrom(double s) {
    StepEnd end;
    Segment one_step;
    one_step.step_tolerance = kStepTolerance;
    StepState state{origin_.positions + s * direction_.positions, origin_.velocities + s * direction_.velocities};
    const SegmentOutcome outcome = AdvanceSegment(
        parameters_, one_step,
        [&](int, std::vector<StepRecord> records) {
          const StepRecord& record = records.back();
          end.branches.assign(record.positions.size() / 3, ContactBranch::kTakeOff);
          for (const ContactRecord& contact : record.contacts) end.branches[contact.node] = contact.branch;
        },
        &simulator_, &state);
    end.ok = outcome.ok();
    end.state = std::move(state);
    ++result_.num_steps;
    result_.failed_steps += outcome.counts.failed_steps;
    result_.substeps += outcome.counts.substeps;
    return end;
  }

  void AddLargestJumps(const std::vector<StepEnd>& ends, int stride) {
    double position_jump = 0.0, velocity_jump = 0.0;
    for (std::size_t i = stride; i < ends.size(); i += stride) {
      const StepEnd &a = ends[i - stride], &b = ends[i];
      if (!a.ok || !b.ok) continue;
      position_jump = std::max(position_jump, LargestChange(a.state.positions, b.state.positions));
      velocity_jump = std::max(velocity_jump, LargestChange(a.state.velocities, b.state.velocities));
    }
    result_.position_jumps.push_back(position_jump);
    result_.velocity_jumps.push_back(velocity_jump);
  }

  void CountSwitches(const StepEnd& a, const StepEnd& b) {
    if (!a.ok || !b.ok) return;
    for (std::size_t i = 0; i < a.branches.size(); ++i) {
      if (a.branches[i] == b.branches[i]) continue;
      const auto is_between = [&](ContactBranch one, ContactBranch other) {
        return (a.branches[i] == one && b.branches[i] == other) || (a.branches[i] == other && b.branches[i] == one);
      };
      result_.stick_slip += is_between(ContactBranch::kStick, ContactBranch::kSlip);
      result_.stick_free += is_between(ContactBranch::kStick, ContactBranch::kTakeOff);
      result_.slip_free += is_between(ContactBranch::kSlip, ContactBranch::kTakeOff);
    }
  }

  Simulator simulator_;
  Parameters parameters_;
  const LineScanOptions& options_;
  StepState origin_, direction_;  // a state, and a difference of two
  LineScan result_;
};

}  // namespace

LineScan ScanLines(const SphereSlide& slide, const LineScanOptions& options) {
  std::vector<LineScan> lines(options.num_lines);
  ParallelFor(options.num_lines, options.num_threads,
              [&](int line) { lines[line] = LineScanner(slide, options, line).Scan(); });
  LineScan all;
  all.position_jumps.assign(options.num_halvings + 1, 0.0);
  all.velocity_jumps = all.position_jumps;
  for (const LineScan& line : lines) {
    for (int i = 0; i <= options.num_halvings; ++i) {
      all.position_jumps[i] = std::max(all.position_jumps[i], line.position_jumps[i]);
      all.velocity_jumps[i] = std::max(all.velocity_jumps[i], line.velocity_jumps[i]);
    }
    all.stick_slip += line.stick_slip;
    all.stick_free += line.stick_free;
    all.slip_free += line.slip_free;
    all.num_steps += line.num_steps;
    all.failed_steps += line.failed_steps;
    all.substeps += line.substeps;
  }
  return all;
}

}  // namespace clothid
