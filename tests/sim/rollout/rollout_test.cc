// What a rollout keeps: contacts from which the solver's own come back, and checkpoints between which its steps do.
#include "sim/rollout/rollout.h"

#include <gtest/gtest.h>

#include <stdexcept>
#include <string>
#include <tuple>
#include <vector>

#include "sim/cloth/cloth_model.h"
#include "sim/derivative/adjoint.h"
#include "sim/rollout/record_reader.h"
#include "sim/rollout/segment.h"
#include "sim/rollout/simulator.h"
#include "sim/step/step_problem.h"
#include "tests/sim/shipped_scenes.h"

namespace clothid {
namespace {

ContactRecord RecordOf(int node, ContactBranch branch, int obstacle = 0) {
  ContactRecord record;
  record.node = node;
  record.branch = branch;
  record.obstacle = obstacle;
  return record;
}

TEST(ContactChangesTest, TellJoinedLeftAndSwitchedApart) {
  const ContactBranch stick = ContactBranch::kStick, slip = ContactBranch::kSlip;
  RolloutCounts counts;
  CountContactChanges(
      {RecordOf(1, stick), RecordOf(3, slip), RecordOf(4, slip), RecordOf(6, stick)},
      {RecordOf(0, slip), RecordOf(3, stick), RecordOf(4, stick, 1), RecordOf(6, stick), RecordOf(7, slip)}, &counts);
  EXPECT_EQ(counts.contacts, 5);
  EXPECT_EQ(counts.nodes_joined, 2);
  EXPECT_EQ(counts.nodes_left, 1);
  EXPECT_EQ(counts.branch_switches, 2);
  EXPECT_EQ(counts.obstacle_switches, 1);
  EXPECT_EQ(counts.contact_changes(), 5);
}

class StoredContactsTest : public testing::TestWithParam<std::tuple<std::string, ContactMode>> {};

TEST_P(StoredContactsTest, BringBackThoseOfTheSolver) {
  Scene scene = ShippedScene(std::get<0>(GetParam()), 10);
  scene.contact_mode = std::get<1>(GetParam());
  scene.material.damping = 0.01;
  Simulator simulator(scene);
  const Rollout rollout = Simulate(scene.nominal_parameters(), scene.num_steps(), &simulator);
  ASSERT_TRUE(rollout.ok()) << rollout.failure->ToString();
  RecordReader reader(rollout, &simulator);
  StepPoint point;
  std::size_t num_contacts = 0;
  for (std::size_t i = 0; i < rollout.records.size(); ++i) {
    const StepRecord& record = rollout.records[i];
    const Eigen::VectorXd& start = reader.start_positions(static_cast<int>(i));
    const StepProblem problem(simulator.model(), rollout.parameters, start,
                              reader.start_velocities(static_cast<int>(i)), record.time_step, record.time,
                              &simulator.step_workspace());
    problem.Evaluate(simulator.model().Gather(record.velocities), &point);
    const std::vector<Contact> solved = problem.ActiveContacts(point);
    const std::vector<Contact> restored =
        RestoreContacts(simulator.model(), rollout.parameters, start, record.time_step, record.contacts);
    ASSERT_EQ(restored.size(), solved.size());
    num_contacts += solved.size();
    for (std::size_t j = 0; j < solved.size(); ++j) {
      EXPECT_EQ(restored[j].candidate.node, solved[j].candidate.node);
      EXPECT_EQ(restored[j].candidate.obstacle, solved[j].candidate.obstacle);
      EXPECT_EQ(restored[j].candidate.normal, solved[j].candidate.normal);
      EXPECT_EQ(restored[j].candidate.normal_gradient, solved[j].candidate.normal_gradient);
      EXPECT_EQ(restored[j].candidate.gap, solved[j].candidate.gap);
      EXPECT_EQ(restored[j].candidate.gap_speed, solved[j].candidate.gap_speed);
      EXPECT_EQ(restored[j].candidate.gap_speed_slope, solved[j].candidate.gap_speed_slope);
      EXPECT_EQ(restored[j].weight, solved[j].weight);
      EXPECT_EQ(restored[j].force, solved[j].force);
      EXPECT_EQ(restored[j].response.branch, record.contacts[j].branch);
      EXPECT_EQ(restored[j].response.impulse, solved[j].response.impulse);
      EXPECT_EQ(restored[j].response.slip_direction, solved[j].response.slip_direction);
    }
  }
  EXPECT_GT(num_contacts, 100u);
}

INSTANTIATE_TEST_SUITE_P(Scenes, StoredContactsTest,
                         testing::Combine(testing::Values("drape", "slope"),
                                          testing::Values(ContactMode::kGap, ContactMode::kVelocity)),
                         [](const auto& test) {
                           const bool gap = std::get<1>(test.param) == ContactMode::kGap;
                           return std::get<0>(test.param) + (gap ? "Gap" : "Velocity");
                         });

// `drape` with and without substeps: 80 steps, in segments of 9, so that the last is shorter.
class CheckpointTest : public testing::TestWithParam<bool> {
 protected:
  static constexpr int kInterval = 9;

