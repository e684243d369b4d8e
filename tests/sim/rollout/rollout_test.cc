// What a rollout keeps: contacts from which the solver's own come back, and factors; and what it is told to do.
#include "sim/rollout/rollout.h"

#include <gtest/gtest.h>

#include <stdexcept>
#include <string>
#include <tuple>
#include <vector>

#include "sim/cloth/cloth_model.h"
#include "sim/derivative/adjoint.h"
#include "sim/derivative/sensitivity.h"
#include "sim/rollout/record_reader.h"
#include "sim/rollout/simulator.h"
#include "sim/step/step_problem.h"
#include "sim/step/step_solver.h"
#include "tests/sim/joined_mesh.h"
#include "tests/sim/plain_scenes.h"
#include "tests/sim/shipped_scenes.h"

namespace clothid::rollout_test {
namespace {

class StoredContactsTest : public testing::TestWithParam<std::tuple<std::string, ContactMode, Integrator>> {};

TEST_P(StoredContactsTest, BringBackThoseOfTheSolver) {
  Scene scene = ShippedScene(std::get<0>(GetParam()), 10);
  scene.contact_mode = std::get<1>(GetParam());
  scene.integrator = std::get<2>(GetParam());
  scene.material.damping = 0.01;
  Simulator simulator(scene);
  const Rollout rollout = Simulate(scene.nominal_parameters(), scene.num_steps(), &simulator);
  ASSERT_TRUE(rollout.ok()) << rollout.failure->ToString();
  RecordReader reader(rollout, &simulator);
  StepPoint point;
  std::size_t num_contacts = 0;
  for (std::size_t i = 0; i < rollout.records.size(); ++i) {
    const StepRecord& record = rollout.records[i];
    const SolveStart start = reader.start(static_cast<int>(i));
    const StepProblem problem(simulator.model(), rollout.parameters, start, record.times(),
                              &simulator.step_workspace());
    problem.Evaluate(simulator.model().Gather(record.velocities), &point);
    const std::vector<Contact> solved = problem.ContactsAt(point).nodes;
    const std::vector<Contact> restored =
        RestoreContacts(record, start.positions, {}, rollout.parameters, simulator.model()).nodes;
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
      EXPECT_EQ(restored[j].response.branch, record.contacts.nodes[j].branch);
      EXPECT_EQ(restored[j].response.impulse, solved[j].response.impulse);
      EXPECT_EQ(restored[j].response.slip_direction, solved[j].response.slip_direction);
    }
  }
  EXPECT_GT(num_contacts, 100u);
}

INSTANTIATE_TEST_SUITE_P(Scenes, StoredContactsTest,
                         testing::Combine(testing::Values("drape", "slope"),
                                          testing::Values(ContactMode::kGap, ContactMode::kVelocity),
                                          testing::Values(Integrator::kEuler, Integrator::kSdirk2)),
                         [](const auto& test) {
                           const bool gap = std::get<1>(test.param) == ContactMode::kGap;
                           return std::get<0>(test.param) + (gap ? "Gap" : "Velocity") +
                                  (std::get<2>(test.param) == Integrator::kEuler ? "" : "Sdirk2");
                         });

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

// Rollouts whose steps end with factors.
class KeptFactorsTest : public testing::TestWithParam<std::tuple<std::string, Integrator>> {
 protected:
  static constexpr std::size_t kPlenty = std::size_t{1} << 30;  // bytes

  KeptFactorsTest() : simulator_(MakeScene()) {}

