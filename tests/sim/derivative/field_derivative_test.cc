// Constants that vary over the cloth: adjoint = sensitivity = central finite differences, with both contact modes, both
// integrators, both laws of bending, drag and internal damping.
#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <random>
#include <stdexcept>
#include <string>
#include <tuple>
#include <vector>

#include "sim/derivative/adjoint.h"
#include "sim/derivative/sensitivity.h"
#include "sim/rollout/simulator.h"
#include "sim/scene/attached_handles.h"
#include "sim/scene/material_field.h"
#include "tests/sim/curved_rest.h"
#include "tests/sim/derivative/same_branches.h"
#include "tests/sim/shipped_scenes.h"

namespace clothid::field_derivative_test {
namespace {

constexpr ParameterKind kFieldKinds[] = {ParameterKind::kStretchStiffness, ParameterKind::kDensity,
                                         ParameterKind::kBendingStiffness};

// A control grid of other values each, about `level`.
GridField WavyField(ParameterKind kind, double level) {
  GridField field;
  field.kind = kind;
  field.values.resize(3, 4);
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < 4; ++c) field.values(r, c) = level * std::exp(0.5 * std::sin(1.0 + 2.0 * r + 3.0 * c));
  }
  return field;
}

// The draped cloth with all terms, in velocity mode clamped.
Scene FieldScene(Integrator integrator, ContactMode mode, BendingLaw law) {
  Scene scene = ShippedScene("drape", 10);
  scene.integrator = integrator;
  scene.contact_mode = mode;
  scene.bending.law = law;
  scene.bending.poisson = law == BendingLaw::kPatches ? 0.2 : 0.0;
  scene.duration = integrator == Integrator::kSdirk2 || mode == ContactMode::kVelocity ? 0.42 : 0.5;
  scene.material.bending_stiffness = 1e-4;
  scene.material.drag = 0.05;
  scene.material.damping = 0.02;
  scene.solver.step_tolerance = 1e-12;
  scene.solver.adjoint_tolerance = 1e-14;
  if (mode == ContactMode::kVelocity) ClampHandles({{scene.handles.nodes}}, &scene);
  const Material& material = scene.material;
  scene.fields = {WavyField(kFieldKinds[0], material.stretch_stiffness), WavyField(kFieldKinds[1], material.density),
                  WavyField(kFieldKinds[2], material.bending_stiffness)};
  return scene;
}

// `parameters` with their factors moved by `change` [K F].
Parameters Moved(Parameters parameters, const Eigen::VectorXd& change) {
  auto fields = std::make_shared<std::vector<FieldFactors>>(*parameters.fields);
  Eigen::Index row = 0;
  for (FieldFactors& field : *fields) {
    field.log_factors += change.segment(row, field.log_factors.size());
    row += field.log_factors.size();
  }
  parameters.fields = fields;
  return parameters;
}

double Cost(const Rollout& rollout) {
  double cost = 0.0;
  for (int step = 0; step <= rollout.num_steps(); ++step) cost += 0.5 * rollout.positions(step).squaredNorm();
  return cost;
}

// A direction for each field alone.
Eigen::MatrixXd FieldDirections(int num_faces) {
  std::mt19937_64 generator(3);
  std::normal_distribution<double> normal;
  Eigen::MatrixXd columns = Eigen::MatrixXd::Zero(3 * num_faces, 3);
  for (int k = 0; k < 3; ++k) {
    columns.col(k).segment(k * num_faces, num_faces) =
        Eigen::VectorXd::NullaryExpr(num_faces, [&] { return normal(generator); });
  }
  return columns;
}

// With a rest shape that is curved, or flat.
using Case = std::tuple<Integrator, ContactMode, BendingLaw, bool, MembraneLaw>;

// The same cloth with warp and weft, the third field that of the rigidity along the weft or of shear.
Scene WovenScene(Scene scene, MembraneLaw law) {
  Material& material = scene.material;
  scene.membrane = law;
  scene.warp.angle = 20.0;
  material.warp_stiffness = 1.2 * material.stretch_stiffness;
  material.weft_stiffness = 0.8 * material.stretch_stiffness;
  material.shear_stiffness = 0.4 * material.stretch_stiffness;
  material.poisson_stiffness = 0.1 * material.stretch_stiffness;
  scene.fields[0] = WavyField(ParameterKind::kWarpStiffness, material.warp_stiffness);
  scene.fields[2] = WavyField(ParameterKind::kShearStiffness, material.shear_stiffness);
  if (law != MembraneLaw::kYarn) return scene;
  material.warp_stiffening = 3.0;
  material.weft_stiffening = 2.0;
  scene.bending.orthotropic = true;
  material.bending_stiffness = 0.0;
  material.warp_bending = material.weft_bending = material.twist_bending = 1e-4;
  scene.fields[1] = WavyField(ParameterKind::kWeftStiffness, material.weft_stiffness);
  scene.fields[2] = WavyField(ParameterKind::kWeftBending, 1e-3);
  return scene;
}

