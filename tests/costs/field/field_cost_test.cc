// Fields as unknowns beside those of a start, parameters and forces: derivatives every way, products, and journals.
#include <gtest/gtest.h>
#include <stdlib.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "costs/field/field_request.h"
#include "costs/field/field_unknowns.h"
#include "costs/rollout_cost.h"
#include "costs/rows/evaluation_journal.h"
#include "tests/costs/synthetic_forces.h"
#include "tests/costs/synthetic_motion.h"

namespace clothid::field_cost_test {
namespace {

constexpr double kNoise = 1e-3;  // m

std::vector<FieldRequest> Requests() { return ParseFieldRequests("k_stretch:3x3,density:2x2,k_bend:2x2"); }

// A cloth that is shaken at two corners and has its fields, the same everywhere; frames lie between steps.
RecordedMotion ShakenMotion() {
  Scene scene = Shaken(SwingScene());
  scene.material.damping = 0.01;
  scene.solver.step_tolerance = 1e-12;
  scene.solver.adjoint_tolerance = 1e-14;
  MotionOptions options;
  options.noise = options.sigma = kNoise;
  options.frame_interval = 0.013;
  std::vector<RecordedMotion> motions = {MakeMotion(scene, options)};
  for (const FieldRequest& request : Requests()) {
    const double level = GetParameter(scene.nominal_parameters(), {request.kind});
    SetField({request.kind, Eigen::MatrixXd::Constant(request.rows, request.columns, level)}, &motions);
  }
  ForceOptions forces;
  forces.groups = {{0}, {4}};
  forces.true_values = {{"k_stretch", 60.0}};
  forces.noise = forces.sigma = 1e-2;
  AddForces(forces, &motions.front());
  return motions.front();
}

struct Case {
  const char* name;
  bool start_is_unknown;
  const char* loss;
  bool errs = false;  // the model, of points and of forces
};

// Of another size in every frame.
ModelError SomeError() {
  ModelError error;
  error.CurveOf(PredictedKind::kPoints) = {Eigen::Vector3d(0.0, 0.05, 0.2), Eigen::Vector3d(0.0, 1e-6, 5e-6), 20.0};
  error.CurveOf(PredictedKind::kForces) = {Eigen::Vector2d(0.0, 0.2), Eigen::Vector2d(0.0, 1e-4), 3.0};
  return error;
}

RecordedMotion MotionOf(const Case& test) {
  RecordedMotion motion = ShakenMotion();
  if (!test.start_is_unknown) return motion;
  motion.start_source = StartSource::kMoving;
  motion.handle_measurements.times = Eigen::VectorXd::LinSpaced(18, 0.0, 0.2);
  motion.handle_measurements.deviations = kNoise * Eigen::MatrixXd::Ones(6, 18);
  motion.handle_measurements.sigma = Eigen::VectorXd::Constant(2, kNoise);
  return motion;
}

std::vector<ParameterBlock> Blocks(const RecordedMotion& motion) {
  std::vector<ParameterBlock> blocks;
  for (const char* name : {"handle_shift.y", "k_stretch", "time_offset", "v0.x", "drag"}) {
    blocks.push_back(MakeParameterBlock(name, motion, {}));
  }
  return blocks;
}

RolloutCostOptions OptionsOf(const Case& test) {
  RolloutCostOptions options;
  options.fields = Requests();
  options.loss = ParseRobustLoss(test.loss);
  return options;
}

Eigen::VectorXd SomePoint(const RecordingModel& model) {
  std::srand(3);
  Eigen::VectorXd point(model.num_coordinates());
  point << StartOf(model.blocks()), 2e-4 * Eigen::VectorXd::Random(model.num_start_unknowns()),
      0.2 * Eigen::VectorXd::Random(model.num_field_unknowns());
  point[0] += 0.05;
  point[2] += 0.1;
  point[3] += 0.02;
  return point;
}

double CostAt(const RolloutCost& cost, const Eigen::VectorXd& point) {
  double value = 0.0;
  EXPECT_TRUE(cost.EvaluateGradient(point, &value, nullptr)) << cost.last_failure();
  return value;
}

Eigen::MatrixXd AllUnknowns(const RecordingModel& model) {
  return Eigen::MatrixXd::Identity(model.num_unknowns(), model.num_unknowns());
}

class FieldCostTest : public ::testing::TestWithParam<Case> {
 protected:
  FieldCostTest() {
    if (GetParam().errs) cost_.SetModelError(SomeError());
  }

