// adjoint = sensitivity = central finite differences of one rollout.
#ifndef CLOTHID_TESTS_SIM_DERIVATIVE_GRADIENT_CASE_H_
#define CLOTHID_TESTS_SIM_DERIVATIVE_GRADIENT_CASE_H_

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <memory>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "sim/derivative/adjoint.h"
#include "sim/derivative/sensitivity.h"
#include "sim/rollout/correction.h"
#include "sim/rollout/rollout.h"
#include "sim/rollout/simulator.h"
#include "sim/scene/scene.h"
#include "tests/sim/derivative/same_branches.h"

namespace clothid {

// A scalar of the trajectory, L = 1/2 sum over steps of |x - target|^2, before and after corrections where there are
// some, and its derivatives three ways.
class GradientCase {
 public:
  // `parameters` in place of the scene's. `correction`: of the rollout; may be null.
  explicit GradientCase(const Scene& scene, AdjointMethod method = AdjointMethod::kReduced)
      : GradientCase(scene, scene.nominal_parameters(), method) {}
  GradientCase(const Scene& scene, const Parameters& parameters, AdjointMethod method = AdjointMethod::kReduced,
               std::shared_ptr<const Correction> correction = nullptr)
      : scene_(scene), simulator_(scene), parameters_(parameters), correction_(std::move(correction)) {
    scene_.solver.step_tolerance = 1e-11;
    simulator_ = Simulator(scene_);
    RolloutOptions options;
    options.correction = correction_;
    rollout_ = Simulate(parameters_, scene_.num_steps(), &simulator_, nullptr, options);
    EXPECT_TRUE(rollout_.ok()) << rollout_.failure->ToString();
    MakeTarget();
    CollectParameters();
    MakeDirections();
    Differentiate(method);
  }

  int num_directions() const { return static_cast<int>(adjoint_.size()); }
  const Rollout& rollout() const { return rollout_; }
  int num_substeps() const { return rollout_.counts.substeps; }
  double adjoint(int i) const { return adjoint_[i]; }
  double sensitivity(int i) const { return sensitivity_[i]; }
  // |theta dL/dtheta| > 1e-8 L; a start direction is scaled to the size of the state itself.
  bool has_influence(int i) const { return std::abs(Magnitude(i) * adjoint_[i]) > 1e-8 * Cost(rollout_); }

  std::string name(int i) const {
    if (i < num_parameters()) return ParameterName(ids_[i], scene_.obstacle_names(), scene_.mesh.piece_names);
    return i == num_parameters() ? "x_0" : "v_0";
  }

  bool HasInfluence(const std::string& parameter) const {
    for (int i = 0; i < num_directions(); ++i) {
      if (name(i) == parameter) return has_influence(i);
    }
    return false;
  }

  // The smallest relative error of central differences over step sizes at which both sides keep the branches of every
  // contact, up to the first that is within `tolerance`; 1 where no step size does.
  double DifferenceError(int i, double tolerance) const {
    double best = 1.0;
    for (const double relative_step : {1e-4, 1e-5, 1e-3, 1e-2, 1e-6}) {
      const double step = relative_step * Magnitude(i);
      const Rollout plus = Perturbed(i, step), minus = Perturbed(i, -step);
      if (!HaveSameBranches(rollout_, plus) || !HaveSameBranches(rollout_, minus)) continue;
      const double difference = (Cost(plus) - Cost(minus)) / (2.0 * step);
      best = std::min(best, std::abs(difference - adjoint_[i]) / std::abs(adjoint_[i]));
      if (best <= tolerance) break;
    }
    return best;
  }

 private:
  int num_parameters() const { return static_cast<int>(ids_.size()); }
  double Magnitude(int i) const {
    constexpr double kOfPlacement = 0.03;  // s, m or rad
    if (i < num_parameters()) return IsPlacement(ids_[i].kind) ? kOfPlacement : GetParameter(parameters_, ids_[i]);
    return i == num_parameters() ? 0.1 * ClothSize(scene_.mesh) : 0.1;
  }

  // Nothing that the rollout itself reaches, so that the gradient does not vanish.
  void MakeTarget() {
    target_ = 0.95 * rollout_.initial_positions + Eigen::VectorXd::Constant(rollout_.initial_positions.size(), 0.02);
  }

  void CollectParameters() {
    if (!scene_.obstacles.empty()) ids_.push_back({ParameterKind::kFriction});
    for (size_t i = 0; i < scene_.obstacles.size() && scene_.obstacles.size() > 1; ++i) {
      ids_.push_back({ParameterKind::kFriction, 0, static_cast<int>(i)});
    }
    for (int i = 0; i < static_cast<int>(scene_.obstacles.size()); ++i) {
      if (!scene_.obstacles[i].moves()) continue;
      for (const ParameterId id : ParametersOf(ParameterTerm::kPlacement)) ids_.push_back({id.kind, id.axis, i});
    }
    if (scene_.self_contact) ids_.push_back({ParameterKind::kSelfFriction});
    for (const ParameterKind kind : MaterialKinds()) {
      if (scene_.has(kind) && parameters_.material.*RowOf(kind).constant != 0.0) ids_.push_back({kind});
    }
    for (const ParameterId id : scene_.piece_parameters()) ids_.push_back(id);
  }

