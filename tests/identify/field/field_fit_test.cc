// Fits of constants that vary over the cloth, on a draped cloth of 10 x 10 nodes.
#include "identify/field/field_fit.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>
#include <random>
#include <string>

#include "identify/field/field_model.h"
#include "identify/field/field_posterior.h"
#include "identify/field/field_preconditioner.h"
#include "identify/field/field_prior.h"
#include "identify/field/field_stage.h"
#include "identify/fit/fit.h"
#include "identify/fit/problem.h"
#include "sim/rollout/simulator.h"
#include "sim/scene/scene_json.h"
#include "tests/costs/synthetic_forces.h"
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

// With a field that is the same everywhere, where a fit starts.
std::vector<RecordedMotion> StartMotions(const FieldRequest& request) {
  std::vector<RecordedMotion> motions = {FieldMotion()};
  const double level = GetParameter(motions.front().scene.nominal_parameters(), {request.kind});
  SetField({request.kind, Eigen::MatrixXd::Constant(request.rows, request.columns, level)}, &motions);
  return motions;
}

std::vector<ParameterBlock> Blocks(const std::vector<RecordedMotion>& motions) {
  return {MakeParameterBlock("mu", motions.front(), {})};
}

double Cost(const Eigen::VectorXd& unknowns, FieldModel* model) {
  FieldPoint point;
  EXPECT_TRUE(model->MoveTo(unknowns, Precision::kFull, &point)) << model->failure();
  return point.data_cost;
}

TEST(FieldModel, GradientIsThatOfDifferences) {
  std::vector<RecordedMotion> motions = StartMotions(kRequest);
  motions.front().scene.solver.step_tolerance = 1e-11;
  FieldModel model(motions, Blocks(motions), {kRequest}, FitOptions());
  std::mt19937_64 generator(2);
  std::normal_distribution<double> normal;
  const Eigen::VectorXd unknowns = model.Start();
  FieldPoint point;
  ASSERT_TRUE(model.MoveTo(unknowns, Precision::kFull, &point));
  const Eigen::VectorXd gradient = model.DataGradient(point);
  const Eigen::VectorXd direction = Eigen::VectorXd::NullaryExpr(model.size(), [&] { return normal(generator); });
  double best = 1.0;
  for (const double step : {1e-4, 1e-5, 1e-6}) {
    const double difference =
        (Cost(unknowns + step * direction, &model) - Cost(unknowns - step * direction, &model)) / (2.0 * step);
    best = std::min(best, std::abs(difference / gradient.dot(direction) - 1.0));
  }
  EXPECT_LE(best, 1e-5);
}

// J and J^T are transposes, and Gram is their product, for the tracked points and a loss.
TEST(FieldModel, ProductsAreThoseOfOneJacobian) {
  const std::vector<RecordedMotion> motions = StartMotions(kRequest);
  FitOptions options;
  options.loss = ParseRobustLoss("huber:1.5");
  FieldModel model(motions, Blocks(motions), {kRequest}, options);
  FieldPoint point;
  ASSERT_TRUE(model.MoveTo(model.Start(), Precision::kFull, &point));
  const Eigen::MatrixXd all = Eigen::MatrixXd::Identity(model.size(), model.size());
  const Eigen::MatrixXd gram = model.Gram(all, &point);
  for (const int column : {0, 1, 9}) {
    const Eigen::VectorXd product = model.TimesCurvature(all.col(column), &point);
    EXPECT_LE((product - gram.col(column)).norm(), 1e-4 * product.norm()) << column;
  }
  // The gradient is J^T of the weighted residuals.
  const Eigen::VectorXd gradient = model.DataGradient(point);
  const Eigen::VectorXd by_rows = model.TimesTransposed({point.recordings.front().cost.WeightedResiduals()}, point);
  EXPECT_LE((gradient - by_rows).norm(), 1e-4 * gradient.norm());
}

