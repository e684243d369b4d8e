// The part of check_handles.h that is about forces.
#include <algorithm>
#include <cmath>

#include "datasets/checking/check_handles.h"
#include "datasets/checking/finding_words.h"
#include "sim/mesh/mesh.h"
#include "sim/scene/pieces.h"

namespace clothid {
namespace {

constexpr double kOtherSign = 0.5;     // of the weight: a mean force along gravity from here on has the wrong sign
constexpr double kOffset = 0.5;        // of the weight: from here a mean force is not what holds the cloth
constexpr double kOffsetSigmas = 4.0;  // and so many standard deviations
constexpr int kFewestReadings = 3;

const char* const kAxisNames[] = {"x", "y", "z"};

std::string Newtons(double force) { return Rounded(force) + " N"; }

// The mean of what was measured of every component [3G]; NaN where nothing was.
Eigen::VectorXd Means(const ForceReadings& forces) {
  Eigen::VectorXd means(forces.values.rows());
  for (Eigen::Index row = 0; row < means.size(); ++row) {
    double sum = 0.0, count = 0.0;
    for (const double force : forces.values.row(row)) {
      if (std::isnan(force)) continue;
      sum += force;
      count += 1.0;
    }
    means[row] = sum / count;
  }
  return means;
}

Finding Summary(const RecordedMotion& motion) {
  const ForceReadings& forces = motion.forces;
  double largest = 0.0;
  for (const double force : forces.values.reshaped()) {
    if (std::isfinite(force)) largest = std::max(largest, std::abs(force));
  }
  Finding finding;
  finding.what = "forces";
  finding.value = std::to_string(forces.num_readings()) + " readings at " + std::to_string(forces.num_groups()) +
                  (forces.num_groups() == 1 ? " group" : " groups") + " of handles, at most " + Newtons(largest) +
                  ", sigma " + Newtons(forces.sigma.maxCoeff());
  return finding;
}

std::vector<Finding> CheckForceTimes(const RecordedMotion& motion) {
  const double first = motion.times[0], last = motion.times[motion.num_frames() - 1];
  const auto is_outside = [&](double time) { return time < first || time > last; };
  const auto count = std::count_if(motion.forces.times.begin(), motion.forces.times.end(), is_outside);
  if (count == 0) return {};
  Finding finding;
  finding.what = "force times";
  finding.severity = Severity::kWarning;
  finding.value = std::to_string(count) + " of " + std::to_string(motion.forces.num_readings()) +
                  " readings lie before the first or after the last frame";
  finding.hint = "clock of the sensor: motion convert --force_time_offset";
  return {finding};
}

std::vector<Finding> CheckConstant(const RecordedMotion& motion) {
  const ForceReadings& forces = motion.forces;
  std::string constant;
  for (Eigen::Index row = 0; row < forces.values.rows(); ++row) {
    std::vector<double> measured;
    for (const double force : forces.values.row(row)) {
      if (!std::isnan(force)) measured.push_back(force);
    }
    if (static_cast<int>(measured.size()) < kFewestReadings) continue;
    const auto [least, most] = std::minmax_element(measured.begin(), measured.end());
    if (*least != *most) continue;
    constant += (constant.empty() ? "" : ", ") + std::string(kAxisNames[row % 3]) +
                (forces.num_groups() > 1 ? " of group " + std::to_string(row / 3 + 1) : "");
  }
  if (constant.empty()) return {};
  Finding finding;
  finding.what = "constant force";
  finding.severity = Severity::kWarning;
  finding.value = constant + " never changes, not even by noise";
  finding.hint = "a component that was not measured is nan, not 0";
  return {finding};
}

// What all handles bear of the cloth at rest, upwards, N; 0: the scene does not tell.
double Weight(const Scene& scene) {
  if (!scene.obstacles.empty() || !scene.node_force.isZero(0.0)) return 0.0;
  return MeanMaterial(scene.nominal_parameters(), scene.mesh).density * NodeAreas(scene.mesh).sum() *
         scene.gravity.norm();
}

// Against the weight that the handles bear on the mean over the recording, where they have a force each.
std::vector<Finding> CheckWeight(const RecordedMotion& motion) {
  const ForceReadings& forces = motion.forces;
  const double weight = Weight(motion.scene);
  const Eigen::VectorXd means = Means(forces);
  std::size_t num_nodes = motion.scene.handles.nodes.size();
  for (const std::vector<int>& group : forces.groups) num_nodes -= group.size();
  const bool has_all = forces.groups.empty() || num_nodes == 0;
  if (!(weight > 0.0) || !has_all || means.hasNaN() || forces.num_readings() < kFewestReadings) return {};
  const Eigen::Vector3d sum = means.reshaped(3, forces.num_groups()).rowwise().sum();
  const double upwards = -sum.dot(motion.scene.gravity.normalized());
  const double noise = kOffsetSigmas * forces.sigma.norm() / std::sqrt(1.0 * forces.num_readings());
  Finding finding;
  finding.what = "weight at the handles";
  finding.value = Newtons(upwards) + " upwards on the mean; the cloth of the scene weighs " + Newtons(weight);
  if (upwards < -kOtherSign * weight - noise) {
    finding.severity = Severity::kWarning;
    finding.hint = "a force is that on the cloth, not on the gripper: motion convert --force_scale -1";
  } else if (std::abs(upwards - weight) > kOffset * weight + noise) {
    finding.severity = Severity::kNote;
    finding.hint =
        "the sensor is off at zero, or was zeroed with the cloth: identify --fit ..,force_bias; or the "
        "density of the scene is off";
  }
  return {finding};
}

}  // namespace

std::vector<Finding> CheckForces(const CheckedMotion& checked) {
  const RecordedMotion& motion = checked.motion;
  if (motion.forces.is_empty()) return {};
  std::vector<Finding> findings = {Summary(motion)};
  for (const std::vector<Finding>& more : {CheckForceTimes(motion), CheckConstant(motion), CheckWeight(motion)}) {
    findings.insert(findings.end(), more.begin(), more.end());
  }
  return findings;
}

}  // namespace clothid