  const RecordedMotion motion_ = MotionOf(GetParam());
  RolloutCost cost_{motion_, Blocks(motion_), OptionsOf(GetParam())};
  const RecordingModel& model_ = cost_.model();
  const Eigen::VectorXd point_ = SomePoint(model_);

  // The rows of the recording itself.
  Eigen::MatrixXd WithoutPrior(const Eigen::MatrixXd& rows) const {
    const UnknownStart* const start = model_.unknown_start();
    return rows.topRows(rows.rows() - (start == nullptr ? 0 : start->prior_jacobian().rows()));
  }
  // Of forward rows along all unknowns: the many columns of a start are made to kStartAdjointTolerance.
  double RowTolerance() const { return GetParam().start_is_unknown ? 1e-2 : 1e-6; }
};

TEST_P(FieldCostTest, CoordinatesAreBlocksThenStartThenFields) {
  EXPECT_EQ(model_.num_field_unknowns(), 17);
  EXPECT_EQ(model_.num_unknowns(), model_.num_start_unknowns() + 17);
  EXPECT_EQ(model_.num_coordinates(), 5 + model_.num_unknowns());
  std::vector<std::int32_t> sizes(5, 1);
  if (GetParam().start_is_unknown) sizes.push_back(model_.num_start_unknowns());
  sizes.push_back(17);
  EXPECT_EQ(cost_.parameter_block_sizes(), sizes);
  Eigen::VectorXd without = point_;
  without.tail(17).setZero();
  const Eigen::VectorXd shorter = point_.head(point_.size() - 17);
  const auto fields = [&](const Eigen::VectorXd& at) { return model_.ParametersAt(at).fields->front().log_factors; };
  EXPECT_EQ(fields(shorter), fields(without));
  EXPECT_EQ(model_.StartUnknowns(shorter), model_.StartUnknowns(point_));
  EXPECT_NE(fields(point_), fields(without));
}

TEST_P(FieldCostTest, GradientIsThatOfDifferences) {
  double value = 0.0;
  Eigen::VectorXd gradient;
  ASSERT_TRUE(cost_.EvaluateGradient(point_, &value, &gradient)) << cost_.last_failure();
  const int num_start = model_.num_start_unknowns();
  int first = 0;
  for (const int size : {1, 1, 1, 1, 1, num_start, 9, 4, 4}) {
    if (size == 0) continue;
    Eigen::VectorXd direction = Eigen::VectorXd::Zero(point_.size());
    direction.segment(first, size) = Eigen::VectorXd::LinSpaced(size, 0.3, 17.0).array().cos();
    const bool is_start = first == 5 && num_start > 0;
    if (is_start) direction *= 1e-2;
    first += size;
    double best = 1.0;
    for (const double step : {1e-4, 1e-5, 1e-6}) {
      if (best <= 1e-5) break;
      const double difference =
          (CostAt(cost_, point_ + step * direction) - CostAt(cost_, point_ - step * direction)) / (2.0 * step);
      best = std::min(best, std::abs(difference / gradient.dot(direction) - 1.0));
    }
    EXPECT_LE(best, 1e-5) << "up to coordinate " << first;
  }
  ASSERT_EQ(first, point_.size());
}

TEST_P(FieldCostTest, RowsGiveTheGradient) {
  double value = 0.0;
  Eigen::VectorXd gradient, residuals;
  Eigen::MatrixXd jacobian, scores;
  ASSERT_TRUE(cost_.EvaluateGradient(point_, &value, &gradient));
  const CostStatistics before = cost_.statistics();
  // Few columns, each of which moves start and fields at once.
  const Eigen::MatrixXd few = 1e-2 * Eigen::MatrixXd::Random(model_.num_unknowns(), 3);
  ASSERT_TRUE(cost_.Linearize(point_, few, &jacobian, &residuals, &scores));
  EXPECT_EQ(cost_.statistics().rollouts, before.rollouts) << "the rollout is at hand";
  EXPECT_EQ(cost_.statistics().sweeps, before.sweeps + 1);
  Eigen::VectorXd expected(8);
  expected << gradient.head(5), few.transpose() * gradient.tail(few.rows());
  EXPECT_LE((jacobian.transpose() * residuals - expected).cwiseQuotient(expected).cwiseAbs().maxCoeff(), 1e-10);
  Eigen::VectorXd summed = scores.rowwise().sum();
  if (const UnknownStart* const start = model_.unknown_start()) {
    summed.tail(3) += (start->prior_jacobian() * few.topRows(start->size())).transpose() *
                      start->PriorResiduals(model_.StartUnknowns(point_));
  }
  EXPECT_LE((summed - expected).norm(), 1e-10 * expected.norm());
  // The same point along others is no other evaluation, and along the same ones it is known.
  ASSERT_TRUE(cost_.Linearize(point_, few, &jacobian, &residuals));
  EXPECT_EQ(cost_.statistics().sweeps, before.sweeps + 1);
  ASSERT_TRUE(cost_.Linearize(point_, AllUnknowns(model_), &jacobian, &residuals));
  EXPECT_EQ(cost_.statistics().sweeps, before.sweeps + 2);
  EXPECT_LE((jacobian.transpose() * residuals - gradient).norm(), RowTolerance() * gradient.norm());
  ASSERT_TRUE(cost_.Linearize(point_, {}, &jacobian, &residuals));
  EXPECT_LE((jacobian.transpose() * residuals - gradient.head(5)).norm(), 1e-10 * gradient.head(5).norm());
}

// Along blocks and a few combinations W, whose rows are as exact as products: W^T (J^T J W d) = (J W)^T (J W) d.
TEST_P(FieldCostTest, ProductsAreThoseOfTheRows) {
  std::srand(9);
  Eigen::MatrixXd few = Eigen::MatrixXd::Random(model_.num_unknowns(), 20);
  few.leftCols(3).setZero();  // an unknown of the first group, of its end, and of a field
  few(0, 0) = few(model_.num_unknowns() - 18 + (GetParam().start_is_unknown ? 0 : 1), 1) = few(few.rows() - 3, 2) = 1.0;
  Eigen::VectorXd residuals, product;
  Eigen::MatrixXd along;
  ASSERT_TRUE(cost_.Linearize(point_, few, &along, &residuals));
  const Eigen::MatrixXd jacobian = WithoutPrior(along);
  const CostStatistics before = cost_.statistics();
  for (const int column : {-1, 1, 2, 5, 6, 7, 12}) {
    Eigen::VectorXd weights = Eigen::VectorXd::Random(25);
    if (column >= 0) weights = Eigen::VectorXd::Unit(25, column);
    Eigen::VectorXd direction(point_.size()), own(25);
    direction << weights.head(5), few * weights.tail(20);
    ASSERT_TRUE(cost_.TimesCurvature(point_, direction, &product)) << cost_.last_failure();
    own << product.head(5), few.transpose() * product.tail(few.rows());
    const Eigen::VectorXd expected = jacobian.transpose() * (jacobian * weights);
    EXPECT_LE((own - expected).norm(), 1e-4 * expected.norm()) << column;
  }
  EXPECT_EQ(cost_.statistics().rollouts, before.rollouts);
  EXPECT_EQ(cost_.statistics().sweeps, before.sweeps + 1 + 7 * 2);
}

// And along all unknowns at once.
TEST_P(FieldCostTest, ProductsAreThoseOfAllRows) {
  Eigen::VectorXd residuals, product;
  Eigen::MatrixXd all;
  ASSERT_TRUE(cost_.Linearize(point_, AllUnknowns(model_), &all, &residuals));
  const Eigen::MatrixXd jacobian = WithoutPrior(all);
  const Eigen::VectorXd direction = Eigen::VectorXd::Random(point_.size());
  ASSERT_TRUE(cost_.TimesCurvature(point_, direction, &product)) << cost_.last_failure();
  const Eigen::VectorXd expected = jacobian.transpose() * (jacobian * direction);
  EXPECT_LE((product - expected).norm(), std::max(1e-4, RowTolerance()) * expected.norm());
}

// Of a change to another prediction, in a model that errs: what forward rows say, weighted.
TEST_P(FieldCostTest, PullsBackWhatChanges) {
  ModelError error;
  error.curves[0] = {Eigen::Vector2d(0.0, 0.2), Eigen::Vector2d(0.0, 9e-6), 1.0};
  RolloutCost cost(motion_, Blocks(motion_), OptionsOf(GetParam()));
  RecordingModel model(motion_, Blocks(motion_), {}, cost.model().shared_start(), Requests());
  cost.SetModelError(error);
  model.SetModelError(error);
  Eigen::VectorXd other = point_, product, weights;
  other.head(5).array() += 0.03;
  Eigen::MatrixXd here, there, forces_here, forces_there;
  ASSERT_TRUE(cost.Predict(point_, &here, nullptr, &forces_here));
  ASSERT_TRUE(cost.Predict(other, &there, nullptr, &forces_there));
  ASSERT_TRUE(cost.PullBackChange(point_, there, forces_there, &product)) << cost.last_failure();

  const Eigen::MatrixXd few = 1e-2 * Eigen::MatrixXd::Random(model.num_unknowns(), 3);
  const Observation& observation = model.observation();
  Eigen::MatrixXd jacobian(observation.num_residuals(), 8);
  const auto add_frame = [&](int frame, const auto&, const auto&, const Eigen::MatrixXd& rows) {
    jacobian.middleRows(observation.first_row(frame), rows.rows()) = rows;
  };
  Eigen::MatrixXd predicted, velocities;
  ForceTrack forces;
  const Rollout rollout = model.Simulate(point_, {}, {}, &predicted, &velocities, &forces);
  model.PushForward(rollout, point_, {{0, 1, 2, 3, 4}, few}, add_frame, Precision::kFull);
  const Eigen::VectorXd residuals = observation.Residuals(here, forces_here);
  const Eigen::VectorXd change = observation.Residuals(there, forces_there) - residuals;
  LossWeights(ParseRobustLoss(GetParam().loss), observation, 0, residuals, &weights);
  EXPECT_LT(weights.minCoeff(), 0.9);
  const Eigen::VectorXd expected = jacobian.transpose() * weights.cwiseAbs2().cwiseProduct(change);
  Eigen::VectorXd own(8);
  own << product.head(5), few.transpose() * product.tail(few.rows());
  EXPECT_LE((own - expected).cwiseQuotient(expected).cwiseAbs().maxCoeff(), 1e-9);
}

// A frozen block is no direction and has no row.
TEST_P(FieldCostTest, LeavesOutWhatIsFrozen) {
  std::vector<ParameterBlock> blocks = Blocks(motion_);
  blocks[1].frozen = true;
  RolloutCost frozen(motion_, blocks, OptionsOf(GetParam()));
  if (GetParam().errs) frozen.SetModelError(SomeError());
  Eigen::VectorXd direction = Eigen::VectorXd::Ones(point_.size()), product, expected;
  ASSERT_TRUE(frozen.TimesCurvature(point_, direction, &product));
  direction[1] = 0.0;
  ASSERT_TRUE(cost_.TimesCurvature(point_, direction, &expected));
  expected[1] = 0.0;
  EXPECT_LE((product - expected).norm(), 1e-9 * expected.norm());
}

// What Ceres gets along the unknowns, by either sweep.
TEST_P(FieldCostTest, RowsOfCeresHaveTheGradient) {
  double value = 0.0;
  Eigen::VectorXd gradient;
  ASSERT_TRUE(cost_.EvaluateGradient(point_, &value, &gradient));
  for (const JacobianMethod method : {JacobianMethod::kAdjoint, JacobianMethod::kSensitivity}) {
    RolloutCostOptions options = OptionsOf(GetParam());
    options.jacobian = method;
    RolloutCost cost(motion_, Blocks(motion_), options);
    if (GetParam().errs) cost.SetModelError(SomeError());
    using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
    std::vector<const double*> parameters;
    std::vector<RowMajor> rows;
    std::vector<double*> jacobians;
    Eigen::VectorXd residuals(cost.num_residuals());
    int first = 0;
    for (const int size : cost.parameter_block_sizes()) {
      parameters.push_back(point_.data() + first);
      rows.emplace_back(cost.num_residuals(), size);
      first += size;
    }
    for (RowMajor& own : rows) jacobians.push_back(own.data());
    ASSERT_TRUE(cost.Evaluate(parameters.data(), residuals.data(), jacobians.data())) << cost.last_failure();
    EXPECT_NEAR(0.5 * residuals.squaredNorm(), value, 1e-9 * value);
    first = 0;
    for (const RowMajor& own : rows) {
      const Eigen::VectorXd expected = gradient.segment(first, own.cols());
      // All columns of a forward sweep are as exact as the many that move a start.
      const double tolerance = method == JacobianMethod::kAdjoint ? 1e-9 : RowTolerance();
      EXPECT_LE((own.transpose() * residuals - expected).norm(), tolerance * expected.norm()) << first;
      first += static_cast<int>(own.cols());
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Recordings, FieldCostTest,
                         ::testing::Values(Case{"KnownStart", false, "none"}, Case{"UnknownStart", true, "none"},
                                           Case{"Robust", true, "huber:1.5"}, Case{"Weighed", true, "none", true},
                                           Case{"WeighedRobust", true, "huber:1.5", true}),
                         [](const ::testing::TestParamInfo<Case>& test) { return std::string(test.param.name); });

// Everything that was asked of a cost, and what it counted.
struct Answers {
  Eigen::VectorXd gradient, residuals, first, second, change;
  Eigen::MatrixXd jacobian;
  int rollouts = 0, sweeps = 0, records = 0;
};

Answers Ask(const RecordedMotion& motion, const std::string& journal, bool only_first_half) {
  RolloutCostOptions options = OptionsOf({"", true, "none"});
  options.journal = std::make_shared<EvaluationJournal>(journal, std::string(64, 'a'));
  const RolloutCost cost(motion, Blocks(motion), options);
  const Eigen::VectorXd point = SomePoint(cost.model());
  std::srand(13);
  const Eigen::MatrixXd few = 1e-2 * Eigen::MatrixXd::Random(cost.model().num_unknowns(), 3);
  const Eigen::VectorXd direction = Eigen::VectorXd::Random(point.size());
  Answers answers;
  double value = 0.0;
  EXPECT_TRUE(cost.EvaluateGradient(point, &value, &answers.gradient)) << cost.last_failure();
  EXPECT_TRUE(cost.Linearize(point, few, &answers.jacobian, &answers.residuals)) << cost.last_failure();
  EXPECT_TRUE(cost.TimesCurvature(point, direction, &answers.first)) << cost.last_failure();
  if (!only_first_half) {
    EXPECT_TRUE(cost.TimesCurvature(point, -2.0 * direction, &answers.second)) << cost.last_failure();
    Eigen::MatrixXd predicted, forces;
    EXPECT_TRUE(cost.Predict(point, &predicted, nullptr, &forces)) << cost.last_failure();
    EXPECT_TRUE(cost.PullBackChange(point, 1.01 * predicted, forces, &answers.change)) << cost.last_failure();
    EXPECT_TRUE(cost.Linearize(point, 2.0 * few, &answers.jacobian, &answers.residuals)) << cost.last_failure();
    EXPECT_TRUE(cost.Linearize(point, 2.0 * few, &answers.jacobian, &answers.residuals)) << cost.last_failure();
  }
  answers.rollouts = cost.statistics().rollouts;
  answers.sweeps = cost.statistics().sweeps;
  answers.records = options.journal->num_records();
  return answers;
}

void ExpectSame(const Answers& a, const Answers& b) {
  EXPECT_EQ(a.gradient, b.gradient);
  EXPECT_EQ(a.residuals, b.residuals);
  EXPECT_EQ(a.jacobian, b.jacobian);
  EXPECT_EQ(a.first, b.first);
  EXPECT_EQ(a.second, b.second);
  EXPECT_EQ(a.change, b.change);
  EXPECT_EQ(a.rollouts, b.rollouts);
  EXPECT_EQ(a.sweeps, b.sweeps);
  EXPECT_EQ(a.records, b.records);
}

TEST(FieldJournalTest, ReplaysRowsAndProducts) {
  std::string folder = testing::TempDir() + "clothid_fields_XXXXXX";
  ASSERT_NE(mkdtemp(folder.data()), nullptr);
  const RecordedMotion motion = MotionOf({"", true, "none"});
  const Answers answers = Ask(motion, folder + "/whole.bin", false);
  EXPECT_EQ(answers.rollouts, 1);
  EXPECT_EQ(answers.sweeps, 1 + 1 + 3 + 2 + 1 + 1);
  ExpectSame(Ask(motion, folder + "/whole.bin", false), answers);  // replayed
  Ask(motion, folder + "/half.bin", true);
  ExpectSame(Ask(motion, folder + "/half.bin", false), answers);  // replayed, then gone on
  std::filesystem::remove_all(folder);
}

TEST(FieldUnknownsTest, TheSameEverywhereMovesNothing) {
  const RecordedMotion motion = ShakenMotion();
  const FieldUnknowns fields(Requests(), motion.scene, "test");
  ASSERT_EQ(fields.size(), 17);
  const Eigen::VectorXd same = Eigen::VectorXd::Constant(17, 0.7);
  EXPECT_LE(fields.OverTriangles(same).norm(), 1e-12);
  RolloutCostOptions options;
  options.fields = Requests();
  const RolloutCost cost(motion, Blocks(motion), options);
  Eigen::VectorXd point = SomePoint(cost.model());
  const double value = CostAt(cost, point);
  point.tail(17).array() += 0.7;
  EXPECT_NEAR(CostAt(cost, point), value, 1e-12 * value);
}

// As the scene's own fields would be, but for their level; others stay, and the transpose is one.
// Rollouts and Jacobians serve on; costs, gradients and rows are those of the new weights.
TEST_P(FieldCostTest, WeightsMayChange) {
  RolloutCost changed(motion_, Blocks(motion_), OptionsOf(GetParam()));
  ModelError other = SomeError();
  other.CurveOf(PredictedKind::kPoints).alike *= 2.0;
  changed.SetModelError(other);
  double cost = 0.0, expected = 0.0;
  Eigen::VectorXd gradient, expected_gradient, residuals, expected_residuals;
  Eigen::MatrixXd rows, expected_rows;
  ASSERT_TRUE(changed.EvaluateGradient(point_, &cost, &gradient));
  ASSERT_TRUE(changed.Linearize(point_, {}, &rows, &residuals));
  const int rollouts = changed.statistics().rollouts;
  changed.SetModelError(GetParam().errs ? SomeError() : ModelError());
  ASSERT_TRUE(changed.EvaluateGradient(point_, &cost, &gradient));
  ASSERT_TRUE(changed.Linearize(point_, {}, &rows, &residuals));
  EXPECT_EQ(changed.statistics().rollouts, rollouts);
  ASSERT_TRUE(cost_.EvaluateGradient(point_, &expected, &expected_gradient));
  ASSERT_TRUE(cost_.Linearize(point_, {}, &expected_rows, &expected_residuals));
  EXPECT_EQ(cost, expected);
  EXPECT_LE((gradient - expected_gradient).norm(), 1e-12 * expected_gradient.norm());
  EXPECT_LE((rows.transpose() * rows - expected_rows.transpose() * expected_rows).norm(),
            1e-12 * (expected_rows.transpose() * expected_rows).norm());
}

TEST(FieldUnknownsTest, AreLogarithmsOverTheSceneFields) {
  RecordedMotion motion = ShakenMotion();
  motion.scene.fields[0].values(1, 2) *= 3.0;
  const std::vector<FieldRequest> requests = ParseFieldRequests("k_bend:2x2,k_stretch:3x3");
  const FieldUnknowns fields(requests, motion.scene, "test");
  const Eigen::VectorXd theta = Eigen::VectorXd::LinSpaced(13, -0.4, 0.9).array().sin();
  Scene expected = motion.scene;
  for (int r = 0, i = 0; r < 2; ++r) {
    for (int c = 0; c < 2; ++c, ++i) expected.fields[2].values(r, c) *= std::exp(theta[i]);
  }
  for (int r = 0, i = 4; r < 3; ++r) {
    for (int c = 0; c < 3; ++c, ++i) expected.fields[0].values(r, c) *= std::exp(theta[i]);
  }
  const auto factors = fields.FactorsAt(theta);
  ASSERT_EQ(factors->size(), 3u);
  for (std::size_t k = 0; k < 3; ++k) {
    EXPECT_EQ((*factors)[k].kind, expected.fields[k].kind);
    double level = 0.0;
    const FieldFactors own = FieldOverTriangles(expected.fields[k], expected.mesh, &level);
    EXPECT_LE(((*factors)[k].log_factors - own.log_factors).norm(), 1e-12) << k;
  }
  const Eigen::MatrixXd forward = fields.OverTriangles(Eigen::MatrixXd::Identity(13, 13));
  const Eigen::MatrixXd back = fields.PullBack(Eigen::MatrixXd::Identity(forward.rows(), forward.rows()));
  EXPECT_LE((forward - back.transpose()).norm(), 1e-13);
  motion.scene.fields.clear();
  EXPECT_THROW(FieldUnknowns(requests, motion.scene, "test"), std::logic_error);
}

}  // namespace
}  // namespace clothid::field_cost_test