// Forces at handles are rows like others, of fields of every constant.
TEST(FieldModel, ForcesGoWithPositions) {
  std::vector<RecordedMotion> motions = {FieldMotion()};
  motions.front().scene = Shaken(motions.front().scene);
  motions.front().scene.solver.step_tolerance = 1e-11;
  ForceOptions seen;
  seen.groups = {{0, 1, 2}, {5, 6}};
  seen.true_values = {{"k_stretch", 70.0}, {"density", 0.25}};
  seen.sigma = 1e-2;
  AddForces(seen, &motions.front());
  const std::vector<FieldRequest> requests = ParseFieldRequests("k_stretch:3x3,density:2x2,k_bend:2x2");
  for (const FieldRequest& request : requests) {
    const double level = GetParameter(motions.front().scene.nominal_parameters(), {request.kind});
    SetField({request.kind, Eigen::MatrixXd::Constant(request.rows, request.columns, level)}, &motions);
  }
  FieldModel model(motions, Blocks(motions), requests, FitOptions());
  FieldPoint point;
  ASSERT_TRUE(model.MoveTo(model.Start(), Precision::kFull, &point)) << model.failure();
  ASSERT_EQ(point.recordings.front().forces.predicted.rows(), 6);
  const Eigen::VectorXd gradient = model.DataGradient(point);
  int first = model.num_scalars();
  for (const FieldRequest& request : requests) {
    Eigen::VectorXd direction = Eigen::VectorXd::Zero(model.size());
    direction.segment(first, request.size()) = Eigen::VectorXd::LinSpaced(request.size(), -0.7, 1.9).array().cos();
    first += request.size();
    double best = 1.0;
    for (const double step : {1e-4, 1e-5}) {
      const double difference =
          (Cost(point.unknowns + step * direction, &model) - Cost(point.unknowns - step * direction, &model)) /
          (2.0 * step);
      best = std::min(best, std::abs(difference / gradient.dot(direction) - 1.0));
    }
    EXPECT_LE(best, 1e-5) << request.name;
  }
  ASSERT_TRUE(model.MoveTo(model.Start(), Precision::kFull, &point));
  const Eigen::MatrixXd all = Eigen::MatrixXd::Identity(model.size(), model.size());
  std::vector<Eigen::MatrixXd> scores;
  const Eigen::MatrixXd gram = model.Gram(all, &point, &scores);
  for (const int column : {0, 1, 10, 16}) {
    const Eigen::VectorXd product = model.TimesCurvature(all.col(column), &point);
    EXPECT_LE((product - gram.col(column)).norm(), 1e-4 * product.norm()) << column;
  }
  EXPECT_LE((scores.front().rowwise().sum() - gradient).norm(), 1e-4 * gradient.norm());
}

// The integral of the squared Laplacian, whatever the grid; nothing of the mean.
TEST(FieldModel, PriorIsTheSameOnEveryGrid) {
  for (const int side : {17, 33}) {
    const Eigen::SparseMatrix<double> root = SmoothnessRoot(side, side);
    Eigen::VectorXd wave(side * side);
    for (int r = 0; r < side; ++r) {
      for (int c = 0; c < side; ++c) wave[r * side + c] = std::cos(3.14159265358979 * c / (side - 1.0));
    }
    EXPECT_NEAR((root * wave).squaredNorm(), 0.5 * std::pow(3.14159265358979, 4), 0.1 * 49.0) << side;
    EXPECT_LE((root * Eigen::VectorXd::Ones(side * side)).norm(), 1e-9);
  }
}

// Eigenvectors of the prior, and what they leave out of its covariance.
TEST(FieldModel, SmoothModesAreThoseOfThePrior) {
  constexpr int kRows = 5, kColumns = 7;
  const Eigen::MatrixXd prior = SmoothnessRoot(kRows, kColumns).transpose() * SmoothnessRoot(kRows, kColumns);
  const Eigen::MatrixXd all = SmoothModes(kRows, kColumns, 7);
  ASSERT_EQ(all.cols(), kRows * kColumns);
  EXPECT_LE((all.transpose() * all - Eigen::MatrixXd::Identity(35, 35)).norm(), 1e-12);
  const Eigen::VectorXd roughness = (all.transpose() * prior * all).diagonal();
  EXPECT_LE((prior * all - all * roughness.asDiagonal()).norm(), 1e-10 * prior.norm());
  EXPECT_LE((RoughVariances(kRows, kColumns, 7)).norm(), 0.0);
  const Eigen::MatrixXd few = SmoothModes(kRows, kColumns, 3);
  ASSERT_EQ(few.cols(), 9);
  const Eigen::MatrixXd rest = all - few * (few.transpose() * all);
  const Eigen::VectorXd variances =
      rest.array().square().matrix() * roughness.cwiseMax(1e-9).cwiseInverse();  // the mean is not in `rest`
  EXPECT_LE((RoughVariances(kRows, kColumns, 3) - variances).norm(), 1e-9 * variances.norm());
}

