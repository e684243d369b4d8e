// Fits with parameters that belong to a recording: its clock, its frame of reference, the start, a drag of its own.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <map>

#include "datasets/motion/motion_file.h"
#include "identify/checks/discretization_check.h"
#include "identify/checks/gradient_check.h"
#include "identify/checks/holdout.h"
#include "identify/checks/multi_start.h"
#include "identify/fit/fit.h"
#include "sim/path/handle_path.h"
#include "tests/costs/synthetic_motion.h"
#include "tests/expect_error.h"

namespace clothid::recording_fit_test {
namespace {

struct Displacement {
  Eigen::Vector3d shift = Eigen::Vector3d::Zero();  // m
  Eigen::Vector3d turn = Eigen::Vector3d::Zero();   // rad
  double delay = 0.0;                               // s: the recording's clock is behind by that
};

// What a sensor of another clock and frame of reference sees of `scene`: frames at `times` of its own clock, the cloth
// at the scene's. Positions between steps are those of a C1 cubic, as handles move.
RecordedMotion Displaced(const Scene& scene, const Parameters& truth, const Eigen::VectorXd& times,
                         const Displacement& displacement) {
  Simulator simulator(scene);
  const int num_steps =
      static_cast<int>((times[times.size() - 1] + std::abs(displacement.delay)) / scene.time_step) + 3;
  const Rollout rollout = Simulate(truth, num_steps, &simulator);
  EXPECT_TRUE(rollout.ok()) << rollout.failure->ToString();
  Eigen::MatrixXd states(3 * scene.mesh.num_nodes(), num_steps + 1);
  for (int step = 0; step <= num_steps; ++step) states.col(step) = rollout.positions(step);
  const HandlePath path(Eigen::VectorXd::LinSpaced(num_steps + 1, 0.0, num_steps * scene.time_step), states);

  MotionOptions options;
  options.frame_interval = times[1] - times[0];
  RecordedMotion motion = MakeMotion(scene, options);
  motion.times = times;
  motion.positions.resize(states.rows(), times.size());
  for (Eigen::Index i = 0; i < times.size(); ++i) motion.positions.col(i) = path.At(times[i] + displacement.delay);
  const Eigen::Vector3d center = TurnCenter(motion);
  const double angle = displacement.turn.norm();
  const Eigen::Matrix3d rotation = angle > 0.0 ? Eigen::AngleAxisd(angle, displacement.turn / angle).toRotationMatrix()
                                               : Eigen::Matrix3d::Identity();
  for (Eigen::Index i = 0; i < times.size(); ++i) {
    for (Eigen::Index row = 0; row < states.rows(); row += 3) {
      const Eigen::Vector3d position = motion.positions.block<3, 1>(row, i);
      motion.positions.block<3, 1>(row, i) = rotation * (position - center) + center + displacement.shift;
    }
  }
  return motion;
}

FitOptions OptionsFor(std::vector<std::string> parameters, std::vector<std::string> each = {}) {
  FitOptions options;
  options.parameters = std::move(parameters);
  options.each = std::move(each);
  return options;
}

FitSummary RunFit(const std::vector<RecordedMotion>& motions, const FitOptions& options) {
  FitProblem problem(motions, options);
  return Fit(options, &problem);
}

std::map<std::string, double> ValuesOf(const FitSummary& summary) {
  std::map<std::string, double> values;
  for (const FittedParameter& parameter : summary.parameters) values[parameter.name] = parameter.value;
  return values;
}

double StdOf(const FitSummary& summary, const std::string& name) {
  for (std::size_t i = 0; i < summary.parameters.size(); ++i) {
    if (summary.parameters[i].name == name) return summary.uncertainty->parameters[i].std;
  }
  ADD_FAILURE() << name;
  return 0.0;
}

Parameters ParametersOf(const Scene& scene, const std::map<std::string, double>& values) {
  Parameters parameters = scene.nominal_parameters();
  for (const auto& [name, value] : values) {
    SetParameter(ParseParameter(name, scene.obstacle_names()), value, &parameters);
  }
  return parameters;
}

std::vector<std::string> Names(const FitProblem& problem) {
  std::vector<std::string> names;
  for (const ParameterBlock& block : problem.blocks()) names.push_back(block.name);
  return names;
}

// The shipped drape, seen 3 mm off, turned by 0.02 rad and 7 ms late.
TEST(RecordingFitTest, FrictionAndStiffnessOfADisplacedDrape) {
  const RecordedMotion drape = ReadMotion(CLOTHID_SOURCE_DIR "/datasets/drape.motion.bin");
  const Eigen::Vector3d turn = 0.02 * Eigen::Vector3d(1.0, 2.0, -2.0) / 3.0;
  const Displacement displacement{{3e-3, -2e-3, 1e-3}, turn, 7e-3};
  const RecordedMotion motion = Displaced(drape.scene, ParametersOf(drape.scene, {{"mu", 0.24}, {"k_stretch", 70.0}}),
                                          Eigen::VectorXd::LinSpaced(81, 0.0, 0.8), displacement);

  FitOptions options = OptionsFor({"mu", "k_stretch"});
  options.estimate_uncertainty = false;
  options.overrides.start = {{"mu", 0.3}, {"k_stretch", 100.0}};
  const FitSummary plain = RunFit({motion}, options);
  EXPECT_EQ(plain.status, FitStatus::kConverged) << plain.message;
  EXPECT_GT(std::abs(ValuesOf(plain).at("k_stretch") - 70.0), 0.02 * 70.0) << "the set-up ends in the stiffness";
  EXPECT_GT(plain.error.rmse(), 1e-3);

  options.parameters = {"mu", "k_stretch", "align", "time_offset"};
  const FitSummary fit = RunFit({motion}, options);
  for (const auto& [name, value] : ValuesOf(fit)) RecordProperty(name, std::to_string(value));
  for (const auto& [name, value] : ValuesOf(plain)) RecordProperty("plain_" + name, std::to_string(value));
  RecordProperty("plain_rmse", std::to_string(plain.error.rmse()));
  RecordProperty("rollouts", std::to_string(plain.statistics.rollouts) + "+" + std::to_string(fit.statistics.rollouts));
  EXPECT_EQ(fit.status, FitStatus::kConverged) << fit.message;
  const std::map<std::string, double> values = ValuesOf(fit);
  EXPECT_NEAR(values.at("mu"), 0.24, 1e-3 * 0.24);
  EXPECT_NEAR(values.at("k_stretch"), 70.0, 1e-3 * 70.0);
  EXPECT_NEAR(values.at("time_offset"), 7e-3, 1e-6);
  EXPECT_NEAR(values.at("turn.x"), turn[0], 1e-6);
  EXPECT_NEAR(values.at("turn.y"), turn[1], 1e-6);
  EXPECT_NEAR(values.at("turn.z"), turn[2], 1e-6);
  // The centroid that the fit turns about is that of the displaced points, off by (1 - R) shift.
  EXPECT_NEAR(values.at("shift.x"), 3e-3, 1e-4);
  EXPECT_NEAR(values.at("shift.y"), -2e-3, 1e-4);
  EXPECT_NEAR(values.at("shift.z"), 1e-3, 1e-4);
  EXPECT_LT(fit.error.rmse(), 1e-6);
  EXPECT_LT((fit.predicted[0] - motion.positions).cwiseAbs().maxCoeff(), 1e-5) << "in the recording's frame";
}

class EveryMethodTest : public testing::TestWithParam<JacobianMethod> {};

INSTANTIATE_TEST_SUITE_P(Methods, EveryMethodTest,
                         testing::Values(JacobianMethod::kAdjoint, JacobianMethod::kSensitivity,
                                         JacobianMethod::kNumeric));

TEST_P(EveryMethodTest, FindsTheClockTheFrameAndTheStart) {
  Scene scene = SphereScene();
  const Displacement displacement{{2e-3, 1e-3, -1e-3}, Eigen::Vector3d::Zero(), -4e-3};
  const Eigen::Vector3d velocity(0.2, 0.0, 0.0);
  for (int node = 5; node < scene.mesh.num_nodes(); ++node) scene.initial_velocities.segment<3>(3 * node) = velocity;
  RecordedMotion motion = Displaced(scene, ParametersOf(scene, {{"mu", 0.35}, {"k_stretch", 80.0}}),
                                    Eigen::VectorXd::LinSpaced(19, 0.02, 0.2), displacement);
  motion.scene.initial_velocities.setZero();

  FitOptions options = OptionsFor({"mu", "k_stretch", "time_offset", "shift", "v0"});
  options.jacobian = GetParam();
  options.max_iterations = 300;
  const FitSummary fit = RunFit({motion}, options);
  EXPECT_EQ(fit.status, FitStatus::kConverged) << fit.message;
  const std::map<std::string, double> values = ValuesOf(fit);
  const double tolerance = 1e-5;
  EXPECT_NEAR(values.at("mu"), 0.35, tolerance * 0.35);
  EXPECT_NEAR(values.at("k_stretch"), 80.0, tolerance * 80.0);
  EXPECT_NEAR(values.at("time_offset"), -4e-3, tolerance * 1e-2);
  EXPECT_NEAR(values.at("shift.x"), 2e-3, tolerance * 1e-2);
  EXPECT_NEAR(values.at("v0.x"), 0.2, tolerance);
  EXPECT_NEAR(values.at("v0.y"), 0.0, tolerance);
  EXPECT_NEAR(values.at("v0.z"), 0.0, tolerance);
}

TEST(RecordingFitTest, RecordingsHaveADragOfTheirOwn) {
  std::vector<RecordedMotion> motions;
  for (const double drag : {0.05, 0.3}) {
    MotionOptions truth;
    truth.true_values = {{"k_stretch", 90.0}, {"drag", drag}};
    motions.push_back(MakeMotion(SwingScene(), truth));
  }
  FitOptions options = OptionsFor({"k_stretch"}, {"drag"});
  const FitSummary one = RunFit(motions, options);
  EXPECT_EQ(one.status, FitStatus::kConverged) << one.message;
  const std::map<std::string, double> values = ValuesOf(one);
  ASSERT_EQ(values.size(), 3u);
  EXPECT_NEAR(values.at("k_stretch"), 90.0, 1e-3);
  EXPECT_NEAR(values.at("drag@1"), 0.05, 1e-6);
  EXPECT_NEAR(values.at("drag@2"), 0.3, 1e-6);
  for (const ParameterUncertainty& parameter : one.uncertainty->parameters) EXPECT_TRUE(parameter.identifiable);

  options.num_threads = 2;
  const FitSummary two = RunFit(motions, options);
  EXPECT_EQ(two.coordinates, one.coordinates);
  EXPECT_EQ(two.cost, one.cost);
  const FitSummary shared = RunFit(motions, OptionsFor({"k_stretch", "drag"}));
  EXPECT_GT(shared.error.rmse(), 1e-3) << "one drag does not explain both";
}

// What has to be told from the recording as well leaves less of it for the rest.
TEST(RecordingFitTest, IntervalsGrowWithTheirNumber) {
  MotionOptions truth;
  truth.true_values = {{"mu", 0.35}, {"k_stretch", 80.0}};
  truth.noise = truth.sigma = 1e-3;
  const RecordedMotion motion = MakeMotion(SphereScene(), truth);
  const FitSummary plain = RunFit({motion}, OptionsFor({"mu", "k_stretch"}));
  const FitSummary aligned = RunFit({motion}, OptionsFor({"mu", "k_stretch", "align", "time_offset", "v0"}));
  EXPECT_EQ(aligned.status, FitStatus::kConverged) << aligned.message;
  for (const char* name : {"mu", "k_stretch"}) {
    RecordProperty(name, std::to_string(StdOf(aligned, name) / StdOf(plain, name)));
    EXPECT_GT(StdOf(aligned, name), 1.05 * StdOf(plain, name)) << name;
    const double distance = std::abs(ValuesOf(aligned).at(name) - truth.true_values.at(name));
    EXPECT_LT(distance, 4.0 * StdOf(aligned, name)) << name;
  }
}

TEST(RecordingFitTest, BlocksOfEachRecordingAreItsOwn) {
  const std::vector<RecordedMotion> motions = {MakeMotion(SwingScene(), {}), MakeMotion(SphereScene(), {})};
  FitOptions options = OptionsFor({"k_stretch", "mu"}, {"mu", "time_offset"});
  options.overrides.start = {{"time_offset@2", 1e-3}, {"k_stretch", 60.0}};
  options.overrides.upper_bounds = {{"time_offset", 5e-3}};
  const FitProblem problem(motions, options);
  EXPECT_EQ(Names(problem), (std::vector<std::string>{"k_stretch", "mu@2", "time_offset@1", "time_offset@2"}));
  EXPECT_EQ(problem.block_indices(0), (std::vector<int>{0, 2}));
  EXPECT_EQ(problem.block_indices(1), (std::vector<int>{0, 1, 3}));
  EXPECT_EQ(problem.blocks()[2].start, 0.0);
  EXPECT_EQ(problem.blocks()[3].start, 1e-3);
  EXPECT_EQ(problem.blocks()[2].upper_bound, 5e-3);
  EXPECT_EQ(Names(FitProblem({motions[1]}, OptionsFor({}, {"time_offset"}))),
            (std::vector<std::string>{"mu", "k_stretch", "time_offset"}));
  EXPECT_EQ(Names(FitProblem(motions, OptionsFor({"align"}))).size(), 6u);

  const auto expect = [&](const FitOptions& refused, const char* culprit) {
    ExpectError([&] { FitProblem(motions, refused); }, ErrorKind::kUsage, {culprit});
  };
  expect(OptionsFor({"drag@2"}), "--fit: 'drag@2'");
  expect(OptionsFor({"drag"}, {"drag@2"}), "--each: 'drag@2'");
  expect(OptionsFor({"shift", "shift.x"}), "--fit: 'shift.x' is given twice");
  expect(OptionsFor({"mu"}, {"mu.ball"}), "mu.ball");
  expect(OptionsFor({}, {"weight"}), "weight");
  options.overrides.start = {{"time_offset@3", 0.0}};
  expect(options, "--start: 'time_offset@3'");
}

TEST(RecordingFitTest, GradientsAreCheckedAndStartsAreSpread) {
  MotionOptions truth;
  truth.true_values = {{"k_stretch", 80.0}};
  truth.noise = 1e-3;
  const std::vector<RecordedMotion> motions = {MakeMotion(SwingScene(), truth)};
  FitOptions options = OptionsFor({"k_stretch", "time_offset", "turn", "v0"});
  options.overrides.start = {{"time_offset", 3e-3}, {"turn.x", -0.01}};
  const GradientCheck check = CheckGradients(motions, options);
  EXPECT_LT(check.adjoint_vs_sensitivity, 1e-8);
  EXPECT_LT(check.adjoint_vs_fd, 1e-4);

  const FitProblem problem(motions, options);
  for (const Eigen::VectorXd& point : StartPoints(problem.blocks(), 5, 1)) {
    for (int i = 0; i < problem.num_blocks(); ++i) {
      const ParameterBlock& block = problem.blocks()[i];
      EXPECT_GE(block.ToValue(point[i]), block.lower_bound);
      EXPECT_LE(block.ToValue(point[i]), block.upper_bound);
    }
  }
}

TEST(RecordingFitTest, ChangesAtHalfTheStepAreInTheirUnits) {
  MotionOptions truth;
  truth.true_values = {{"k_stretch", 80.0}};
  const RecordedMotion motion = MakeMotion(SwingScene(), truth);
  const FitOptions options = OptionsFor({"k_stretch", "v0"});
  FitProblem problem({motion}, options);
  FitSummary summary = Fit(options, &problem);
  const RepeatedFit check = *CheckDiscretization({motion}, options, {true, false}, problem, &summary).half_step;
  ASSERT_EQ(check.changes.size(), 4);
  for (int i = 1; i < 4; ++i) EXPECT_NEAR(check.changes[i], check.values[i] - summary.parameters[i].value, 1e-12);
}

// Held-out recordings take what is shared, and the mean of what fitted recordings have for themselves: that is the best
// guess of their own. Held-out frames belong to their recording.
TEST(RecordingFitTest, HeldOutMeasurementsTakeWhatConcernsThem) {
  MotionOptions truth;
  truth.true_values = {{"k_stretch", 80.0}};
  RecordedMotion motion = MakeMotion(SwingScene(), truth);
  for (Eigen::Index row = 0; row < motion.positions.rows(); row += 3) motion.positions.row(row).array() += 0.01;
  const Eigen::Vector2d values(80.0, 0.01);
  const auto holdout = [&](std::vector<std::string> fit, std::vector<std::string> each, HeldOut held_out) {
    const FitProblem problem({motion}, OptionsFor(std::move(fit), std::move(each)));
    return EvaluateHoldout({motion}, problem.blocks(), values, held_out);
  };
  EXPECT_LT(holdout({"k_stretch", "shift.x"}, {}, HeldOut::kRecordings).rmse, 1e-9);
  EXPECT_LT(holdout({"k_stretch"}, {"shift.x"}, HeldOut::kRecordings).rmse, 1e-9);
  EXPECT_LT(holdout({"k_stretch"}, {"shift.x"}, HeldOut::kFrames).rmse, 1e-9);

  const FitProblem two({motion, motion}, OptionsFor({"k_stretch"}, {"shift.x"}));
  const Eigen::Vector3d of_two(80.0, 0.004, 0.016);
  EXPECT_LT(EvaluateHoldout({motion}, two.blocks(), of_two, HeldOut::kRecordings).rmse, 1e-9);
  EXPECT_NEAR(EvaluateHoldout({motion, motion}, two.blocks(), of_two, HeldOut::kFrames).rmse, 0.006, 1e-6);
  const HeldOutBlocks like = BlocksFor(motion, -1, two.blocks(), of_two, 1);
  ASSERT_EQ(like.blocks.size(), 2u);
  EXPECT_NEAR(like.blocks[1].ToValue(like.coordinates[1]), 0.016, 1e-12) << "that of the second";

  std::vector<RecordedMotion> fitted = {motion};
  const std::vector<RecordedMotion> held = HoldOutFrames({5, 8}, &fitted);
  EXPECT_EQ(TurnCenter(held[0]), TurnCenter(motion));
  EXPECT_EQ(TurnCenter(fitted[0]), TurnCenter(motion));
}

}  // namespace
}  // namespace clothid::recording_fit_test
