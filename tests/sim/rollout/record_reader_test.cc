// Checkpoints, between which the steps of a rollout come back.
#include "sim/rollout/record_reader.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <stdexcept>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "sim/derivative/adjoint.h"
#include "sim/rollout/rollout.h"
#include "sim/rollout/segment.h"
#include "sim/rollout/simulator.h"
#include "tests/sim/self_contact_scenes.h"
#include "tests/sim/shipped_scenes.h"

namespace clothid::record_reader_test {
namespace {

// `drape` with and without substeps: 80 steps, in segments of 9, so that the last is shorter.
class CheckpointTest : public testing::TestWithParam<std::tuple<bool, Integrator>> {
 protected:
  static constexpr int kInterval = 9;

  CheckpointTest() : scene_(ShippedScene("drape", 8)), simulator_(scene_) {
    scene_.integrator = std::get<1>(GetParam());
    if (has_substeps()) scene_.solver.max_newton_iterations = 3;  // too few for some steps, which are then cut
    simulator_ = Simulator(scene_);
    parameters_ = scene_.nominal_parameters();
    RolloutOptions options;
    options.checkpoint_interval = kInterval;
    options.visitor = [this](int step, const Eigen::VectorXd& positions) {
      EXPECT_EQ(step, static_cast<int>(visited_.size()));
      visited_.push_back(positions);
    };
    rollout_ = Simulate(parameters_, scene_.num_steps(), &simulator_, nullptr, options);
    EXPECT_TRUE(rollout_.ok()) << rollout_.failure->ToString();
    EXPECT_EQ(rollout_.counts.substeps > 0, has_substeps());
  }

  static bool has_substeps() { return std::get<0>(GetParam()); }

  // The steps of the same segments, all kept.
  Rollout KeepAll() {
    Rollout all = rollout_;
    all.checkpoint_interval = 0;
    all.records.clear();
    StepState state{all.initial_positions, all.initial_velocities};
    for (int first = 1; first <= scene_.num_steps(); first += kInterval) {
      const auto append = [&all](int, std::vector<StepRecord> records) {
        for (StepRecord& record : records) all.records.push_back(std::move(record));
      };
      Segment segment;
      segment.first_step = first;
      segment.last_step = std::min(first + kInterval - 1, scene_.num_steps());
      EXPECT_TRUE(AdvanceSegment(parameters_, segment, append, &simulator_, &state).ok());
    }
    return all;
  }

  RolloutGradient Gradient(const Rollout& rollout) {
    const std::vector<ParameterId> ids = {{ParameterKind::kFriction},
                                          {ParameterKind::kStretchStiffness},
                                          {ParameterKind::kDensity},
                                          {ParameterKind::kDrag}};
    const auto seed = [this](int step, Eigen::MatrixXd* gradient) {
      gradient->col(0) += visited_[step];
      gradient->col(1).setConstant(1.0 / (1.0 + step));
    };
    return PullBack(rollout, ids, 2, seed, &simulator_);
  }

