// One way down the cost: a point that the stages of a plan move, one after the other. Internal to identify/fit.
//
// The parameters alone: Ceres' Levenberg-Marquardt with their bounds, with loose rollouts until the Gauss-Newton step
// changes no parameter by more than 5 %, and from where that step leads with full ones. Where first frames have led it
// so near, it runs with full ones alone. With few parameters, points near the solution get exact rows along with their
// rollout: the sweep that the intervals of the last one need. Forward differences need full precision throughout.
// With other unknowns: identify/fit/joint_stage.h.
#ifndef CLOTHID_IDENTIFY_FIT_DESCENT_H_
#define CLOTHID_IDENTIFY_FIT_DESCENT_H_

#include <Eigen/Core>
#include <cstddef>

#include "identify/base/options.h"
#include "identify/estimate/fit_summary.h"
#include "identify/fit/fit_recorder.h"
#include "identify/problem/evaluator.h"
#include "identify/problem/problem.h"
#include "identify/problem/unknown_basis.h"

namespace clothid {

// A step of a loose stage that is shorter than this, in resolutions of the parameters, 5 %, ends it. Its square is what
// a Gauss-Newton step misses, and about what loose rollouts do.
inline constexpr double kShortStep = 5e4;

class Descent {
 public:
  // From the starting values of `problem`. Keeps references to both.
  Descent(const FitOptions& options, FitProblem* problem);

  // Evaluates the start before a stage of `plan` runs, so that one that does not work is told with its reason. The
  // first stage finds it cached, with the rows that it asks for. False where it fails or there is nothing to run.
  bool Begin(FitPlan plan);
  // Runs what is still ahead, unless it is cancelled.
  void RunStages();
  // A stage of the plan in three parts: told as running, moved, told as done with how it has ended.
  void BeginStage(std::size_t stage);
  void Move(const FitStage& stage);
  void EndStage(std::size_t stage);
  void SkipStage(std::size_t stage, const char* why);
  void Tell(std::size_t stage) const;
  // Loose stages, and those with other weights, were never compared with the start as costs are at the end. Where the
  // start is lower, the last stage goes on from there. A start whose loose cost is twice that of the end is not.
  void GoOnFromLowerStart();
  // What has become of it. The estimate is the point of lowest cost of all that compare, where there is one and it
  // `is_answer`; a loose one is better than none only where somebody has stopped the fit there.
  FitSummary End(bool is_answer);

  // To a point that no stage has led to. `is_near`: near the solution, so that steps may be long, and nothing but full
  // precision is left to do; so below.
  void MoveTo(const Eigen::VectorXd& coordinates, bool is_near);
  // The same where the cost, evaluated with what the next stage asks for, is below that of the start. `is_settled`: it
  // may be near; then rows of full precision tell whether it is.
  void ArriveAt(const Eigen::VectorXd& coordinates, bool is_settled);
  // Puts `plan` after the stages that there are, and runs it.
  void GoOn(const FitPlan& plan, bool is_near);

  const Eigen::VectorXd& coordinates() const { return coordinates_; }  // [p + n + f]
  Precision precision() const { return precision_; }                   // of the point
  double start_cost() const { return start_cost_; }
  // Whether there is a point that all others of the end compare with.
  bool has_point() const;
  FitPlan& plan() { return summary_.plan; }
  FitSummary& summary() { return summary_; }
  FitEvaluator& evaluator() { return evaluator_; }
  FitRecorder& recorder() { return recorder_; }
  // The rows of a point near the solution: where they are cheap, those that the intervals of the last one need.
  FitEvaluator::Derivative NearDerivative() const;

 private:
  void CountFromHere();
  bool is_near() const { return trust_region_ > kInitialTrustRegion; }
  // The number of the last iteration that a stage may end with: those of trials do not count.
  int most_iterations() const { return options_.max_iterations + num_trial_iterations_; }
  bool IsNeedless(const FitStage& stage) const;
  StageGoal GoalOf(const FitStage& stage) const;
  void MoveAlone(const FitStage& stage);
  void MoveJointly(const FitStage& stage);
  void GoOverToFull();
  bool TryPoint(const Eigen::VectorXd& point, FitEvaluator::Derivative derivative);

  const FitOptions& options_;
  FitProblem* problem_;
  Eigen::VectorXd coordinates_;
  FitEvaluator evaluator_;
  FitRecorder recorder_;
  FitSummary summary_;
  Precision precision_ = Precision::kFull;
  double start_cost_ = 0.0;
  double trust_region_ = kInitialTrustRegion;  // the first of the next stage: larger near the solution
  int num_trial_iterations_ = 0;
  int rollouts_before_ = 0;   // the stage that runs or comes next: those of arriving there are its own
  BasisLinearization known_;  // where the point is, from a joint stage
};

// The stages of `MakePlan`, from the start of `problem` to the end.
FitSummary Descend(const FitOptions& options, FitProblem* problem);

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_FIT_DESCENT_H_