  CheckpointTest() : scene_(ShippedScene("drape", 8)), simulator_(scene_) {
    if (GetParam()) scene_.solver.max_newton_iterations = 3;  // too few for some steps, which are then cut
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
    EXPECT_EQ(rollout_.counts.substeps > 0, GetParam());
  }

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
    const std::vector<ParameterId> ids = {{ParameterKind::kFriction, kAllObstacles},
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

INSTANTIATE_TEST_SUITE_P(Scenes, WholeStepsTest, testing::Values(false));
INSTANTIATE_TEST_SUITE_P(Scenes, CheckpointTest, testing::Bool(),
                         [](const auto& test) { return test.param ? "WithSubsteps" : "WholeSteps"; });

TEST(RolloutOptionsTest, StandForTheirCounterpartsInTheScene) {
  const Scene scene = ShippedScene("drape", 8);
  Scene other = scene;
  other.initial_velocities.setConstant(0.1);
  for (const int node : other.handles.nodes) other.initial_velocities.segment<3>(3 * node).setZero();
  other.solver.step_tolerance = 1e-4;
  Simulator simulator(scene), other_simulator(other);
  const Parameters parameters = scene.nominal_parameters();
  RolloutOptions options;
  options.step_tolerance = other.solver.step_tolerance;
  options.initial_velocities = &other.initial_velocities;
  const Rollout rollout = Simulate(parameters, 10, &simulator, nullptr, options);
  const Rollout expected = Simulate(parameters, 10, &other_simulator);
  EXPECT_EQ(rollout.step_tolerance, 1e-4);
  EXPECT_EQ(rollout.initial_velocities, other.initial_velocities);
  EXPECT_EQ(rollout.positions(10), expected.positions(10));
  EXPECT_NE(rollout.positions(10), Simulate(parameters, 10, &simulator).positions(10));
  const Eigen::VectorXd too_few = Eigen::VectorXd::Zero(3);
  options.initial_velocities = &too_few;
  EXPECT_THROW(Simulate(parameters, 10, &simulator, nullptr, options), std::logic_error);
}

// With other parameters the steps start where the solution is not, with the same ones where it is.
TEST(FollowedRolloutTest, KeepsSolutionsAndSubsteps) {
  Scene scene = ShippedScene("drape", 8);
  scene.solver.max_newton_iterations = 3;  // too few for some steps, which are then cut
  Simulator simulator(scene);
  Parameters parameters = scene.nominal_parameters();
  const Rollout first = Simulate(parameters, scene.num_steps(), &simulator);
  ASSERT_TRUE(first.ok()) << first.failure->ToString();
  ASSERT_GT(first.counts.substeps, 0);
  RolloutOptions options;
  options.followed = &first;
  const Rollout same = Simulate(parameters, scene.num_steps(), &simulator, nullptr, options);
  EXPECT_LE(same.counts.newton_iterations, 1.1 * static_cast<double>(first.records.size()));
  EXPECT_EQ(same.last_record, first.last_record);
  EXPECT_LE((same.records.back().positions - first.records.back().positions).norm(), 1e-7 * ClothSize(scene.mesh));

  parameters.material.stretch_stiffness *= 1.0 + 1e-6;
  const Rollout other = Simulate(parameters, scene.num_steps(), &simulator, nullptr, options);
  EXPECT_EQ(other.last_record, first.last_record);
  const double change = (other.records.back().positions - first.records.back().positions).norm();
  EXPECT_GT(change, 0.0);
  EXPECT_LE(change, 1e-4 * ClothSize(scene.mesh));

  options.checkpoint_interval = 9;
  EXPECT_THROW(Simulate(parameters, scene.num_steps(), &simulator, nullptr, options), std::logic_error);
}

// A step that the followed rollout cut finer than the scene allows has no solution here, and the rollout says so.
TEST(FollowedRolloutTest, TooManySubstepsAreAFailure) {
  Scene scene = ShippedScene("drape", 8);
  scene.solver.max_newton_iterations = 3;
  Simulator simulator(scene);
  const Parameters parameters = scene.nominal_parameters();
  const Rollout first = Simulate(parameters, scene.num_steps(), &simulator);
  ASSERT_TRUE(first.ok()) << first.failure->ToString();
  ASSERT_GT(first.counts.substeps, 0);
  scene.solver.max_substep_halvings = 0;
  scene.solver.max_newton_iterations = 100;
  Simulator without_substeps(scene);
  RolloutOptions options;
  options.followed = &first;
  const Rollout rollout = Simulate(parameters, scene.num_steps(), &without_substeps, nullptr, options);
  ASSERT_LT(rollout.num_steps(), scene.num_steps());
  ASSERT_FALSE(rollout.ok());
  EXPECT_EQ(rollout.failure->step, rollout.num_steps() + 1);
  EXPECT_EQ(rollout.counts.failed_steps, 1);
  EXPECT_NE(rollout.failure->ToString().find("2 solves in the rollout that it follows; expected at most 1"),
            std::string::npos)
      << rollout.failure->ToString();
}

// Rollouts whose steps end with factors.
class KeptFactorsTest : public testing::TestWithParam<std::string> {
 protected:
  static constexpr std::size_t kPlenty = std::size_t{1} << 30;  // bytes

  KeptFactorsTest() : simulator_(ShippedScene(GetParam(), 8)) {}

  Rollout Run(std::size_t factor_memory, int checkpoint_interval = 0) {
    RolloutOptions options;
    options.factor_memory = factor_memory;
    options.checkpoint_interval = checkpoint_interval;
    const Scene& scene = simulator_.scene();
    Rollout rollout = Simulate(scene.nominal_parameters(), scene.num_steps(), &simulator_, nullptr, options);
    EXPECT_TRUE(rollout.ok()) << rollout.failure->ToString();
    return rollout;
  }

  RolloutGradient Gradient(const Rollout& rollout, bool use_kept_factors) {
    const auto seed = [](int step, Eigen::MatrixXd* gradient) {
      gradient->col(0).setLinSpaced(1.0 / (1.0 + step), 2.0);
    };
    AdjointOptions options;
    options.use_kept_factors = use_kept_factors;
    // On `slope` the cloth slides without strain: nothing depends on the stiffness.
    const ParameterId id = GetParam() == "wind" ? ParameterId{ParameterKind::kStretchStiffness}
                                                : ParameterId{ParameterKind::kFriction, kAllObstacles};
    return PullBack(rollout, {id}, 1, seed, &simulator_, options);
  }

  static int NumFactors(const Rollout& rollout) {
    int num_factors = 0;
    for (const StepRecord& record : rollout.records) num_factors += record.factor != nullptr;
    return num_factors;
  }

  Simulator simulator_;
};

TEST_P(KeptFactorsTest, GiveTheGradientOfFactorsOfItsOwn) {
  const Rollout rollout = Run(kPlenty);
  EXPECT_EQ(NumFactors(rollout), static_cast<int>(rollout.records.size()));
  const RolloutGradient kept = Gradient(rollout, true), own = Gradient(rollout, false);
  EXPECT_EQ(kept.work.phases.factorization, 0.0);
  EXPECT_GT(own.work.phases.factorization, 0.0);
  EXPECT_EQ(kept.work.failed_solves, 0);
  EXPECT_LE((kept.parameters - own.parameters).norm(), 1e-10 * own.parameters.norm());
  EXPECT_LE((kept.initial_positions - own.initial_positions).norm(), 1e-10 * own.initial_positions.norm());
  EXPECT_LE((kept.initial_velocities - own.initial_velocities).norm(), 1e-10 * own.initial_velocities.norm());
}

TEST_P(KeptFactorsTest, HowManyAreKeptChangesNoStep) {
  const Rollout all = Run(kPlenty);
  const std::size_t without_factors = Run(1).bytes();
  const Rollout some = Run((all.bytes() - without_factors) / 2);
  EXPECT_EQ(NumFactors(Run(1)), 0);
  EXPECT_LT(some.bytes(), all.bytes());
  ASSERT_EQ(some.num_steps(), all.num_steps());
  for (int step = 0; step <= all.num_steps(); ++step) EXPECT_EQ(some.positions(step), all.positions(step));
  const RolloutGradient expected = Gradient(all, true), actual = Gradient(some, true);
  EXPECT_LE((actual.parameters - expected.parameters).norm(), 1e-10 * expected.parameters.norm());
}

TEST_P(KeptFactorsTest, GoWithCheckpoints) {
  const Rollout rollout = Run(kPlenty, 7);
  EXPECT_GT(NumFactors(rollout), 0);
  const RolloutGradient kept = Gradient(rollout, true), own = Gradient(rollout, false);
  EXPECT_LE((kept.parameters - own.parameters).norm(), 1e-10 * own.parameters.norm());
}

INSTANTIATE_TEST_SUITE_P(Scenes, KeptFactorsTest, testing::Values("drape", "slope", "wind"),
                         [](const auto& scene) { return scene.param; });

TEST(CheckpointIntervalTest, FitsTheLimitAndRepeatsAsLittleAsItCan) {
  const Scene scene = ShippedScene("drape", 8);
  Simulator simulator(scene);
  const int num_steps = 1000;
  const auto interval = [&](double limit) {
    return CheckpointInterval(simulator.model(), num_steps, static_cast<std::size_t>(limit));
  };
  const double all = num_steps * (sizeof(StepRecord) + 48.0 * 64 + sizeof(ContactRecord) * 56.0);
  EXPECT_EQ(interval(all), 0);
  // Twice the interval and 1000/interval checkpoints.
  EXPECT_EQ(interval(0.9 * all), 449);
  EXPECT_EQ(interval(0.5 * all), 248);
  EXPECT_EQ(interval(0.1 * all), 36);
  const int least = interval(0);
  EXPECT_EQ(interval(0.05 * all), least);
  EXPECT_NEAR(least, std::sqrt(num_steps / 2.0), 3.0);
}

TEST(CheckpointIntervalTest, AnyIntervalServes) {
  const Scene scene = ShippedScene("wind", 4);
  Simulator simulator(scene);
  const Parameters parameters = scene.nominal_parameters();
  const auto seed = [](int step, Eigen::MatrixXd* gradient) { gradient->setConstant(step); };
  const auto gradient = [&](int interval) {
    RolloutOptions options;
    options.checkpoint_interval = interval;
    const Rollout rollout = Simulate(parameters, 7, &simulator, nullptr, options);
    EXPECT_TRUE(rollout.ok());
    return PullBack(rollout, {{ParameterKind::kStretchStiffness}}, 1, seed, &simulator).parameters(0, 0);
  };
  const double expected = gradient(0);
  for (const int interval : {1, 2, 3, 6, 7, 8, 2147483647}) {
    EXPECT_NEAR(gradient(interval), expected, 1e-5 * std::abs(expected)) << "interval " << interval;
  }
}

}  // namespace
}  // namespace clothid