  Scene scene_;
  Simulator simulator_;
  Parameters parameters_;
  Rollout rollout_;
  std::vector<Eigen::VectorXd> visited_;  // x after every step, from the first pass
};

TEST_P(CheckpointTest, StepsComeBackToTheLastBit) {
  RecordReader reader(rollout_, &simulator_);
  for (int step = scene_.num_steps(); step > 0; --step) {
    EXPECT_EQ(reader.record(rollout_.last_record[step - 1]).positions, visited_[step]) << "step " << step;
  }
  EXPECT_EQ(reader.start_positions(0), visited_[0]);
}

TEST_P(CheckpointTest, TheGradientIsThatOfAllStepsToTheLastBit) {
  const Rollout all = KeepAll();
  ASSERT_EQ(all.records.size(), rollout_.records.size());
  const RolloutGradient expected = Gradient(all), actual = Gradient(rollout_);
  EXPECT_EQ(actual.parameters, expected.parameters);
  EXPECT_EQ(actual.initial_positions, expected.initial_positions);
  EXPECT_EQ(actual.initial_velocities, expected.initial_velocities);
  EXPECT_GT(expected.parameters.cwiseAbs().minCoeff(), 0.0);
}

// Steps to a tolerance that is not the scene's are made again to that one.
TEST_P(CheckpointTest, RememberTheTolerance) {
  RolloutOptions options;
  options.step_tolerance = 1e-3;
  const Rollout all = Simulate(parameters_, kInterval, &simulator_, nullptr, options);
  options.checkpoint_interval = kInterval;
  const Rollout rollout = Simulate(parameters_, 2 * kInterval, &simulator_, nullptr, options);
  ASSERT_TRUE(all.ok() && rollout.ok());
  ASSERT_NE(all.positions(kInterval), visited_[kInterval]);
  RecordReader reader(rollout, &simulator_);
  for (int i = all.last_record.back(); i >= 0; --i) EXPECT_EQ(reader.record(i).positions, all.records[i].positions);
}

// Without substeps: whether too few iterations suffice depends on what the step before has left.
using WholeStepsTest = CheckpointTest;

// The solver is reset at checkpoints, so that a rollout with them is one without but for the tolerance of its steps.
TEST_P(WholeStepsTest, ChangeNeitherTheStepsNorTheirCounts) {
  const Rollout plain = Simulate(parameters_, scene_.num_steps(), &simulator_);
  ASSERT_TRUE(plain.ok());
  EXPECT_EQ(plain.last_record, rollout_.last_record);
  EXPECT_EQ(plain.counts.contact_changes(), rollout_.counts.contact_changes());
  for (int step = 0; step <= scene_.num_steps(); ++step) {
    EXPECT_LE((plain.positions(step) - visited_[step]).norm(), 1e-7 * ClothSize(scene_.mesh)) << "step " << step;
  }
}

TEST_P(CheckpointTest, HoldLessThanAllSteps) {
  const Rollout all = KeepAll();
  // 8 checkpoints and the 8 steps after the last one, of 80.
  EXPECT_LT(100 * rollout_.bytes(), 35 * all.bytes());
  for (int step = 0; step <= scene_.num_steps(); ++step) {
    if (step % kInterval == 0 || step > 72) {
      EXPECT_EQ(rollout_.positions(step), visited_[step]);
    } else {
      EXPECT_THROW(rollout_.positions(step), std::logic_error);
    }
  }
}

TEST_P(CheckpointTest, AnotherSimulatorIsNoticed) {
  Scene other = scene_;
  other.gravity *= 1.001;
  simulator_ = Simulator(other);
  EXPECT_THROW(Gradient(rollout_), std::runtime_error);
}

// A cloth that slides on itself: what its pairs have left for the next step is forgotten at a checkpoint, too.
class PairCheckpointTest : public testing::TestWithParam<Integrator> {};

TEST_P(PairCheckpointTest, StepsAndGradientAreThoseOfAllStepsToTheLastBit) {
  Scene scene = LayersOnASlope(2, 0.44, 0.3, GetParam(), 0.005);
  for (int node = static_cast<int>(scene.handles.nodes.size()); node < scene.mesh.num_nodes(); ++node) {
    scene.initial_positions[3 * node + 2] += 0.001;
    scene.initial_velocities[3 * node] = 0.05;
  }
  Simulator simulator(scene);
  constexpr int kNumSteps = 17, kEvery = 5;
  std::vector<Eigen::VectorXd> visited;
  RolloutOptions options;
  options.checkpoint_interval = kEvery;
  options.visitor = [&](int, const Eigen::VectorXd& positions) { visited.push_back(positions); };
  const Parameters parameters = scene.nominal_parameters();
  const Rollout rollout = Simulate(parameters, kNumSteps, &simulator, nullptr, options);
  ASSERT_TRUE(rollout.ok()) << rollout.failure->ToString();
  ASSERT_GT(rollout.counts.self_contacts, 100);
  RecordReader reader(rollout, &simulator);
  for (int step = kNumSteps; step > 0; --step) {
    EXPECT_EQ(reader.record(rollout.last_record[step - 1]).positions, visited[step]) << "step " << step;
  }
  const auto seed = [&](int step, Eigen::MatrixXd* gradient) { gradient->col(0) += visited[step]; };
  const std::vector<ParameterId> ids = {{ParameterKind::kSelfFriction}, {ParameterKind::kStretchStiffness}};
  const Rollout plain = Simulate(parameters, kNumSteps, &simulator);
  const RolloutGradient expected = PullBack(plain, ids, 1, seed, &simulator),
                        actual = PullBack(rollout, ids, 1, seed, &simulator);
  EXPECT_LE((actual.parameters - expected.parameters).norm(), 1e-5 * expected.parameters.norm());
  for (int step = 0; step <= kNumSteps; ++step) {
    EXPECT_LE((plain.positions(step) - visited[step]).norm(), 1e-7 * ClothSize(scene.mesh)) << "step " << step;
  }
}

INSTANTIATE_TEST_SUITE_P(Integrators, PairCheckpointTest, testing::Values(Integrator::kEuler, Integrator::kSdirk2),
                         [](const auto& test) { return IntegratorName(test.param); });

INSTANTIATE_TEST_SUITE_P(Scenes, WholeStepsTest,
                         testing::Values(std::tuple(false, Integrator::kEuler),
                                         std::tuple(false, Integrator::kSdirk2)));
INSTANTIATE_TEST_SUITE_P(Scenes, CheckpointTest,
                         testing::Combine(testing::Bool(), testing::Values(Integrator::kEuler, Integrator::kSdirk2)),
                         [](const auto& test) {
                           return std::string(std::get<0>(test.param) ? "WithSubsteps" : "WholeSteps") +
                                  (std::get<1>(test.param) == Integrator::kEuler ? "" : "Sdirk2");
                         });

}  // namespace
}  // namespace clothid::record_reader_test
