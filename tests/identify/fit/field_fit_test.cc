// Fits of constants that vary over the cloth, on a draped cloth of 10 x 10 nodes.
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>

#include "identify/fit/fit.h"
#include "identify/fit/krylov_step.h"
#include "identify/problem/evaluator.h"
#include "identify/problem/problem_blocks.h"
#include "identify/problem/unknown_basis.h"
#include "sim/rollout/simulator.h"
#include "sim/scene/scene_json.h"
#include "tests/costs/synthetic_motion.h"
#include "tests/expect_error.h"
#include "tests/sim/shipped_scenes.h"
#include "tests/tools/small_drape.h"

namespace clothid::field_fit_test {
namespace {

constexpr double kNoise = 5e-4;  // m
const FieldRequest kRequest = {"k_stretch", ParameterKind::kStretchStiffness, 4, 4};

Scene DrapeScene() {
  Scene scene = ShippedScene("drape", 10);
  scene.material.stretch_stiffness = 120.0;
  return scene;
}

Eigen::MatrixXd TrueValues() {
  Eigen::MatrixXd values(4, 4);
  for (int r = 0; r < 4; ++r) {
    for (int c = 0; c < 4; ++c) values(r, c) = 70.0 * std::exp(0.4 * std::cos(1.0 * r) - 0.3 * std::sin(0.8 * c));
  }
  return values;
}

// What a noisy sensor sees of the true field; the scene knows nothing of it.
RecordedMotion FieldMotion(const Scene& nominal, double mu, const Eigen::MatrixXd& values, double noise) {
  Scene scene = nominal;
  scene.fields = {{kRequest.kind, values}};
  scene.obstacles[0].friction_coefficient = mu;
  MotionOptions options;
  options.noise = noise;
  options.sigma = noise;
  RecordedMotion motion = MakeMotion(scene, options);
  motion.scene = nominal;
  return motion;
}

RecordedMotion FieldMotion() {
  const Scene scene = DrapeScene();
  return FieldMotion(scene, scene.obstacles[0].friction_coefficient, TrueValues(), kNoise);
}

FitOptions Options(const FieldRequest& request) {
  FitOptions options;
  options.parameters = {"mu"};
  options.fields = {request};
  return options;
}

// Of the recording with a field that is the same everywhere, where a fit starts.
FitSummary FitField(const FitOptions& options, std::vector<RecordedMotion> motions) {
  SetFlatFields(options, &motions);
  FitProblem problem(motions, options);
  return Fit(options, &problem);
}

// On a control grid of which the basis has a part, the step over basis and new direction is nearly that over all.
TEST(KrylovStepTest, WidensABasisByWhatItMisses) {
  std::vector<RecordedMotion> motions = {FieldMotion()};
  const FitOptions options = Options(kRequest);
  SetFlatFields(options, &motions);
  FitProblem problem(motions, options);
  problem.SetWeight(0, 3.0);
  FitEvaluator evaluator(&problem, 1);
  const Eigen::VectorXd start = problem.StartCoordinates();
  double cost = 0.0;
  Eigen::VectorXd gradient;
  ASSERT_TRUE(evaluator.Evaluate(start, FitEvaluator::Derivative::kGradient, &cost, &gradient));
  const auto hessian_over = [&](const UnknownBasis& basis) -> Eigen::MatrixXd {
    Linearization measured;
    EXPECT_TRUE(evaluator.Linearize(start, basis.combinations, &measured));
    const Eigen::MatrixXd believed = problem.PriorRows(basis.combinations);
    return measured.jacobian.transpose() * measured.jacobian + believed.transpose() * believed;
  };
  const UnknownBasis all = MakeBasis(problem, false, kAllModes), part = MakeBasis(problem, false, 3);
  ASSERT_EQ(all.combinations.cols(), 15);
  ASSERT_EQ(part.combinations.cols(), 8);
  EXPECT_FALSE(part.has_all_field_modes);
  const auto decrease = [&](const UnknownBasis& basis, const Eigen::MatrixXd& hessian) {
    const Eigen::VectorXd own = basis.Restrict(gradient);
    return 0.5 * own.dot(hessian.ldlt().solve(own));
  };
  WidenedBasis widened;
  ASSERT_TRUE(
      WidenBasis(options, problem, part, hessian_over(part), start, gradient, Precision::kFull, &evaluator, &widened));
  ASSERT_EQ(widened.basis.combinations.cols(), 9);
  const Eigen::MatrixXd gram = widened.basis.combinations.transpose() * widened.basis.combinations;
  EXPECT_LE((gram - Eigen::MatrixXd::Identity(9, 9)).norm(), 1e-9);
  const double promised = decrease(widened.basis, widened.hessian);
  EXPECT_GE(promised, 0.98 * decrease(all, hessian_over(all)));
  EXPECT_LE(promised, 1.001 * decrease(all, hessian_over(all)));
  EXPECT_LE((hessian_over(widened.basis) - widened.hessian).norm(), 1e-4 * widened.hessian.norm());
}

double DeterminedError(const FittedField& field) {
  double sum = 0.0, count = 0.0;
  for (Eigen::Index r = 0; r < field.values.rows(); ++r) {
    for (Eigen::Index c = 0; c < field.values.cols(); ++c) {
      if (!IsDetermined(field, r, c)) continue;
      sum += std::pow(std::log(field.values(r, c) / TrueValues()(r, c)), 2);
      count += 1.0;
    }
  }
  return std::sqrt(sum / count);
}

TEST(FieldFit, RecoversAFieldWhereItIsDetermined) {
  const RecordedMotion motion = FieldMotion();
  const FitSummary fit = FitField(Options(kRequest), {motion});
  ASSERT_TRUE(fit.fields) << fit.message;
  EXPECT_EQ(fit.status, FitStatus::kConverged) << fit.message;
  const FittedField& field = fit.fields->fields.front();
  EXPECT_GE(ShareDetermined(field), 0.5);
  EXPECT_LE(DeterminedError(field), 0.05);
  EXPECT_LE(fit.statistics.rollouts, 20);
  EXPECT_NEAR(fit.values()[0], motion.scene.obstacles[0].friction_coefficient, 0.01);
  EXPECT_EQ(fit.parameters[1].name, "k_stretch") << "the level is a parameter";
  EXPECT_NEAR(std::log(fit.values()[1] / 70.0), 0.0, 0.3);
}

// The weight of the prior, and so the work, are those of the field, not of the control grid.
TEST(FieldFit, AFineControlGridTakesNoMoreWork) {
  const RecordedMotion motion = FieldMotion();
  const FitSummary coarse = FitField(Options({"k_stretch", kRequest.kind, 6, 6}), {motion});
  const FitSummary fine = FitField(Options({"k_stretch", kRequest.kind, 12, 12}), {motion});
  ASSERT_TRUE(coarse.fields && fine.fields) << coarse.message << fine.message;
  EXPECT_EQ(fine.status, FitStatus::kConverged) << fine.message;
  EXPECT_NEAR(std::log(fine.fields->weight / coarse.fields->weight), 0.0, std::log(2.0));
  EXPECT_LE(fine.statistics.rollouts, 1.5 * coarse.statistics.rollouts);
  EXPECT_LE(fine.statistics.sweeps, 60) << "of 144 unknowns";
  EXPECT_GT(ShareDetermined(fine.fields->fields.front()), 0.5 * ShareDetermined(coarse.fields->fields.front()));
}

// With friction beside the field, on a fine control grid: the cost falls below that of the truth. It is steep in
// either, and flat where the one makes up for the other.
TEST(FieldFit, GoesOnWhereFrictionMakesUpForTheField) {
  constexpr double kTrueMu = 0.24;
  Eigen::Matrix3d values;
  values << 50.0, 60.0, 70.0, 60.0, 90.0, 100.0, 70.0, 80.0, 120.0;
  nlohmann::json text = nlohmann::json::parse(SmallDrape(10));
  text["clothid_scene"] = 2;
  text["contact"] = "gap";
  text["duration"] = 0.8;
  Scene scene = ParseScene(text.dump(), "drape", "");
  scene.material.stretch_stiffness = 75.0;
  std::vector<RecordedMotion> motions = {FieldMotion(scene, kTrueMu, values, 1e-3)};
  FitOptions options = Options({"k_stretch", ParameterKind::kStretchStiffness, 8, 8});
  options.overrides.start["mu"] = 0.2516;
  SetFlatFields(options, &motions);
  FitProblem problem(motions, options);
  const FitSummary fit = Fit(options, &problem);
  ASSERT_TRUE(fit.fields) << fit.message;
  EXPECT_EQ(fit.status, FitStatus::kConverged) << fit.message;
  Eigen::MatrixXd truth(8, 8);
  for (int r = 0; r < 8; ++r) {
    for (int c = 0; c < 8; ++c) truth(r, c) = std::exp(BetweenControlNodes(values.array().log(), {c / 7.0, r / 7.0}));
  }
  GridField field{ParameterKind::kStretchStiffness, truth};
  double level = 0.0;
  FieldOverTriangles(field, scene.mesh, &level);
  Eigen::VectorXd unknowns = fit.coordinates;
  unknowns[0] = problem.blocks()[0].ToCoordinate(kTrueMu);
  unknowns[1] = problem.blocks()[1].ToCoordinate(level);
  unknowns.tail(64) = LogsOf(truth / level);
  FitEvaluator evaluator(&problem, 1);
  double cost = 0.0;
  ASSERT_TRUE(evaluator.Evaluate(unknowns, FitEvaluator::Derivative::kNone, &cost, nullptr));
  EXPECT_LE(fit.cost, cost);
  EXPECT_NEAR(fit.values()[0], kTrueMu, 0.001);
}

// A recording more or less at once changes nothing.
TEST(FieldFit, SameBytesOnEveryNumberOfThreads) {
  std::vector<RecordedMotion> motions = {FieldMotion()};
  for (const double shift : {2e-4, -3e-4}) {
    motions.push_back(motions.front());
    motions.back().positions.array() += shift;
  }
  FitOptions options = Options({"k_stretch", ParameterKind::kStretchStiffness, 2, 2});
  options.max_iterations = 6;
  const FitSummary one = FitField(options, motions);
  ASSERT_TRUE(one.fields) << one.message;
  EXPECT_EQ(one.status, FitStatus::kNotConverged) << one.message;
  for (const int num_threads : {2, 3}) {
    options.num_threads = num_threads;
    const FitSummary fit = FitField(options, motions);
    ASSERT_TRUE(fit.fields) << fit.message;
    EXPECT_EQ(fit.fields->fields.front().values, one.fields->fields.front().values);
    EXPECT_EQ(fit.fields->fields.front().log_std, one.fields->fields.front().log_std);
    EXPECT_EQ(fit.coordinates, one.coordinates);
    EXPECT_EQ(fit.uncertainty->parameters[0].std, one.uncertainty->parameters[0].std);
    EXPECT_EQ(fit.statistics.rollouts, one.statistics.rollouts);
    EXPECT_EQ(fit.statistics.sweeps, one.statistics.sweeps);
  }
}

// Of a level, the interval counts with what is not known of the field: it is wider than of the level alone.
TEST(FieldFit, IntervalsCountWithTheField) {
  const FitSummary with_field = FitField(Options(kRequest), {FieldMotion()});
  ASSERT_TRUE(with_field.uncertainty) << with_field.message;
  EXPECT_EQ(with_field.parameters[1].start, 120.0);
  // The same cloth, its field known.
  std::vector<RecordedMotion> motions = {FieldMotion()};
  SetField({kRequest.kind, with_field.fields->fields.front().values}, &motions);
  FitOptions options;
  options.parameters = {"mu", "k_stretch"};
  FitProblem problem(motions, options);
  const FitSummary known = Fit(options, &problem);
  ASSERT_TRUE(known.uncertainty) << known.message;
  for (int i = 0; i < 2; ++i) {
    EXPECT_GT(with_field.uncertainty->parameters[i].coordinate_std, known.uncertainty->parameters[i].coordinate_std)
        << i;
  }
  EXPECT_GT(with_field.uncertainty->parameters[1].coordinate_std,
            1.5 * known.uncertainty->parameters[1].coordinate_std);
}

TEST(FieldFit, RefusesALevelOfEachRecording) {
  FitOptions options = Options(kRequest);
  options.each = {"k_stretch"};
  ExpectError([&] { FitField(options, {FieldMotion()}); }, ErrorKind::kUsage,
              {"--each: 'k_stretch' is a field, which all recordings have in common"});
}

}  // namespace
}  // namespace clothid::field_fit_test