  void MakeDirections() {
    std::mt19937_64 generator(11);
    std::normal_distribution<double> normal;
    const Eigen::Index size = rollout_.initial_positions.size();
    directions_.parameters = ids_;
    directions_.initial_positions = directions_.initial_velocities = Eigen::MatrixXd::Zero(size, 2);
    // A shift, so that the effects of the nodes add up, and a random part, so that every mode is in it.
    const double shift[3] = {0.01, -0.005, 0.007};
    for (Eigen::Index i = 0; i < size; ++i) {
      directions_.initial_positions(i, 0) = shift[i % 3] + 0.001 * normal(generator);
      directions_.initial_velocities(i, 1) = normal(generator);
    }
    for (const int handle : scene_.handles.nodes) {
      directions_.initial_positions.middleRows<3>(3 * handle).setZero();
      directions_.initial_velocities.middleRows<3>(3 * handle).setZero();
    }
  }

  void Differentiate(AdjointMethod method) {
    const auto seed = [this](int step, Eigen::MatrixXd* gradient) {
      gradient->col(0) += rollout_.positions(step) - target_;
    };
    const auto corrected_seed = [this](int step, Eigen::MatrixXd* gradient) {
      gradient->col(0) += Corrected(rollout_, step)->positions - target_;
    };
    const RolloutGradient gradient = PullBack(rollout_, ids_, 1, seed, &simulator_, {method}, {}, corrected_seed);
    adjoint_ = Eigen::VectorXd(num_parameters() + 2);
    adjoint_ << gradient.parameters, directions_.initial_positions.col(0).dot(gradient.initial_positions.col(0)),
        directions_.initial_velocities.col(1).dot(gradient.initial_velocities.col(0));
    sensitivity_ = Eigen::VectorXd::Zero(num_parameters() + 2);
    const auto visitor = [this](int, const Eigen::VectorXd& x, const Eigen::MatrixXd& dx) {
      sensitivity_ += dx.transpose() * (x - target_);
    };
    SensitivityOptions options;
    options.correction = correction_;
    options.corrected_visitor = visitor;
    const SensitivityResult result =
        PushForward(parameters_, scene_.num_steps(), directions_, visitor, &simulator_, nullptr, options);
    EXPECT_FALSE(result.failure.has_value());
  }

  Rollout Perturbed(int i, double step) const {
    Scene scene = scene_;
    Parameters parameters = parameters_;
    if (i < num_parameters()) {
      // Friction of all obstacles at once moves each from where it is, and so do constants of all pieces.
      if (ids_[i] == ParameterId{ParameterKind::kFriction}) {
        for (double& mu : parameters.friction_coefficients) mu += step;
      } else if (scene_.has_of_pieces(ids_[i].kind) && ids_[i].part == kWhole) {
        for (Material& piece : parameters.pieces) piece.*RowOf(ids_[i].kind).constant += step;
      } else {
        SetParameter(ids_[i], GetParameter(parameters_, ids_[i]) + step, &parameters);
      }
    } else {
      scene.initial_positions += step * directions_.initial_positions.col(0) * (i == num_parameters());
      scene.initial_velocities += step * directions_.initial_velocities.col(1) * (i > num_parameters());
    }
    Simulator simulator(scene);
    RolloutOptions options;
    options.correction = correction_;
    options.followed = &rollout_;  // cut where it was, and solved beyond the tolerance
    return Simulate(parameters, scene.num_steps(), &simulator, nullptr, options);
  }

  double Cost(const Rollout& rollout) const {
    double cost = 0.0;
    for (int step = 0; step <= rollout.num_steps(); ++step)
      cost += 0.5 * (rollout.positions(step) - target_).squaredNorm();
    for (int step = 1; step <= rollout.num_steps(); ++step) {
      const CorrectedState* const corrected = Corrected(rollout, step);
      if (corrected != nullptr) cost += 0.5 * (corrected->positions - target_).squaredNorm();
    }
    return cost;
  }

  static const CorrectedState* Corrected(const Rollout& rollout, int step) {
    return rollout.records[rollout.last_record[step - 1]].correction.get();
  }

  Scene scene_;
  Simulator simulator_;
  Parameters parameters_;
  std::shared_ptr<const Correction> correction_;
  Rollout rollout_;
  Eigen::VectorXd target_, adjoint_, sensitivity_;
  std::vector<ParameterId> ids_;
  SensitivityDirections directions_;
};

inline void ExpectAgreement(const GradientCase& gradient, double difference_tolerance) {
  int checked = 0;
  for (int i = 0; i < gradient.num_directions(); ++i) {
    if (!gradient.has_influence(i)) continue;
    ++checked;
    EXPECT_NEAR(gradient.adjoint(i), gradient.sensitivity(i), 1e-10 * std::abs(gradient.adjoint(i)))
        << gradient.name(i);
    EXPECT_LE(gradient.DifferenceError(i, difference_tolerance), difference_tolerance) << gradient.name(i);
  }
  EXPECT_GE(checked, 3);
}

}  // namespace clothid

#endif  // CLOTHID_TESTS_SIM_DERIVATIVE_GRADIENT_CASE_H_