// Where the coarse basis is that of the control grid it is the inverse of H; else at least over the basis, symmetric
// and positive.
TEST(FieldPreconditioner, IsTheInverseOverItsBasis) {
  const std::vector<RecordedMotion> motions = StartMotions(kRequest);
  FieldModel model(motions, Blocks(motions), {kRequest}, FitOptions());
  FieldPoint point;
  ASSERT_TRUE(model.MoveTo(model.Start(), Precision::kFull, &point));
  constexpr double kWeight = 3.0;
  const Eigen::MatrixXd all = Eigen::MatrixXd::Identity(model.size(), model.size());
  Eigen::MatrixXd hessian = model.Gram(all, &point);
  hessian.bottomRightCorner(16, 16) += kWeight * model.prior_matrix();
  for (const int side : {4, 3}) {
    const FieldCurvature curvature(side, &model, &point);
    const FieldPreconditioner preconditioner(curvature, kWeight, model);
    Eigen::MatrixXd inverse(model.size(), model.size());
    for (Eigen::Index i = 0; i < all.cols(); ++i) inverse.col(i) = preconditioner.Solve(all.col(i));
    EXPECT_LE((inverse - inverse.transpose()).norm(), 1e-9 * inverse.norm()) << side;
    EXPECT_EQ(inverse.llt().info(), Eigen::Success) << side;
    const Eigen::MatrixXd& basis = curvature.basis();
    const Eigen::MatrixXd over_basis = basis.transpose() * inverse.inverse() * basis;
    const Eigen::MatrixXd expected = basis.transpose() * hessian * basis;
    EXPECT_LE((over_basis - expected).norm(), 1e-4 * expected.norm()) << side;
    if (side < 4) continue;
    const Eigen::VectorXd eigenvalues = (inverse * hessian).eigenvalues().real();
    EXPECT_LE((eigenvalues.array() - 1.0).abs().maxCoeff(), 1e-3) << eigenvalues.transpose();
  }
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
  const std::vector<RecordedMotion> motions = StartMotions(kRequest);
  const FieldFit fit = FitFields(motions, Blocks(motions), {kRequest}, FieldFitOptions());
  ASSERT_TRUE(fit.result.ok) << fit.result.message;
  EXPECT_TRUE(fit.result.has_converged) << fit.result.message;
  const FittedField& field = fit.result.fields.front();
  EXPECT_GE(ShareDetermined(field), 0.5);
  EXPECT_LE(DeterminedError(field), 0.05);
  EXPECT_LE(fit.result.num_rollouts, 20);
  EXPECT_NEAR(Blocks(motions).front().ToValue(fit.coordinates[0]),
              motions.front().scene.obstacles[0].friction_coefficient, 0.01);
}

// From where flat fields end, with friction beside the field, on a fine control grid: the cost falls below that of the
// truth. It is steep in either, and flat where the one makes up for the other.
TEST(FieldFit, GoesOnWhereFrictionMakesUpForTheField) {
  const FieldRequest request{"k_stretch", ParameterKind::kStretchStiffness, 8, 8};
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
  SetField({request.kind, Eigen::MatrixXd::Constant(8, 8, 75.0)}, &motions);
  std::vector<ParameterBlock> blocks = Blocks(motions);
  blocks.front().start = 0.2516;
  const FieldFit fit = FitFields(motions, blocks, {request}, FieldFitOptions());
  ASSERT_TRUE(fit.result.ok) << fit.result.message;
  EXPECT_TRUE(fit.result.has_converged) << fit.result.message;
  FieldModel model(motions, blocks, {request}, FitOptions());
  const auto cost = [&](double q, const Eigen::MatrixXd& field) {
    Eigen::VectorXd unknowns(model.size());
    unknowns << q, LogsOf(field / 75.0);
    const double prior = (model.prior_root() * unknowns.tail(request.size())).squaredNorm();
    return Cost(unknowns, &model) + 0.5 * fit.result.weight * prior;
  };
  Eigen::MatrixXd truth(8, 8);
  for (int r = 0; r < 8; ++r) {
    for (int c = 0; c < 8; ++c) truth(r, c) = std::exp(BetweenControlNodes(values.array().log(), {c / 7.0, r / 7.0}));
  }
  EXPECT_LE(cost(fit.coordinates[0], fit.result.fields.front().values),
            cost(blocks.front().ToCoordinate(kTrueMu), truth));
  EXPECT_NEAR(blocks.front().ToValue(fit.coordinates[0]), kTrueMu, 0.001);
}

