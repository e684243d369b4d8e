// Rollouts that a recording corrects: what corrections do, and what they leave alone.
#include "sim/rollout/correction.h"

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>
#include <stdexcept>
#include <tuple>
#include <utility>
#include <vector>

#include "sim/derivative/adjoint.h"
#include "sim/derivative/sensitivity.h"
#include "sim/rollout/record_reader.h"
#include "sim/rollout/rollout.h"
#include "sim/rollout/simulator.h"
#include "tests/sim/nodal_correction.h"
#include "tests/sim/self_contact_scenes.h"
#include "tests/sim/shipped_scenes.h"

namespace clothid::correction_test {
namespace {

constexpr int kInterval = 4;  // steps

Rollout Corrected(const Scene& scene, std::shared_ptr<const Correction> correction, int num_threads = 1,
                  int checkpoint_interval = 0) {
  Simulator simulator(scene);
  simulator.SetNumThreads(num_threads);
  RolloutOptions options;
  options.correction = std::move(correction);
  options.checkpoint_interval = checkpoint_interval;
  Rollout rollout = Simulate(scene.nominal_parameters(), scene.num_steps(), &simulator, nullptr, options);
  EXPECT_TRUE(rollout.ok()) << rollout.failure->ToString();
  return rollout;
}

// Towards the cloth of a softer material, on a smoother obstacle.
std::shared_ptr<const NodalCorrection> TowardsSofter(const Scene& scene, const NodalCorrection::Gains& gains = {}) {
  Parameters parameters = scene.nominal_parameters();
  parameters.material.stretch_stiffness *= 0.6;
  for (double& mu : parameters.friction_coefficients) mu *= 0.7;
  return CorrectionTowards(scene, parameters, kInterval, gains);
}

class CorrectionTest : public testing::TestWithParam<Integrator> {
 protected:
  static Scene DrapeScene() {
    Scene scene = ShippedScene("drape", 8);
    scene.integrator = GetParam();
    return scene;
  }
};

// Innovations are zero along a rollout of the same scene, to the last bit.
TEST_P(CorrectionTest, TowardsItselfChangesNothing) {
  const Scene scene = DrapeScene();
  const auto correction = CorrectionTowards(scene, scene.nominal_parameters(), kInterval, {});
  const Rollout plain = Corrected(scene, nullptr), corrected = Corrected(scene, correction);
  for (int step = 1; step <= scene.num_steps(); ++step) {
    EXPECT_EQ(corrected.positions(step), plain.positions(step)) << step;
    const StepRecord& end = corrected.records[corrected.last_record[step - 1]];
    ASSERT_EQ(end.correction != nullptr, step % kInterval == 0);
    if (end.correction == nullptr) continue;
    EXPECT_EQ(end.correction->velocities, end.velocities);
  }
}

// Handles keep their path, nodes that touch the obstacle move along it, and none is moved into it.
TEST_P(CorrectionTest, KeepsHandlesAndContacts) {
  const Scene scene = DrapeScene();
  NodalCorrection::Gains gains;
  gains.alpha = 0.9;
  const Rollout rollout = Corrected(scene, TowardsSofter(scene, gains));
  int num_touching = 0;
  for (const StepRecord& record : rollout.records) {
    if (record.correction == nullptr) continue;
    const Eigen::VectorXd change = record.correction->positions - record.positions;
    for (const int handle : scene.handles.nodes) EXPECT_EQ(change.segment<3>(3 * handle), Eigen::Vector3d::Zero());
    for (const ContactRecord& contact : record.contacts.nodes) {
      const int row = 3 * contact.node;
      const Eigen::Vector3d n = scene.obstacles[0].shape->Closest(record.positions.segment<3>(row)).normal;
      EXPECT_NEAR(n.dot(change.segment<3>(row)), 0.0, 1e-15);
      EXPECT_NEAR(n.dot((record.correction->velocities - record.velocities).segment<3>(row)), 0.0, 1e-13);
      num_touching += change.segment<3>(row).norm() > 1e-5;
    }
    for (int node = 0; node < scene.mesh.num_nodes(); ++node) {
      const auto gap = [&](const Eigen::VectorXd& x) {
        return scene.obstacles[0].shape->Closest(x.segment<3>(3 * node)).gap - scene.obstacles[0].contact_distance;
      };
      EXPECT_GE(gap(record.correction->positions), std::min(gap(record.positions), 0.0) - 1e-12) << node;
    }
  }
  EXPECT_GT(num_touching, 10);
}

// alpha = 1: every seen node that nothing holds goes where the frame has it.
TEST(FreeCorrectionTest, GoesWhereTheRecordingIs) {
  Scene scene = ShippedScene("wind", 8);
  NodalCorrection::Gains gains;
  gains.alpha = 1.0;
  gains.limit = 1e6;
  gains.place = 1.0;
  gains.share = 0.0;
  Parameters softer = scene.nominal_parameters();
  softer.material.stretch_stiffness *= 0.6;
  Simulator simulator(scene);
  const Rollout measured = Simulate(softer, scene.num_steps(), &simulator);
  const Rollout rollout = Corrected(scene, CorrectionTowards(scene, softer, kInterval, gains));
  for (int step = kInterval; step <= scene.num_steps(); step += kInterval) {
    const Eigen::VectorXd& x = rollout.records[rollout.last_record[step - 1]].correction->positions;
    for (int node = 0; node < scene.mesh.num_nodes(); ++node) {
      if (node % 3 == 0) continue;  // not seen
      EXPECT_LE((x - measured.positions(step)).segment<3>(3 * node).norm(), 1e-12);
    }
  }
}

TEST_P(CorrectionTest, ResultsDoNotDependOnThreads) {
  const Scene scene = DrapeScene();
  const auto correction = TowardsSofter(scene);
  const Rollout one = Corrected(scene, correction, 1), two = Corrected(scene, correction, 2);
  ASSERT_EQ(one.records.size(), two.records.size());
  for (std::size_t i = 0; i < one.records.size(); ++i) EXPECT_EQ(one.records[i].positions, two.records[i].positions);
}

// The steps between checkpoints, some of them at the end of a corrected step, come back to the last bit.
TEST_P(CorrectionTest, ComesBackFromCheckpoints) {
  const Scene scene = DrapeScene();
  for (const int interval : {kInterval, 7}) {
    std::vector<Eigen::VectorXd> visited;
    Simulator simulator(scene);
    RolloutOptions options;
    options.correction = TowardsSofter(scene);
    options.checkpoint_interval = interval;
    options.visitor = [&](int, const Eigen::VectorXd& x) { visited.push_back(x); };
    const Rollout rollout = Simulate(scene.nominal_parameters(), scene.num_steps(), &simulator, nullptr, options);
    ASSERT_TRUE(rollout.ok());
    RecordReader reader(rollout, &simulator);
    for (int step = scene.num_steps(); step > 0; --step) {
      const int last = rollout.last_record[step - 1];
      EXPECT_EQ(reader.record(last).positions, visited[step]) << step;
      if (step > 1) continue;
      EXPECT_EQ(reader.start_positions(0), visited[0]);
    }
    const auto seed = [&](int step, Eigen::MatrixXd* gradient) { gradient->col(0) += visited[step]; };
    const std::vector<ParameterId> ids = {{ParameterKind::kFriction}, {ParameterKind::kStretchStiffness}};
    const Eigen::VectorXd gradient = PullBack(rollout, ids, 1, seed, &simulator).parameters;
    const Rollout all = Corrected(scene, options.correction);
    const Eigen::VectorXd expected = PullBack(all, ids, 1, seed, &simulator).parameters;
    EXPECT_LE((gradient - expected).norm(), 1e-5 * expected.norm());
  }
}

// Both sweeps along a rollout that is at hand, with the factors that it keeps: of parameters, of a field, and by what
// was corrected.
TEST_P(CorrectionTest, SweepsAlongItAgree) {
  Scene scene = DrapeScene();
  scene.fields = {{ParameterKind::kStretchStiffness, Eigen::RowVector2d(60.0, 90.0)}};
  scene.solver.step_tolerance = 1e-11;
  scene.solver.adjoint_tolerance = 1e-14;
  Simulator simulator(scene);
  RolloutOptions options;
  options.correction = TowardsSofter(scene);
  options.factor_memory = std::size_t{1} << 28;
  const Rollout rollout = Simulate(scene.nominal_parameters(), scene.num_steps(), &simulator, nullptr, options);
  ASSERT_TRUE(rollout.ok());
  const std::vector<ParameterId> ids = {{ParameterKind::kFriction}, {ParameterKind::kDensity}};
  const auto corrected = [&](int step) -> const Eigen::VectorXd& {
    return rollout.records[rollout.last_record[step - 1]].correction->positions;
  };
  const RolloutGradient gradient = PullBack(
      rollout, ids, 1, [&](int step, Eigen::MatrixXd* seed) { seed->col(0) += rollout.positions(step); }, &simulator,
      {}, {}, [&](int step, Eigen::MatrixXd* seed) { seed->col(0) += 2.0 * corrected(step); });
  SensitivityDirections directions;
  directions.parameters = ids;
  directions.fields = Eigen::VectorXd::LinSpaced(gradient.fields.rows(), -1.0, 2.0);
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  PushForward(
      rollout, directions, [&](int, const Eigen::VectorXd& x, const Eigen::MatrixXd& dx) { sum += dx.transpose() * x; },
      &simulator, std::nullopt, {},
      [&](int step, const Eigen::VectorXd& x, const Eigen::MatrixXd& dx) {
        EXPECT_EQ(x, corrected(step));
        sum += 2.0 * dx.transpose() * x;
      });
  Eigen::Vector3d expected;
  expected << gradient.parameters, directions.fields.transpose() * gradient.fields;
  for (int i = 0; i < 3; ++i) EXPECT_NEAR(sum[i], expected[i], 1e-10 * std::abs(expected[i])) << i;
  EXPECT_GT(expected.cwiseAbs().minCoeff(), 1e-6);
}

// A recording in which one sheet has gone through the other: corrections take less of it, or nothing.
TEST(CrossingCorrectionTest, IsCutWhereTheClothWouldCutItself) {
  Scene scene = CollidingSheets(Integrator::kEuler);
  scene.duration = 0.1;
  Scene measured = scene;
  measured.self_contact.reset();
  measured.initial_velocities *= 2.0;
  NodalCorrection::Gains gains;
  gains.alpha = 1.0;
  gains.limit = 1e6;
  const Rollout rollout = Corrected(scene, CorrectionTowards(measured, measured.nominal_parameters(), 2, gains));
  EXPECT_GT(rollout.cut_corrections, 0);
}

INSTANTIATE_TEST_SUITE_P(Integrators, CorrectionTest, testing::Values(Integrator::kEuler, Integrator::kSdirk2),
                         [](const auto& test) { return IntegratorName(test.param); });

}  // namespace
}  // namespace clothid::correction_test
