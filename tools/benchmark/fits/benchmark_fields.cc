#include "tools/benchmark/fits/benchmark_fields.h"

#include <cmath>
#include <random>
#include <utility>

#include "datasets/synthetic/fine_truth.h"
#include "datasets/synthetic/regrid.h"
#include "datasets/synthetic/true_recording.h"
#include "identify/fit/fit.h"
#include "identify/problem/evaluator.h"
#include "identify/problem/problem_blocks.h"
#include "sim/base/error.h"
#include "sim/rollout/simulator.h"
#include "tools/benchmark/base/timing.h"

namespace clothid {
namespace {

constexpr double kPi = 3.14159265358979323846;
constexpr int kTrueSide = 65;

// z of the header over the square, at `side` x `side` control nodes.
class TrueField {
 public:
  explicit TrueField(std::uint64_t seed) {
    std::mt19937_64 generator(seed);
    std::normal_distribution<double> normal;
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) amplitudes_(i, j) = i + j == 0 ? 0.0 : normal(generator) / (i * i + j * j);
    }
    amplitudes_ /= std::sqrt(At(kTrueSide).array().square().mean());
  }
  Eigen::MatrixXd At(int side) const {
    const auto cosine = [side](Eigen::Index r, Eigen::Index i) {
      return std::cos(kPi * static_cast<double>(i * r) / (side - 1.0));
    };
    const Eigen::MatrixXd cosines = Eigen::MatrixXd::NullaryExpr(side, 3, cosine);
    return cosines * amplitudes_ * cosines.transpose();
  }
  Eigen::MatrixXd ValuesAt(int side, double level) const { return level * (0.4 * At(side)).array().exp(); }

 private:
  Eigen::Matrix3d amplitudes_;
};

// The recording of the truth, whose scene has its nominal value everywhere.
RecordedMotion RecordField(const FieldsOptions& options, const GridScene& grid_scene, const TrueField& truth) {
  const int across = (grid_scene.nodes[1] - 1) * (options.nodes - 1) / (grid_scene.nodes[0] - 1) + 1;
  const Scene nominal = Regrid(grid_scene, {options.nodes, across});
  Scene scene = nominal;
  scene.fields = {{ParameterKind::kStretchStiffness, truth.ValuesAt(kTrueSide, options.level)}};
  Simulator simulator(scene);
  const Rollout rollout = Simulate(scene.nominal_parameters(), scene.num_steps(), &simulator);
  if (!rollout.ok()) throw Error(ErrorKind::kBadData, options.scene_path + ": " + rollout.failure->ToString());
  SyntheticOptions seen;
  seen.noise_sigma = options.noise;
  seen.seed = options.seed;
  RecordedMotion motion = MakeRecording(rollout, scene, "{\"clothid_scene\": 1}", seen);
  motion.scene = nominal;
  return motion;
}

double RootMeanSquare(double sum, double count) { return count > 0.0 ? std::sqrt(sum / count) : kNoNumber; }

void SetErrors(const Eigen::MatrixXd& truth, const FittedField& field, FieldsFit* fit) {
  double all = 0.0, determined = 0.0, count = 0.0;
  for (Eigen::Index r = 0; r < truth.rows(); ++r) {
    for (Eigen::Index c = 0; c < truth.cols(); ++c) {
      const double square = std::pow(std::log(field.values(r, c) / truth(r, c)), 2);
      all += square;
      if (!IsDetermined(field, r, c)) continue;
      determined += square;
      count += 1.0;
    }
  }
  fit->error = RootMeanSquare(all, static_cast<double>(truth.size()));
  fit->determined_error = RootMeanSquare(determined, count);
  fit->determined_share = count / static_cast<double>(truth.size());
}

// Seconds of a Jacobian by differences.
double TimeDifferences(int num_differences, FitProblem* problem) {
  FitEvaluator evaluator(problem, /*num_threads=*/1);
  const double start = ThreadSeconds();
  for (int i = 0; i < num_differences; ++i) {
    Eigen::VectorXd unknowns = problem->StartCoordinates();
    unknowns[problem->num_blocks() + i] += 1e-4;
    double cost = 0.0;
    evaluator.Evaluate(unknowns, FitEvaluator::Derivative::kNone, &cost, nullptr);
  }
  return (ThreadSeconds() - start) / num_differences * (problem->num_coordinates() + 1);
}