Scene SceneOf(const Case& test) {
  const auto [integrator, mode, law, is_curved, membrane] = test;
  Scene scene = FieldScene(integrator, mode, law);
  if (membrane != MembraneLaw::kArap) scene = WovenScene(scene, membrane);
  if (!is_curved) return scene;
  scene.fields[2].values *= 10.0;  // so that bending counts
  return CurvedAtRest(scene);
}

class FieldDerivativeTest : public ::testing::TestWithParam<Case> {
 protected:
  FieldDerivativeTest()
      : scene_(SceneOf(GetParam())),
        simulator_(scene_),
        parameters_(scene_.nominal_parameters()),
        directions_(FieldDirections(scene_.mesh.num_faces())),
        rollout_(Simulate(parameters_, scene_.num_steps(), &simulator_)) {}

  Eigen::MatrixXd Adjoint(const Rollout& rollout) {
    const Rollout& kept = rollout_;
    return PullBack(
               rollout, {}, 1, [&](int step, Eigen::MatrixXd* seed) { seed->col(0) += kept.positions(step); },
               &simulator_)
        .fields;
  }

  Scene scene_;
  Simulator simulator_;
  Parameters parameters_;
  Eigen::MatrixXd directions_;
  Rollout rollout_;
};

TEST_P(FieldDerivativeTest, AdjointEqualsSensitivityEqualsDifferences) {
  ASSERT_TRUE(rollout_.ok()) << rollout_.failure->ToString();
  ASSERT_FALSE(rollout_.records.back().contacts.empty());
  const Eigen::VectorXd adjoint = directions_.transpose() * Adjoint(rollout_);
  SensitivityDirections directions;
  directions.fields = directions_;
  directions.parameters = {{scene_.fields[0].kind}};
  Eigen::VectorXd swept = Eigen::VectorXd::Zero(4), along = swept;
  PushForward(
      parameters_, scene_.num_steps(), directions,
      [&](int, const Eigen::VectorXd& x, const Eigen::MatrixXd& dx) { swept += dx.transpose() * x; }, &simulator_);
  PushForward(
      rollout_, directions,
      [&](int, const Eigen::VectorXd& x, const Eigen::MatrixXd& dx) { along += dx.transpose() * x; }, &simulator_);
  for (int k = 0; k < 3; ++k) {
    EXPECT_NEAR(adjoint[k], swept[1 + k], 1e-10 * std::abs(adjoint[k])) << k;
    EXPECT_NEAR(swept[1 + k], along[1 + k], 1e-10 * std::abs(adjoint[k])) << k;
    double best = 1.0;
    for (const double step : {1e-4, 1e-5, 1e-6, 1e-7}) {
      if (best <= 1e-6) break;
      const Rollout plus = Simulate(Moved(parameters_, step * directions_.col(k)), scene_.num_steps(), &simulator_);
      const Rollout minus = Simulate(Moved(parameters_, -step * directions_.col(k)), scene_.num_steps(), &simulator_);
      if (!HaveSameBranches(rollout_, plus) || !HaveSameBranches(rollout_, minus)) continue;
      const double difference = (Cost(plus) - Cost(minus)) / (2.0 * step);
      best = std::min(best, std::abs(difference - adjoint[k]) / std::abs(adjoint[k]));
    }
    EXPECT_LE(best, 1e-6) << k;
  }
}

// A field that goes up by the same factor everywhere is the constant that goes up.
TEST_P(FieldDerivativeTest, SumOverTrianglesIsTheConstant) {
  ASSERT_TRUE(rollout_.ok());
  const RolloutGradient gradient = PullBack(
      rollout_, {{scene_.fields[0].kind}, {scene_.fields[1].kind}, {scene_.fields[2].kind}}, 1,
      [&](int step, Eigen::MatrixXd* seed) { seed->col(0) += rollout_.positions(step); }, &simulator_);
  for (int k = 0; k < 3; ++k) {
    const double by_log = GetParameter(parameters_, {scene_.fields[k].kind}) * gradient.parameters(k, 0);
    const int num_faces = scene_.mesh.num_faces();
    EXPECT_NEAR(gradient.fields.col(0).segment(k * num_faces, num_faces).sum(), by_log, 1e-9 * std::abs(by_log)) << k;
  }
}