  static Scene MakeScene() {
    Scene scene = ShippedScene(std::get<0>(GetParam()), 8);
    scene.integrator = std::get<1>(GetParam());
    return scene;
  }

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
    const ParameterId id = std::get<0>(GetParam()) == "wind" ? ParameterId{ParameterKind::kStretchStiffness}
                                                             : ParameterId{ParameterKind::kFriction};
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

INSTANTIATE_TEST_SUITE_P(Scenes, KeptFactorsTest,
                         testing::Combine(testing::Values("drape", "slope", "wind"),
                                          testing::Values(Integrator::kEuler, Integrator::kSdirk2)),
                         [](const auto& test) {
                           return std::get<0>(test.param) +
                                  (std::get<1>(test.param) == Integrator::kEuler ? "" : "Sdirk2");
                         });

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

TEST(CheckpointIntervalTest, CountsTheStagesOfAStep) {
  Scene scene = ShippedScene("drape", 8);
  scene.integrator = Integrator::kSdirk2;
  Simulator simulator(scene);
  const double all = 2.0 * 1000 * (sizeof(StepRecord) + 48.0 * 64 + sizeof(ContactRecord) * 56.0);
  EXPECT_EQ(CheckpointInterval(simulator.model(), 1000, static_cast<std::size_t>(all)), 0);
  EXPECT_EQ(CheckpointInterval(simulator.model(), 1000, static_cast<std::size_t>(0.5 * all)), 248);
}

TEST(CheckpointIntervalTest, CountsPairsOfTheClothWithItself) {
  Scene scene = ShippedScene("drape", 8);
  scene.self_contact = SelfContact{0.3, 0.002};
  Simulator simulator(scene);
  const double all =
      1000 * (sizeof(StepRecord) + 48.0 * 64 + (sizeof(ContactRecord) + sizeof(PairContactRecord)) * 56.0);
  EXPECT_EQ(CheckpointInterval(simulator.model(), 1000, static_cast<std::size_t>(all)), 0);
  EXPECT_EQ(CheckpointInterval(simulator.model(), 1000, static_cast<std::size_t>(0.5 * all)), 248);
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

// Some steps of a large sheet, with derivatives both ways.
struct SharedWork {
  SharedWork(const Scene& scene, ParameterId friction, int num_threads) {
    Simulator simulator(scene);
    simulator.SetNumThreads(num_threads);
    EXPECT_EQ(simulator.step_solver().jacobian().has_team(), num_threads > 1);
    const Parameters parameters = simulator.scene().nominal_parameters();
    const std::vector<ParameterId> ids = {friction, {ParameterKind::kStretchStiffness}};
    const Rollout rollout = Simulate(parameters, 4, &simulator);
    positions = rollout.positions(4);
    num_pairs = rollout.counts.self_contacts;
    SensitivityDirections directions;
    directions.parameters = ids;
    PushForward(
        rollout, directions, [&](int, const Eigen::VectorXd&, const Eigen::MatrixXd& columns) { forward = columns; },
        &simulator);
    const auto add = [](int step, Eigen::MatrixXd* columns) { columns->array() += step; };
    gradient = PullBack(rollout, ids, 3, add, &simulator).parameters;
  }

  Eigen::VectorXd positions;
  Eigen::MatrixXd forward, gradient;
  int num_pairs = 0;  // in contact, over all steps
};

// Returns the pairs of one.
int ExpectTheBytesOfOneThread(const Scene& scene, ParameterId friction) {
  const SharedWork alone(scene, friction, 1);
  EXPECT_GT(alone.forward.norm(), 0.0);
  EXPECT_GT(alone.gradient.norm(), 0.0);
  for (const int num_threads : {2, 3}) {
    const SharedWork shared(scene, friction, num_threads);
    EXPECT_EQ(shared.positions, alone.positions) << num_threads;
    EXPECT_EQ(shared.forward, alone.forward) << num_threads;
    EXPECT_EQ(shared.gradient, alone.gradient) << num_threads;
  }
  return alone.num_pairs;
}

TEST(SharedWorkTest, ThreadsDoNotChangeAByte) {
  ExpectTheBytesOfOneThread(ShippedScene("slope", 72), {ParameterKind::kFriction, 0, 0});
}

// A small sheet falls on a large one, both free.
TEST(SharedWorkTest, NorDoTheyWhereTheClothTouchesItself) {
  const GridOptions lower = SquareGrid(72, 0.72);
  GridOptions upper = SquareGrid(7, 0.06);
  upper.origin = {0.313, 0.307, 0.004};
  Scene scene = ClothScene(lower, 0.005);
  scene.mesh = JoinedMesh({MakeGrid(lower), MakeGrid(upper)});
  scene.initial_positions = scene.mesh.rest_positions.reshaped();
  scene.initial_velocities = Eigen::VectorXd::Zero(scene.initial_positions.size());
  for (int node = 72 * 72; node < scene.mesh.num_nodes(); ++node) {
    scene.initial_velocities.segment<3>(3 * node) << 0.1, 0.05, -0.3;
  }
  scene.self_contact = SelfContact{0.3, 0.003};
  EXPECT_GT(ExpectTheBytesOfOneThread(scene, {ParameterKind::kSelfFriction}), 0);
}

// Where threads would gain nothing none is started.
TEST(SharedWorkTest, ASmallSceneHasNoTeam) {
  Simulator simulator(ShippedScene("slope", 20));
  simulator.SetNumThreads(2);
  EXPECT_FALSE(simulator.step_solver().jacobian().has_team());
}

}  // namespace
}  // namespace clothid::rollout_test
