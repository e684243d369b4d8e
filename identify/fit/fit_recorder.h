// The iterations of a fit as they happen: which point was the best after each, told to whoever asked for it.
// Internal to identify/fit.
#ifndef CLOTHID_IDENTIFY_FIT_FIT_RECORDER_H_
#define CLOTHID_IDENTIFY_FIT_FIT_RECORDER_H_

#include <ceres/iteration_callback.h>

#include <chrono>
#include <string>
#include <vector>

#include "identify/base/options.h"
#include "identify/problem/evaluator.h"
#include "identify/problem/problem.h"

namespace clothid {

// The first trust region of Levenberg-Marquardt: its inverse is the damping relative to the diagonal of J^T J. The
// problems are small and their Jacobians exact, so a step may be nearly Gauss-Newton's from the start.
inline constexpr double kInitialTrustRegion = 1e2;

// What a stage of the fit is to reach: a run of the optimiser at one precision.
struct StageGoal {
  Precision precision = Precision::kFull;
  double step = 1.0;                // the next step, in resolutions of the parameters, ...
  double function_tolerance = 0.0;  // ... or its relative decrease of the cost
  double trust_region = kInitialTrustRegion;
  int first_iteration = 0;  // the number of its first
  bool has_rows = true;     // whose rows tell of the next step
  // Every point gets exact rows along with its rollout: of a stage whose points are likely to be the last.
  bool has_exact_rows = false;
};

// Records the best point after every iteration, reports it, and passes on the wish to stop.
class FitRecorder : public ceres::IterationCallback {
 public:
  // Keeps references to all three.
  FitRecorder(const FitOptions& options, const FitProblem& problem, const FitEvaluator& evaluator);

  // Ends the stage where its goal is reached.
  ceres::CallbackReturnType operator()(const ceres::IterationSummary& summary) override;

  // The start, of a fit whose first stage begins elsewhere.
  void AddStart();
  void StartStage(const StageGoal& goal);
  // The step that ended the fit was evaluated, but its iteration was never reported.
  void AddLast();

  // Why a point has failed since the last iteration was reported; empty where none has.
  std::string failure() const;
  const std::vector<FitIteration>& iterations() const { return iterations_; }
  int last_iteration() const { return iterations_.empty() ? 0 : iterations_.back().iteration; }
  int next_iteration() const { return iterations_.empty() ? 0 : iterations_.back().iteration + 1; }
  double seconds() const;  // since it was made

 private:
  void Add(int iteration);

  const FitOptions& options_;
  const FitProblem& problem_;
  const FitEvaluator& evaluator_;
  StageGoal goal_;
  int num_failures_ = 0;  // until the last iteration
  std::chrono::steady_clock::time_point start_;
  std::vector<FitIteration> iterations_;
};

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_FIT_FIT_RECORDER_H_
