#include "identify/fit/first_frames.h"

#include <algorithm>
#include <cmath>
#include <memory>

#include "costs/prediction/alignment.h"
#include "identify/problem/gauss_newton.h"
#include "sim/base/error.h"

namespace clothid {
namespace {

// Of a stage, whose estimate is but a start.
constexpr double kFunctionTolerance = 1e-4;
constexpr double kParameterTolerance = 1e-3;
constexpr int kMaxIterations = 12;
constexpr double kShareOfRange = 0.125;  // of a parameter, for the deviation of what is believed of it

// What a stage believes of a parameter, about what the one before it has found.
ParameterPrior Belief(const ParameterBlock& block, double coordinate) {
  const double spread = kShareOfRange * block.CoordinateRange();
  return {block.ToValue(coordinate), block.scale == ParameterScale::kLog ? std::exp(spread) : spread * block.unit};
}

// Of `from` to those of `to`: units of a recording's own parameters depend on its frames and forces.
Eigen::VectorXd ConvertCoordinates(const FitProblem& from, const FitProblem& to, Eigen::VectorXd coordinates) {
  for (int i = 0; i < from.num_blocks(); ++i) coordinates[i] *= from.blocks()[i].unit / to.blocks()[i].unit;
  return coordinates;
}

// How many of these increasing times are not after `end`, but at least kFewestFrames where there are as many.
int NumUntil(const Eigen::VectorXd& times, double end) {
  const auto within = static_cast<int>(std::upper_bound(times.begin(), times.end(), end) - times.begin());
  return std::min(std::max(within, kFewestFrames), static_cast<int>(times.size()));
}

}  // namespace

RecordedMotion FirstFrames(const RecordedMotion& motion, double share) {
  const double end = motion.times[0] + share * (motion.times[motion.num_frames() - 1] - motion.times[0]);
  const int count = NumUntil(motion.times, end);
  RecordedMotion first = motion;
  first.centroid = TurnCenter(motion);
  first.times = motion.times.head(count);
  first.positions = motion.positions.leftCols(count);
  if (!motion.clouds.empty()) first.clouds.resize(static_cast<std::size_t>(count));
  if (!motion.forces.is_empty()) {
    const int num_readings = NumUntil(motion.forces.times, end);
    first.forces.times = motion.forces.times.head(num_readings);
    first.forces.values = motion.forces.values.leftCols(num_readings);
    if (first.forces.values.array().isNaN().all()) first.forces = ForceReadings();
  }
  return first;
}

namespace {

FitOptions OptionsOf(const FitOptions& options, const FitProblem& problem, const Eigen::VectorXd& coordinates) {
  FitOptions stage = problem.WithWeights(options);
  stage.estimate_uncertainty = false;
  stage.on_iteration = nullptr;
  stage.on_stage = nullptr;
  if (options.precision == FitPrecision::kAdaptive) stage.precision = FitPrecision::kLoose;
  if (options.jacobian == JacobianMethod::kAdjoint && problem.has_few_blocks()) {
    stage.jacobian = JacobianMethod::kSensitivity;
  }
  stage.function_tolerance = std::max(options.function_tolerance, kFunctionTolerance);
  stage.parameter_tolerance = std::max(options.parameter_tolerance, kParameterTolerance);
  stage.max_iterations = std::min(options.max_iterations, kMaxIterations);
  for (int i = 0; i < problem.num_blocks(); ++i) {
    const ParameterBlock& block = problem.blocks()[i];
    stage.overrides.lower_bounds[block.name] = block.lower_bound;
    stage.overrides.upper_bounds[block.name] = block.upper_bound;
    if (block.frozen || !std::isnan(block.PriorStd())) continue;
    stage.overrides.priors[block.name] = Belief(block, coordinates[i]);
  }
  return stage;
}

// Of the first `share` of the time, starting at `coordinates` of `problem`; null where it holds nothing to fit.
std::unique_ptr<FitProblem> MakePart(const std::vector<RecordedMotion>& motions, const FitProblem& problem,
                                     const Eigen::VectorXd& coordinates, double share, const FitOptions& options) {
  std::vector<RecordedMotion> first;
  for (const RecordedMotion& motion : motions) {
    first.push_back(FirstFrames(motion, share));
    if (IsUnknown(motion.start_source)) first.back().start_source = StartSource::kSmoothed;
  }
  try {
    auto part = std::make_unique<FitProblem>(first, options, &problem);
    part->SetStart(ConvertCoordinates(problem, *part, coordinates));
    return part;
  } catch (const Error&) {  // all frames were accepted, so it is these few that say too little
    return nullptr;
  }
}

}  // namespace

bool FitFirstFrames(const std::vector<RecordedMotion>& motions, const FitOptions& options, const FitProblem& problem,
                    FitStage* stage, Lead* lead) {
  const FitOptions own = OptionsOf(options, problem, lead->coordinates);
  const std::unique_ptr<FitProblem> part = MakePart(motions, problem, lead->coordinates, stage->share, own);
  if (part == nullptr) {
    stage->state = StageState::kSkipped;
    stage->note = "its frames hold nothing to fit";
    return true;
  }
  const FitSummary summary = Descend(own, part.get());
  stage->state = StageState::kDone;
  stage->note = summary.message;
  stage->rollouts = summary.statistics.rollouts;
  stage->cost = summary.cost;
  lead->statistics += summary.statistics;
  lead->evaluation_seconds += summary.total_seconds - summary.solver_seconds;
  lead->last_step.resize(0);
  if (!summary.has_estimate() || summary.status == FitStatus::kFailed) return false;
  const Eigen::VectorXd& found = summary.next.size() > 0 ? summary.next : summary.coordinates;
  const Eigen::VectorXd end = ConvertCoordinates(*part, problem, found.head(problem.num_blocks()));
  lead->last_step = end - lead->coordinates;
  lead->coordinates = end;
  return true;
}

namespace {

// Whether the last of the first frames moved no parameter far: then all frames are not expected to, either.
bool IsSettled(const FitOptions& options, const FitProblem& problem, const Lead& lead, Precision precision) {
  return options.precision == FitPrecision::kAdaptive && precision == Precision::kLoose &&
         problem.num_unknowns() == 0 && lead.last_step.size() > 0 &&
         IsShort(problem, lead.coordinates, lead.last_step, kShortStep);
}

}  // namespace

Lead LeadByFirstFrames(const std::vector<RecordedMotion>& motions, const FitOptions& options, const FitProblem& problem,
                       Descent* descent) {
  Lead lead;
  lead.coordinates = descent->coordinates().head(problem.num_blocks());
  bool is_lost = false;
  for (std::size_t i = 0; i < descent->plan().size() && descent->plan()[i].share < 1.0; ++i) {
    if (options.is_cancelled()) return lead;
    if (is_lost) {
      descent->SkipStage(i, "the frames before found nothing");
      continue;
    }
    descent->BeginStage(i);
    if (i == 0) descent->recorder().AddStart();
    is_lost = !FitFirstFrames(motions, options, problem, &descent->plan()[i], &lead);
    descent->Tell(i);
  }
  Eigen::VectorXd led = descent->coordinates();
  led.head(problem.num_blocks()) = lead.coordinates;
  if (options.is_cancelled() || led == descent->coordinates()) return lead;
  descent->ArriveAt(led, IsSettled(options, problem, lead, descent->precision()));
  return lead;
}

void AddLead(const Lead& lead, FitSummary* summary) {
  summary->statistics += lead.statistics;
  summary->lead = lead.statistics;
  summary->solver_seconds = std::max(0.0, summary->solver_seconds - lead.evaluation_seconds);
}

}  // namespace clothid
