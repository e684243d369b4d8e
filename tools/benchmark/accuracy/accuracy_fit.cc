#include "tools/benchmark/accuracy/accuracy_fit.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <string>
#include <utility>

#include "costs/prediction/rollout_cost_options.h"
#include "datasets/synthetic/true_recording.h"
#include "tools/benchmark/accuracy/accuracy_forward.h"
#include "tools/benchmark/base/timing.h"
#include "tools/benchmark/derivatives/benchmark_jacobian.h"

namespace clothid {
namespace {

constexpr double kFrictionStart = 0.5, kDensityStart = 1.5, kStiffnessStart = 3.0;  // relative to the truth

std::vector<TrueParameter> MakeTruth(const Scene& scene) {
  const Parameters parameters = scene.nominal_parameters();
  std::map<std::string, double> truth = {{"k_stretch", parameters.material.stretch_stiffness}};
  if (scene.obstacles.empty()) {
    truth["density"] = parameters.material.density;
  } else {
    truth["mu"] = parameters.friction_coefficients.front();
  }
  return MakeTrueParameters(truth, scene);
}

double StartValue(const TrueParameter& parameter) {
  const double factor =
      parameter.is_friction ? kFrictionStart : (parameter.name == "density" ? kDensityStart : kStiffnessStart);
  return factor * parameter.value;
}

RecordedMotion RecordAllNodes(const AccuracyCase& accuracy_case, const std::vector<TrueParameter>& truth,
                              const Scene& scene) {
  Scene tight = scene;
  tight.solver.step_tolerance = kTightTolerance;
  const Rollout rollout = SimulateTruth(truth, accuracy_case.scene + ", " + accuracy_case.setting.name, tight);
  const int num_frames = rollout.num_steps() + 1;
  RecordedMotion motion;
  motion.name = "recording";
  motion.scene = scene;
  motion.points.resize(static_cast<std::size_t>(scene.mesh.num_nodes()));
  for (int node = 0; node < scene.mesh.num_nodes(); ++node) motion.points[node].nodes[0] = node;
  motion.times = Eigen::VectorXd::LinSpaced(num_frames, 0.0, (num_frames - 1) * scene.time_step);
  motion.times.array() += scene.start_time;
  motion.positions.resize(3 * scene.mesh.num_nodes(), num_frames);
  for (int frame = 0; frame < num_frames; ++frame) motion.positions.col(frame) = rollout.positions(frame);
  return motion;
}

double WorstError(const std::vector<TrueParameter>& truth, const Eigen::VectorXd& values) {
  double worst = 0.0;
  for (std::size_t i = 0; i < truth.size(); ++i) {
    worst = std::max(worst, std::abs(values[static_cast<Eigen::Index>(i)] / truth[i].value - 1.0));
  }
  return worst;
}

// The iterations of one fit; `model` holds what is the same for all of them.
std::vector<AccuracyPoint> RunFit(const RecordedMotion& motion, const std::vector<TrueParameter>& truth,
                                  const AccuracyPoint& model) {
  std::vector<AccuracyPoint> points;
  JacobianFit fit;
  fit.method = model.method;
  for (std::size_t i = 0; i < truth.size(); ++i) fit.start[i] = StartValue(truth[i]);
  const double start = ThreadSeconds();
  RunJacobianFit(motion, truth, FitPrecision::kAdaptive, &fit, [&](const FitIteration& iteration) {
    AccuracyPoint point = model;
    point.seconds = ThreadSeconds() - start;
    point.iteration = iteration.iteration;
    point.threshold =
        iteration.precision == Precision::kLoose ? kLooseStepTolerance : motion.scene.solver.step_tolerance;
    point.error = WorstError(truth, iteration.values);
    points.push_back(point);
  });
  if (points.empty()) points.push_back(model);  // the start could not be simulated: no error, no time
  for (AccuracyPoint& point : points) point.steps_failed = fit.failed_steps;
  return points;
}

// Fits repeat themselves to the bit, but for the seconds.
std::vector<AccuracyPoint> WithMedianSeconds(const std::vector<std::vector<AccuracyPoint>>& fits) {
  std::vector<AccuracyPoint> points = fits.front();
  for (std::size_t i = 0; i < points.size(); ++i) {
    std::vector<double> seconds;
    for (const std::vector<AccuracyPoint>& fit : fits) seconds.push_back(fit[i].seconds);
    points[i].seconds = Median(std::move(seconds));
  }
  return points;
}

}  // namespace

std::vector<AccuracyPoint> MeasureFits(const AccuracyCase& accuracy_case, int nodes, int repeats) {
  const Scene scene = accuracy_case.MakeScene(nodes);
  const std::vector<TrueParameter> truth = MakeTruth(scene);
  const RecordedMotion motion = RecordAllNodes(accuracy_case, truth, scene);
  std::map<std::string, std::vector<std::vector<AccuracyPoint>>> fits;  // by method, then repetition
  for (int repeat = 0; repeat < repeats; ++repeat) {
    for (const std::string& method : kJacobianBenchmarkMethods) {
      fits[method].push_back(RunFit(motion, truth, accuracy_case.MakePoint("fit", "truth", method, nodes)));
    }
  }
  std::vector<AccuracyPoint> points;
  for (const std::string& method : kJacobianBenchmarkMethods) {
    const std::vector<AccuracyPoint> curve = WithMedianSeconds(fits[method]);
    points.insert(points.end(), curve.begin(), curve.end());
  }
  return points;
}

}  // namespace clothid
