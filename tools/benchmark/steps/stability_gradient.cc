#include "tools/benchmark/steps/stability_gradient.h"

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <random>
#include <stdexcept>
#include <utility>

#include "sim/derivative/adjoint.h"
#include "sim/rollout/simulator.h"

namespace clothid {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kTolerance = 1e-12;  // of steps and of the adjoint's linear solves
constexpr int kMaxSteps = 60;         // of the rollouts
constexpr std::array<double, 6> kSteps = {1e-8, 1e-7, 1e-6, 1e-5, 1e-4, 1e-3};  // e
constexpr double kSettled = 1e-5;                                               // good enough to stop looking
constexpr double kLargestSettled = 1e-4;  // of a derivative that counts as checked
constexpr double kNegligible = 1e-13;     // derivatives that are rounding, relative to what |w_s . x_s| may be
constexpr double kSmallestShare = 1e-3;   // of the gradient that a component's error is relative to

// C of a rollout, and what makes its gradient.
class RandomFunctional {
 public:
  RandomFunctional(int num_steps, Eigen::Index size, std::uint64_t seed) {
    std::mt19937_64 generator(seed);
    std::uniform_real_distribution<double> uniform(-1.0, 1.0);
    for (int third = 1; third <= 3; ++third) {
      steps_[third - 1] = std::max(1, num_steps * third / 3);
      weights_[third - 1] = Eigen::VectorXd::NullaryExpr(size, [&] { return uniform(generator); });
    }
  }

  // Of the differences of positions, which loses less to rounding than the difference of two sums.
  double Difference(const Rollout& a, const Rollout& b) const {
    double sum = 0.0;
    for (int i = 0; i < 3; ++i) sum += weights_[i].dot(a.positions(steps_[i]) - b.positions(steps_[i]));
    return sum;
  }

  // sum of |w_s| |x_s|, the sum of the absolute products at the most.
  double Size(const Rollout& rollout) const {
    double sum = 0.0;
    for (int i = 0; i < 3; ++i) sum += weights_[i].norm() * rollout.positions(steps_[i]).norm();
    return sum;
  }

  void AddGradient(int step, Eigen::MatrixXd* gradient) const {
    for (int i = 0; i < 3; ++i) {
      if (steps_[i] == step) gradient->col(0) += weights_[i];
    }
  }

 private:
  std::array<int, 3> steps_;
  std::array<Eigen::VectorXd, 3> weights_;  // [3N]
};

// One Newton iteration per solve beyond `rollout`, which makes up for its tolerance.
Rollout Refine(const Rollout& rollout, Simulator* simulator) {
  RolloutOptions options;
  options.followed = &rollout;
  return Simulate(rollout.parameters, rollout.num_steps(), simulator, nullptr, options);
}

// Whether both took the same substeps.
bool SameSolves(const Rollout& a, const Rollout& b) {
  return std::equal(a.records.begin(), a.records.end(), b.records.begin(), b.records.end(),
                    [](const StepRecord& c, const StepRecord& d) { return c.time_step == d.time_step; });
}

bool SameBranches(const Rollout& a, const Rollout& b) {
  const auto same_contact = [](const ContactRecord& c, const ContactRecord& d) {
    return c.node == d.node && c.obstacle == d.obstacle && c.branch == d.branch;
  };
  const auto same_record = [&](const StepRecord& c, const StepRecord& d) {
    return std::equal(c.contacts.begin(), c.contacts.end(), d.contacts.begin(), d.contacts.end(), same_contact);
  };
  return std::equal(a.records.begin(), a.records.end(), b.records.begin(), b.records.end(), same_record);
}

// The largest distance between the two after any solve, m.
double LargestDeviation(const Rollout& a, const Rollout& b) {
  double largest = 0.0;
  for (std::size_t i = 0; i < a.records.size(); ++i) {
    const Eigen::VectorXd deviation = a.records[i].positions - b.records[i].positions;
    largest = std::max(largest, deviation.lpNorm<Eigen::Infinity>());
  }
  return largest;
}

bool HasSlip(const Rollout& rollout) {
  return std::any_of(rollout.records.begin(), rollout.records.end(), [](const StepRecord& record) {
    return std::any_of(record.contacts.begin(), record.contacts.end(),
                       [](const ContactRecord& contact) { return contact.branch == ContactBranch::kSlip; });
  });
}

std::vector<ParameterId> CheckedParameters(const Scene& scene, const Rollout& rollout) {
  std::vector<ParameterId> ids = {{ParameterKind::kStretchStiffness}};
  const ParameterId friction = {ParameterKind::kFriction};
  if (!scene.obstacles.empty()) {
    if (GetParameter(rollout.parameters, friction) > 0.0 && HasSlip(rollout)) ids.push_back(friction);
    return ids;
  }
  if (scene.has_bending()) ids.push_back({ParameterKind::kBendingStiffness});
  if (scene.has_drag()) ids.push_back({ParameterKind::kDrag});
  return ids;
}

class Differences {
 public:
  Differences(const Rollout& middle, const RandomFunctional& functional, Simulator* simulator)
      : middle_(middle), functional_(functional), simulator_(simulator) {}