// A stiffening acts on what its yarn has at every triangle, and what couples warp and weft is no field.
TEST_P(FieldDerivativeTest, OtherConstantsOfTheMembraneHaveTheirDerivatives) {
  ASSERT_TRUE(rollout_.ok());
  std::vector<ParameterId> others;
  if (scene_.membrane != MembraneLaw::kArap) others.push_back({ParameterKind::kPoissonStiffness});
  if (scene_.membrane == MembraneLaw::kYarn) others.push_back({ParameterKind::kWarpStiffening});
  const RolloutGradient gradient = PullBack(
      rollout_, others, 1, [&](int step, Eigen::MatrixXd* seed) { seed->col(0) += rollout_.positions(step); },
      &simulator_);
  for (std::size_t i = 0; i < others.size(); ++i) {
    const double adjoint = gradient.parameters(static_cast<Eigen::Index>(i), 0);
    double best = 1.0;
    for (const double step : {1e-3, 1e-4, 1e-5, 1e-6}) {
      const auto moved = [&](double change) {
        Parameters parameters = parameters_;
        SetParameter(others[i], GetParameter(parameters, others[i]) + change, &parameters);
        return Simulate(parameters, scene_.num_steps(), &simulator_);
      };
      const Rollout plus = moved(step), minus = moved(-step);
      if (!HaveSameBranches(rollout_, plus) || !HaveSameBranches(rollout_, minus)) continue;
      const double difference = (Cost(plus) - Cost(minus)) / (2.0 * step);
      best = std::min(best, std::abs(difference - adjoint) / std::abs(adjoint));
    }
    EXPECT_LE(best, 1e-6) << i;
  }
}

// Neither rollouts with other fields in between nor checkpoints change anything.
TEST_P(FieldDerivativeTest, RolloutsRememberTheirFields) {
  ASSERT_TRUE(rollout_.ok());
  RolloutOptions options;
  options.checkpoint_interval = 7;
  const Rollout checkpointed = Simulate(parameters_, scene_.num_steps(), &simulator_, nullptr, options);
  const Eigen::MatrixXd adjoint = Adjoint(checkpointed);
  Simulate(Moved(parameters_, 0.5 * directions_.col(0)), 3, &simulator_);
  EXPECT_TRUE(Adjoint(checkpointed) == adjoint);
}

std::string CaseName(const ::testing::TestParamInfo<Case>& info) {
  const auto [integrator, mode, law, is_curved, membrane] = info.param;
  return std::string(integrator == Integrator::kEuler ? "Euler" : "Sdirk2") +
         (mode == ContactMode::kGap ? "Gap" : "Velocity") + (law == BendingLaw::kEdges ? "Edges" : "Patches") +
         (is_curved ? "Curved" : "") +
         (membrane == MembraneLaw::kYarn          ? "Yarn"
          : membrane == MembraneLaw::kOrthotropic ? "Orthotropic"
                                                  : "");
}

constexpr MembraneLaw kArap = MembraneLaw::kArap;

INSTANTIATE_TEST_SUITE_P(
    Cases, FieldDerivativeTest,
    ::testing::Values(Case{Integrator::kEuler, ContactMode::kGap, BendingLaw::kPatches, false, kArap},
                      Case{Integrator::kEuler, ContactMode::kGap, BendingLaw::kPatches, true, kArap},
                      Case{Integrator::kEuler, ContactMode::kVelocity, BendingLaw::kEdges, false, kArap},
                      Case{Integrator::kSdirk2, ContactMode::kGap, BendingLaw::kEdges, false, kArap},
                      Case{Integrator::kSdirk2, ContactMode::kVelocity, BendingLaw::kPatches, false, kArap},
                      Case{Integrator::kEuler, ContactMode::kGap, BendingLaw::kEdges, false, MembraneLaw::kOrthotropic},
                      Case{Integrator::kSdirk2, ContactMode::kGap, BendingLaw::kPatches, false, MembraneLaw::kYarn}),
    CaseName);

TEST(FieldDerivative, RefusesDirectionsOfOtherFields) {
  const Scene scene = FieldScene(Integrator::kEuler, ContactMode::kGap, BendingLaw::kEdges);
  Simulator simulator(scene);
  SensitivityDirections directions;
  directions.fields = Eigen::MatrixXd::Ones(scene.mesh.num_faces(), 1);
  EXPECT_THROW(PushForward(
                   scene.nominal_parameters(), 1, directions,
                   [](int, const Eigen::VectorXd&, const Eigen::MatrixXd&) {}, &simulator),
               std::logic_error);
}

}  // namespace
}  // namespace clothid::field_derivative_test