FieldsFit FitField(const FieldsOptions& options, int side, RecordedMotion motion, const TrueField& truth) {
  FitOptions fit_options;
  fit_options.fields = {{"k_stretch", ParameterKind::kStretchStiffness, side, side}};
  fit_options.parameters = {"k_stretch"};
  fit_options.check_interval = false;
  std::vector<RecordedMotion> motions = {std::move(motion)};
  SetFlatFields(fit_options, &motions);
  const double before = ThreadSeconds();
  double last = before;
  fit_options.on_iteration = [&last](const FitIteration&) { last = ThreadSeconds(); };
  FitProblem problem(motions, fit_options);
  const FitSummary fitted = Fit(fit_options, &problem);
  if (!fitted.has_estimate()) throw Error(ErrorKind::kBadData, options.scene_path + ": " + fitted.message);
  FieldsFit fit;
  fit.side = side;
  fit.has_converged = fitted.status == FitStatus::kConverged;
  fit.weight = fitted.fields->weight;
  fit.rmse = fitted.error.rmse();
  SetErrors(truth.ValuesAt(side, options.level), fitted.fields->fields.front(), &fit);
  fit.iterations = fitted.num_iterations();
  fit.rollouts = fitted.statistics.rollouts;
  fit.sweeps = fitted.statistics.sweeps;
  fit.seconds = ThreadSeconds() - before;
  fit.iteration_seconds = last - before;
  if (options.num_differences > 0) fit.difference_seconds = TimeDifferences(options.num_differences, &problem);
  return fit;
}

}  // namespace

void FieldsOptions::Validate() const {
  ExpectUsage(!scene_path.empty(), "--scene is missing; see benchmark --help");
  ExpectUsage(nodes >= 4, "--nodes: expected a number >= 4");
  ExpectUsage(!sides.empty(), "--settings: expected at least one side of a control grid");
  for (const int side : sides)
    ExpectUsage(side >= 2 && side <= 64, "--settings: expected sides of 2 to 64 control nodes");
  ExpectUsage(noise > 0.0 && std::isfinite(noise), "--sigma: expected a number > 0");
  ExpectUsage(level > 0.0 && std::isfinite(level), "--set: expected k_stretch=NUMBER, > 0");
}

FieldsBenchmark RunFieldsBenchmark(const FieldsOptions& options) {
  options.Validate();
  const TrueField truth(options.seed);
  const RecordedMotion motion = RecordField(options, ReadGridScene(options.scene_path), truth);
  FieldsBenchmark benchmark;
  const int num_fits = static_cast<int>(options.sides.size());
  for (const int side : options.sides) {
    const FieldsFit& fit = benchmark.fits.emplace_back(FitField(options, side, motion, truth));
    if (!options.on_progress) continue;
    const char* end = fit.has_converged ? "converged" : "not converged";
    options.on_progress(Format("%d unknowns: %s, %d rollouts", side * side, end, fit.rollouts),
                        static_cast<int>(benchmark.fits.size()), num_fits);
  }
  return benchmark;
}

std::string FieldsTable(const FieldsBenchmark& benchmark) {
  std::string table =
      " unknowns   error, %  determined, %   error, %  iterations  rollouts  sweeps   seconds   s/iteration  "
      "s/J differences\n";
  for (const FieldsFit& fit : benchmark.fits) {
    table += Format("%9d%11.2f%15.2f%11s%12d%10d%8d%10.2f%14.2f%17.2f%s\n", fit.side * fit.side, 100.0 * fit.error,
                    100.0 * fit.determined_share, FixedNumber(100.0 * fit.determined_error, 2).c_str(), fit.iterations,
                    fit.rollouts, fit.sweeps, fit.seconds, fit.seconds_per_iteration(), fit.difference_seconds,
                    fit.has_converged ? "" : "  not converged");
  }
  return table;
}

std::string FieldsCsv(const FieldsBenchmark& benchmark) {
  std::string csv =
      "unknowns,converged,weight,rmse_m,error,determined_share,determined_error,iterations,rollouts,sweeps,"
      "seconds,iteration_seconds,difference_seconds\n";
  for (const FieldsFit& fit : benchmark.fits) {
    csv += CsvLine(fit.side * fit.side, fit.has_converged, fit.weight, fit.rmse, fit.error, fit.determined_share,
                   fit.determined_error, fit.iterations, fit.rollouts, fit.sweeps, fit.seconds, fit.iteration_seconds,
                   fit.difference_seconds);
  }
  return csv;
}

}  // namespace clothid