  // D(step); NaN with a reason where it is no derivative.
  double At(ParameterId id, double step, std::string* reason) const {
    std::array<Rollout, 2> sides;
    for (int side = 0; side < 2; ++side) {
      Parameters parameters = middle_.parameters;
      SetParameter(id, GetParameter(parameters, id) * (1.0 + (side == 0 ? step : -step)), &parameters);
      RolloutOptions options;
      options.followed = &middle_;
      sides[side] = Simulate(parameters, middle_.num_steps(), simulator_, nullptr, options);
      const std::string difference = WhatDiffers(sides[side], step);
      if (difference.empty()) continue;
      *reason = difference;
      return kNaN;
    }
    return functional_.Difference(sides[0], sides[1]) / (2.0 * step);
  }

 private:
  // Empty: nothing but what is smooth.
  std::string WhatDiffers(const Rollout& side, double step) const {
    if (!side.ok()) return "a rollout beside it failed";
    if (!SameSolves(side, middle_)) return "substeps differ";
    const double size = ClothSize(simulator_->scene().mesh);
    if (LargestDeviation(side, middle_) > std::sqrt(step) * size) return "other solution of a step";
    return SameBranches(side, middle_) ? "" : "branches differ";
  }

  const Rollout& middle_;
  const RandomFunctional& functional_;
  Simulator* simulator_;
};

// p dC/dp for every parameter; empty, with a reason, where the sweep meets a singular step.
Eigen::VectorXd AdjointGradient(const Rollout& rollout, const RandomFunctional& functional,
                                const std::vector<ParameterId>& ids, Simulator* simulator, std::string* reason) {
  const auto add_gradient = [&](int step, Eigen::MatrixXd* columns) { functional.AddGradient(step, columns); };
  Eigen::VectorXd scaled;
  try {
    scaled = PullBack(rollout, ids, 1, add_gradient, simulator).parameters.col(0);
  } catch (const std::runtime_error& error) {
    *reason = std::string("the adjoint sweep failed: ") + error.what();
    return scaled;
  }
  for (std::size_t i = 0; i < ids.size(); ++i) scaled[i] *= GetParameter(rollout.parameters, ids[i]);
  return scaled;
}

// From small steps to large ones, until two of them agree or a larger one meets other branches.
ComponentCheck CheckComponent(const Differences& differences, ParameterId id, double adjoint, double scale,
                              double negligible) {
  ComponentCheck check;
  check.adjoint = adjoint;
  check.difference = check.step = check.settled = check.error = kNaN;
  std::string reason = "differences do not settle";
  double smaller = kNaN;
  for (std::size_t i = 0; i < kSteps.size() && !(check.settled <= kSettled); ++i) {
    const double larger = differences.At(id, kSteps[i], &reason);
    if (std::isnan(larger)) break;
    const double settled = std::abs(larger - smaller) / scale;
    smaller = larger;
    if (i == 0 || settled >= check.settled) continue;
    check.difference = larger;
    check.step = kSteps[i];
    check.settled = settled;
  }
  if (std::abs(adjoint) <= negligible && std::abs(smaller) <= negligible) {
    check.reason = "nothing depends on it";
  } else if (check.settled <= kLargestSettled) {
    check.error = std::abs(adjoint - check.difference) / scale;
  } else {
    check.reason = reason;
  }
  return check;
}

}  // namespace

bool StabilityGradient::is_checkable() const {
  return !components.empty() && std::all_of(components.begin(), components.end(),
                                            [](const ComponentCheck& check) { return check.reason.empty(); });
}

double StabilityGradient::error() const {
  double largest = kNaN;
  for (const ComponentCheck& check : components) largest = std::fmax(largest, check.error);
  return largest;
}

std::string StabilityGradient::Reasons() const {
  std::string text = reason;
  for (const ComponentCheck& check : components) {
    if (!check.reason.empty()) text += (text.empty() ? "" : "; ") + check.parameter + ": " + check.reason;
  }
  return text;
}

StabilityGradient CheckGradient(Scene scene, std::uint64_t seed) {
  scene.solver.step_tolerance = scene.solver.adjoint_tolerance = kTolerance;
  Simulator simulator(std::move(scene));
  StabilityGradient check;
  const int num_steps = std::min(simulator.scene().num_steps(), kMaxSteps);
  Rollout rollout = Simulate(simulator.scene().nominal_parameters(), num_steps, &simulator);
  if (rollout.ok()) rollout = Refine(rollout, &simulator);
  if (!rollout.ok()) {
    check.reason = "the rollout failed: " + rollout.failure->ToString();
    return check;
  }
  const RandomFunctional functional(num_steps, rollout.initial_positions.size(), seed);
  const std::vector<ParameterId> ids = CheckedParameters(simulator.scene(), rollout);
  const Eigen::VectorXd scaled = AdjointGradient(rollout, functional, ids, &simulator, &check.reason);
  if (scaled.size() == 0) return check;
  const double negligible = kNegligible * functional.Size(rollout);
  const Differences differences(rollout, functional, &simulator);
  for (std::size_t i = 0; i < ids.size(); ++i) {
    const double scale = std::max(std::abs(scaled[i]), kSmallestShare * scaled.norm());
    check.components.push_back(CheckComponent(differences, ids[i], scaled[i], scale, negligible));
    check.components.back().parameter = ParameterName(ids[i], simulator.scene().obstacle_names());
  }
  return check;
}

}  // namespace clothid
