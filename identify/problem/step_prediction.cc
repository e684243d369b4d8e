#include "identify/problem/step_prediction.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "costs/prediction/recording_model.h"
#include "identify/base/parallel_for.h"
#include "identify/problem/evaluator.h"
#include "identify/problem/gauss_newton.h"
#include "sim/base/phase_seconds.h"

namespace clothid {
namespace {

// Of the rollouts at other steps, where that of the scene is tighter. On the shipped recordings the errors are then as
// with 1e-8 within 3 %, or below 2e-4 of the value, and the rollouts a fifth cheaper. With 1e-3, friction that `slope`
// tells exactly is said to be 1 % off.
constexpr double kStepTolerance = 1e-5;
// Of what half the step moves: the error of the step at the first order is 2, and two standard deviations are allowed.
constexpr double kStepErrors = 4.0;

// The largest part of a step from `coordinates`, in resolutions.
double LengthOf(const FitProblem& problem, const MovedEnd& end) {
  double length = 0.0;
  for (Eigen::Index i = 0; i < end.move.size(); ++i) {
    const ParameterBlock& block = problem.blocks()[static_cast<std::size_t>(i)];
    length = std::max(length, std::abs(end.move[i]) / block.Resolution(end.coordinates[i]));
  }
  return length;
}

Scene AtStep(Scene scene, double factor) {
  scene.time_step *= factor;
  scene.solver.step_tolerance = std::max(scene.solver.step_tolerance, kStepTolerance);
  return scene;
}

std::vector<RecordedMotion> AtStep(std::vector<RecordedMotion> motions, double factor) {
  for (RecordedMotion& motion : motions) motion.scene = AtStep(std::move(motion.scene), factor);
  return motions;
}

}  // namespace

StepPrediction PredictAtStep(double factor, const RecordedMotion& motion, const FitOptions& options,
                             const FitProblem& problem, int recording, const Eigen::VectorXd& coordinates) {
  RecordedMotion other = motion;
  other.scene = AtStep(std::move(other.scene), factor);
  const RecordingModel& fitted = problem.cost(recording).model();
  StepPrediction prediction;
  const ScopedTimer timer(&prediction.statistics.rollout_seconds);
  try {
    RecordingModel model(other, fitted.blocks(), {}, fitted.shared_start(), problem.fields());
    model.SetNumThreads(std::max(1, options.num_threads / problem.num_recordings()));
    model.Assimilate(problem.assimilation(), options.loss);
    ForceTrack forces;
    const Rollout rollout =
        model.Simulate(problem.CoordinatesOf(recording, coordinates), {Precision::kFull, options.cancel}, {},
                       &prediction.points, /*velocities=*/nullptr, &forces);
    ++prediction.statistics.rollouts;
    prediction.statistics.counts += rollout.counts;
    prediction.forces = std::move(forces.predicted);
    if (!rollout.ok()) prediction.failure = model.name() + ": " + rollout.failure->ToString();
  } catch (const std::runtime_error& error) {  // a scene that cannot have this step, a system that is singular there
    prediction.failure = error.what();
  }
  return prediction;
}

std::vector<StepPrediction> PredictAllAtStep(double factor, const std::vector<RecordedMotion>& motions,
                                             const FitOptions& options, const FitProblem& problem,
                                             const Eigen::VectorXd& coordinates) {
  std::vector<StepPrediction> predictions(motions.size());
  ParallelFor(static_cast<int>(motions.size()), options.num_threads, [&](int r) {
    const auto index = static_cast<std::size_t>(r);
    predictions[index] = PredictAtStep(factor, motions[index], options, problem, r, coordinates);
  });
  return predictions;
}

bool PullBackStep(const Eigen::VectorXd& coordinates, std::vector<StepPrediction> predictions, FitEvaluator* evaluator,
                  CostStatistics* statistics, Eigen::VectorXd* change, std::string* failure) {
  std::vector<Eigen::MatrixXd> points, forces;
  for (StepPrediction& prediction : predictions) {
    *statistics += prediction.statistics;
    if (failure->empty()) *failure = prediction.failure;
    points.push_back(std::move(prediction.points));
    forces.push_back(std::move(prediction.forces));
  }
  if (failure->empty() && !evaluator->PullBackChange(coordinates, points, forces, change)) {
    *failure = evaluator->last_failure();
  }
  return failure->empty();
}

bool ModelAtStep(double factor, const std::vector<RecordedMotion>& motions, const FitOptions& options,
                 const FitProblem& problem, const Eigen::VectorXd& coordinates, CostStatistics* statistics,
                 QuadraticModel* model, std::vector<StepPrediction>* predictions, std::string* failure) {
  FitOptions own = problem.WithWeights(options);
  own.journal_folder.clear();
  own.on_progress = nullptr;
  own.jacobian = JacobianMethod::kSensitivity;  // its rows come along, and nothing is kept for other derivatives
  try {
    const FitProblem other(AtStep(motions, factor), own);
    FitEvaluator evaluator(&other, options.num_threads, EvaluationPurpose::kInterval);
    double cost = 0.0;
    const bool ok = evaluator.Evaluate(coordinates, FitEvaluator::Derivative::kRows, &cost, nullptr);
    *statistics += evaluator.statistics();
    for (int r = 0; ok && r < other.num_recordings(); ++r) {
      StepPrediction& prediction = predictions->emplace_back();
      other.cost(r).Predict(other.CoordinatesOf(r, coordinates), &prediction.points, nullptr, &prediction.forces);
    }
    if (ok) *model = evaluator.model();
    *failure = ok ? std::string() : evaluator.last_failure();
  } catch (const std::runtime_error& error) {  // a scene that cannot have this step
    *failure = error.what();
  }
  return failure->empty();
}

std::optional<Eigen::VectorXd> HalfStepMove(const std::vector<RecordedMotion>& motions, const FitOptions& options,
                                            const FitProblem& problem, FitEvaluator* evaluator,
                                            CostStatistics* statistics) {
  QuadraticModel model = evaluator->model();
  Eigen::VectorXd change;
  std::string failure;
  if (!PullBackStep(model.coordinates, PredictAllAtStep(0.5, motions, options, problem, model.coordinates), evaluator,
                    statistics, &change, &failure)) {
    return std::nullopt;
  }
  model.gradient = change.head(problem.num_blocks());
  return GaussNewtonStep(problem, model);
}

bool IsMovedLess(const FitProblem& problem, const MovedEnd& a, const MovedEnd& b) {
  const Eigen::ArrayXd apart = (a.coordinates - b.coordinates).head(problem.num_blocks()).array().abs();
  const Eigen::ArrayXd errors = kStepErrors * (a.move.array().abs() + b.move.array().abs());
  return (apart <= errors).all() && LengthOf(problem, a) < LengthOf(problem, b);
}

}  // namespace clothid
