#include "tools/benchmark/continuity/friction_scan.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "identify/base/parallel_for.h"
#include "sim/rollout/simulator.h"
#include "tools/benchmark/base/timing.h"

namespace clothid {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

// v of the curve changes from one sample to the other by so much, m/s; NaN where one of them failed.
double Change(const SlideSample& a, const SlideSample& b, int curve) {
  return (b.velocities[curve] - a.velocities[curve]).norm();
}

BranchNumbers CountBranches(const StepRecord& record) {
  BranchNumbers numbers;
  for (const ContactRecord& contact : record.contacts) {
    ++(contact.branch == ContactBranch::kStick ? numbers.stick : numbers.slip);
  }
  numbers.free = static_cast<int>(record.positions.size()) / 3 - numbers.stick - numbers.slip;
  return numbers;
}

void Observe(const SphereSlide& slide, const Rollout& rollout, SlideSample* sample) {
  for (std::size_t s = 0; s < kWatchedSteps.size(); ++s) {
    const StepRecord& record = rollout.records[rollout.last_record[kWatchedSteps[s] - 1]];
    const Eigen::Map<const Eigen::Matrix3Xd> velocities(record.velocities.data(), 3, record.velocities.size() / 3);
    sample->largest_speed[s] = velocities.colwise().norm().maxCoeff();
    sample->branches[s] = CountBranches(record);
    for (std::size_t i = 0; i < slide.watched_nodes.size(); ++i) {
      sample->velocities[2 * i + s] = velocities.col(slide.watched_nodes[i]);
    }
  }
  const Eigen::VectorXd displacements = rollout.records.back().positions - rollout.initial_positions;
  for (std::size_t i = 0; i < slide.watched_nodes.size(); ++i) {
    sample->displacement[i] = displacements.segment<3>(3 * slide.watched_nodes[i]).norm();
  }
}

// The largest mu of a scan at which `moves` holds.
template <typename Predicate>
double LargestFriction(const std::vector<SlideSample>& scan, const Predicate& moves) {
  const auto last = std::find_if(scan.rbegin(), scan.rend(), moves);
  return last == scan.rend() ? kNaN : last->friction_coefficient;
}

// One step of a scan, looked at more closely. Rollouts are shared between the curves.
class CloseUp {
 public:
  explicit CloseUp(const SphereSlide& slide) : slide_(slide) {}

  // Whether a change of more than `threshold` is left of that from `lower` to `upper`.
  bool HasJump(const SlideSample& lower, const SlideSample& upper, int curve, double threshold) {
    const SlideSample *a = &lower, *b = &upper;
    for (int halving = 0; halving < kJumpHalvings; ++halving) {
      if (!(Change(*a, *b, curve) > threshold)) return false;
      const SlideSample& middle = At(0.5 * (a->friction_coefficient + b->friction_coefficient));
      const bool first_half = Change(*a, middle, curve) > Change(middle, *b, curve);
      (first_half ? b : a) = &middle;
    }
    return Change(*a, *b, curve) > threshold;
  }

  const std::map<double, SlideSample>& samples() const { return samples_; }

 private:
  const SlideSample& At(double friction_coefficient) {
    const auto [entry, is_new] = samples_.try_emplace(friction_coefficient);
    if (is_new) entry->second = SimulateSlide(slide_, friction_coefficient);
    return entry->second;
  }

  const SphereSlide& slide_;
  std::map<double, SlideSample> samples_;  // by mu
};

}  // namespace

SlideSample SimulateSlide(const SphereSlide& slide, double friction_coefficient) {
  SlideSample sample;
  sample.friction_coefficient = friction_coefficient;
  sample.velocities.fill(Eigen::Vector3d::Constant(kNaN));
  sample.largest_speed.fill(kNaN);
  sample.displacement.fill(kNaN);
  Simulator simulator(slide.scene);
  Parameters parameters = slide.scene.nominal_parameters();
  parameters.friction_coefficients = {friction_coefficient};
  const double start = ThreadSeconds();
  const Rollout rollout = Simulate(parameters, slide.scene.num_steps(), &simulator);
  sample.seconds = ThreadSeconds() - start;
  sample.counts = rollout.counts;
  if (rollout.ok()) Observe(slide, rollout, &sample);
  return sample;
}

std::vector<SlideSample> ScanFriction(const SphereSlide& slide, double lower, double upper, int num_cells,
                                      int num_threads) {
  std::vector<SlideSample> scan(num_cells + 1);
  ParallelFor(num_cells + 1, num_threads,
              [&](int i) { scan[i] = SimulateSlide(slide, lower + (upper - lower) * i / num_cells); });
  return scan;
}

double LargestJump(const std::vector<SlideSample>& scan, int curve, int stride) {
  double largest = 0.0;
  for (std::size_t i = stride; i < scan.size(); i += stride) {
    const double change = Change(scan[i - stride], scan[i], curve);
    if (change > largest) largest = change;
  }
  return largest;
}

double LargestValue(const std::vector<SlideSample>& scan, int curve) {
  double largest = 0.0;
  for (const SlideSample& sample : scan) {
    const double value = sample.velocities[curve].norm();
    if (value > largest) largest = value;
  }
  return largest;
}

double TurningFriction(const std::vector<SlideSample>& scan, int curve) {
  return LargestFriction(scan,
                         [&](const SlideSample& sample) { return sample.velocities[curve].norm() > kStillSpeed; });
}

double LargestFrictionThatMoves(const std::vector<SlideSample>& scan, int watched_node) {
  return LargestFriction(scan,
                         [&](const SlideSample& sample) { return sample.displacement[watched_node] > kStillDistance; });
}

CurveJumps FindJumps(const SphereSlide& slide, const std::vector<SlideSample>& scan, int num_threads) {
  std::array<double, kNumCurves> thresholds;
  for (int curve = 0; curve < kNumCurves; ++curve) thresholds[curve] = kVisibleJump * LargestValue(scan, curve);
  const int num_intervals = static_cast<int>(scan.size()) - 1;
  std::vector<CurveJumps> found(num_intervals);
  ParallelFor(num_intervals, num_threads, [&](int i) {
    CloseUp close_up(slide);
    for (int curve = 0; curve < kNumCurves; ++curve) {
      found[i].num_jumps[curve] = close_up.HasJump(scan[i], scan[i + 1], curve, thresholds[curve]);
    }
    for (const auto& [friction_coefficient, sample] : close_up.samples()) {
      found[i].counts += sample.counts;
      found[i].seconds += sample.seconds;
      ++found[i].num_rollouts;
    }
  });
  CurveJumps all;
  for (const CurveJumps& jumps : found) {
    for (int curve = 0; curve < kNumCurves; ++curve) all.num_jumps[curve] += jumps.num_jumps[curve];
    all.counts += jumps.counts;
    all.seconds += jumps.seconds;
    all.num_rollouts += jumps.num_rollouts;
  }
  return all;
}

}  // namespace clothid