// A recording more or less at once changes nothing.
TEST(FieldFit, SameBytesOnEveryNumberOfThreads) {
  const FieldRequest request{"k_stretch", ParameterKind::kStretchStiffness, 2, 2};
  std::vector<RecordedMotion> motions = StartMotions(request);
  for (const double shift : {2e-4, -3e-4}) {
    motions.push_back(motions.front());
    motions.back().positions.array() += shift;
  }
  FieldFitOptions options;
  options.fit.max_iterations = 2;
  const FieldFit one = FitFields(motions, Blocks(motions), {request}, options);
  ASSERT_TRUE(one.result.ok) << one.result.message;
  for (const int num_threads : {2, 3}) {
    options.fit.num_threads = num_threads;
    const FieldFit fit = FitFields(motions, Blocks(motions), {request}, options);
    ASSERT_TRUE(fit.result.ok) << fit.result.message;
    EXPECT_EQ(fit.result.fields.front().values, one.result.fields.front().values);
    EXPECT_EQ(fit.result.fields.front().log_std, one.result.fields.front().log_std);
    EXPECT_EQ(fit.coordinates, one.coordinates);
    EXPECT_EQ(fit.marginal->jacobian, one.marginal->jacobian);
    EXPECT_EQ(fit.result.num_rollouts, one.result.num_rollouts);
    EXPECT_EQ(fit.result.num_sweeps, one.result.num_sweeps);
  }
}

// Of a level, the interval counts with what is not known of the field: it is wider than of the level alone.
TEST(FieldFit, IntervalsCountWithTheField) {
  std::vector<RecordedMotion> motions = {FieldMotion()};
  FitOptions options;
  options.parameters = {"mu", "k_stretch"};
  auto problem = std::make_unique<FitProblem>(motions, options);
  FieldResult result;
  const FitSummary summary = FitWithFields(options, {kRequest}, 0.0, &motions, &problem, &result);
  ASSERT_TRUE(summary.has_estimate()) << summary.message;
  EXPECT_EQ(summary.status, FitStatus::kConverged);
  EXPECT_EQ(summary.parameters[1].start, 120.0);
  ASSERT_TRUE(summary.uncertainty);
  FitSummary known = summary;
  AddUncertainty(options, *problem, &known);  // with the field as it is
  for (int i = 0; i < 2; ++i) {
    EXPECT_GT(summary.uncertainty->parameters[i].std, known.uncertainty->parameters[i].std) << i;
  }
  EXPECT_GT(summary.uncertainty->parameters[1].std, 1.5 * known.uncertainty->parameters[1].std);
}

TEST(FieldRequest, NamesWhatItCannotRead) {
  const std::vector<FieldRequest> requests = ParseFieldRequests("k_stretch:8x4, density:2x2");
  ASSERT_EQ(requests.size(), 2u);
  EXPECT_EQ(requests[0].rows, 8);
  EXPECT_EQ(requests[0].columns, 4);
  EXPECT_EQ(requests[1].kind, ParameterKind::kDensity);
  EXPECT_TRUE(ParseFieldRequests("").empty());
  const auto expect = [](const std::string& text, const char* message) {
    ExpectError([&] { ParseFieldRequests(text); }, ErrorKind::kUsage, {"--field: ", message});
  };
  for (const char* text : {"k_stretch", "k_stretch:8", "k_stretch:8x", "k_stretch:0x4", "k_stretch:4x300", ":4x4,",
                           "k_stretch:4.5x4", "k_stretch 4x4", "x", ""}) {
    if (*text != '\0') expect(text, "");
  }
  expect("mu:4x4", "'mu' can be no field");
  expect("k_stretch:4x4,k_stretch:2x2", "'k_stretch' is given twice");
  expect("k_stretch:80x80", "6400 unknowns; expected at most 4096");
}

TEST(FieldFit, RefusesAnUnknownStart) {
  std::vector<RecordedMotion> motions = StartMotions(kRequest);
  motions.front().start_source = StartSource::kMoving;
  ExpectError([&] { FieldModel(motions, {}, {kRequest}, FitOptions()); }, ErrorKind::kUsage,
              {"--field: ", "its start is unknown"});
}

}  // namespace
}  // namespace clothid::field_fit_test
