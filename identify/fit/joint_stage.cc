#include "identify/fit/joint_stage.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "identify/fit/krylov_step.h"
#include "identify/fit/stage_rows.h"
#include "identify/problem/weight_choice.h"

namespace clothid {
namespace {

// A stage ends where what the next step promises, in s^2, is less: by moving the parameters, a step of 0.45 standard
// deviations with loose rollouts, whose errors are of that size, and of 0.1 with full ones; in all, per unknown, a step
// of 0.2 standard deviations: unknowns that are off by so much in no common direction move no parameter further. Of
// fields, which are answers themselves, all of them together have a step of 0.3 left, or this share of the cost.
constexpr double kLooseDecrease = 0.1;
constexpr double kFullDecrease = 5e-3;
constexpr double kUnnoticedDecrease = 0.02;
constexpr double kFieldDecrease = 0.05, kFieldShare = 1e-5;
// A rough stage of fields ends where a step promises less than this share of the cost.
constexpr double kRoughShare = 0.03;
// A new H that gained no more than this per unknown, in s^2, will not gain more by another one: the cost has kinks.
constexpr double kStuckGain = 0.01;
// A step that lowers the cost by less than this share of what H says asks for a new one.
constexpr double kPoorStep = 0.2;
constexpr int kMostRounds = 8, kMostFieldRounds = 24;
constexpr int kMostIterations = 8;  // with one H
// Ceres shortens a step of bounded unknowns by a line search first.
constexpr int kMostShortenings = 4;
// Trust regions of Levenberg-Marquardt: the first, and how much larger than where the last ended the next H may start.
constexpr double kTrustRegion = 1e4;
constexpr double kRegionGrowth = 30.0;
// Half waves a side of the basis beyond which conjugate gradients go.
constexpr int kBasisModes = 8;
// H of fields serves on where it was made anew while their logarithms have moved by less, root mean square.
constexpr double kSameCurvature = 0.05;
// Numbers iterations on over several runs of Ceres, each of which starts with the point where the one before it ended.
class Renumbered : public ceres::IterationCallback {
 public:
  Renumbered(int num_before, ceres::IterationCallback* callback) : num_before_(num_before), callback_(callback) {}

  ceres::CallbackReturnType operator()(const ceres::IterationSummary& summary) override {
    if (summary.iteration == 0) return ceres::SOLVER_CONTINUE;
    ceres::IterationSummary renumbered = summary;
    renumbered.iteration += num_before_;
    return (*callback_)(renumbered);
  }

 private:
  int num_before_;
  ceres::IterationCallback* callback_;
};

// When a stage is at its end.
struct StageEnd {
  bool is_rough = false, is_loose = false, has_fields = false;
  int num_starts = 0;  // unknowns

  bool IsReached(const PredictedDecrease& next, double cost, double scale) const {
    if (is_rough && has_fields) return next.total <= kRoughShare * cost;
    if (has_fields) {
      return next.of_parameters <= kUnnoticedDecrease * scale &&
             next.total <=
                 std::max(kFieldDecrease * scale, kFieldShare * cost) + kUnnoticedDecrease * scale * num_starts;
    }
    return next.of_parameters <= (is_loose ? kLooseDecrease : kFullDecrease) * scale &&
           next.total <= kUnnoticedDecrease * scale * next.num_free;
  }
};

// Ends the run where the next step is negligible, or H no longer fits.
class StopLagging : public ceres::IterationCallback {
 public:
  StopLagging(const LaggedRows& rows, const double* free, const StageEnd& end, double scale)
      : rows_(rows), free_(free), end_(end), scale_(scale) {}

  ceres::CallbackReturnType operator()(const ceres::IterationSummary& summary) override {
    if (summary.iteration == 0) return ceres::SOLVER_CONTINUE;
    if (!summary.step_is_successful) {
      // Where H was made, shorter steps lead down; elsewhere they need not.
      return has_moved_ ? ceres::SOLVER_TERMINATE_SUCCESSFULLY : ceres::SOLVER_CONTINUE;
    }
    has_moved_ = true;
    const bool is_poor = summary.relative_decrease < kPoorStep;
    const PredictedDecrease next = rows_.DecreaseAt(rows_.Unknowns(free_), rows_.last_gradient());
    const bool is_enough = end_.IsReached(next, rows_.last_cost(), scale_);
    return is_poor || is_enough ? ceres::SOLVER_TERMINATE_SUCCESSFULLY : ceres::SOLVER_CONTINUE;
  }

 private:
  const LaggedRows& rows_;
  const double* free_;
  const StageEnd& end_;
  double scale_;
  bool has_moved_ = false;
};

class JointStage {
 public:
  JointStage(const FitOptions& options, const FitStage& stage, int max_iterations, BasisLinearization known,
             ceres::IterationCallback* callback, FitProblem* problem, Eigen::VectorXd* coordinates,
             FitEvaluator* evaluator)
      : options_(options),
        stage_(stage),
        max_iterations_(max_iterations),
        callback_(callback),
        problem_(problem),
        coordinates_(coordinates),
        evaluator_(evaluator) {
    end_ = {stage.is_rough, stage.precision == Precision::kLoose, stage.field_modes > 0,
            stage.with_starts ? problem->num_start_unknowns() : 0};
    UnknownBasis basis = MakeBasis(*problem, stage.with_starts, std::min(stage.field_modes, kBasisModes));
    goes_beyond_ = stage.field_modes == kAllModes && !basis.has_all_field_modes;
    if (known.basis.with_starts == basis.with_starts && known.basis.field_modes == basis.field_modes) {
      result_.known = std::move(known);
    }
    result_.known.basis = std::move(basis);
  }

  JointStageResult Run() {
    const int most_rounds = end_.has_fields || stage_.with_weights ? kMostFieldRounds : kMostRounds;
    for (int round = 0; round < most_rounds; ++round) {
      if (!Linearize(round > 0)) return Fail();
      WidenedBasis own = OwnBasis();
      std::optional<LaggedRows> rows;
      MakeRows(own, &rows);
      PredictedDecrease next = rows->DecreaseAt(*coordinates_, gradient_);
      // Outside of the basis only where inside of it nothing is left to gain.
      const bool is_beyond = goes_beyond_ && end_.IsReached(next, cost_, scale_);
      if (is_beyond) {
        if (!Widen(&own)) return Fail();
        MakeRows(own, &rows);
        next = rows->DecreaseAt(*coordinates_, gradient_);
      }
      result_.predicted_decrease = next.of_parameters / scale_;
      const bool is_at_end = CanEnd() && is_beyond == goes_beyond_ && end_.IsReached(next, cost_, scale_);
      result_.is_over = is_at_end;
      if (is_at_end || num_iterations_ >= max_iterations_ || options_.is_cancelled()) break;
      const double promised = next.total / scale_;
      RunCeres(&*rows);
      const double gained = (cost_ - rows->last_cost()) / scale_;
      gradient_ = rows->last_gradient();
      cost_ = rows->last_cost();
      next = rows->DecreaseAt(*coordinates_, gradient_);
      result_.predicted_decrease = next.of_parameters / scale_;
      const bool is_stuck = is_new_ && !(gained > kStuckGain * next.num_free);
      const bool is_over = is_stuck || end_.IsReached(next, cost_, scale_);
      num_stuck_ += is_stuck ? 1 : 0;
      result_.is_over = (CanEnd() && is_over && !goes_beyond_) || num_stuck_ > 1;
      if (result_.is_over || options_.is_cancelled()) break;
      needs_new_ = !is_new_ || !(gained > kPoorStep * promised);
    }
    result_.ok = true;
    if (gradient_.size() > 0) SetData();
    return std::move(result_);
  }

 private:
  // The last word on fields is that of an H made for it: their standard deviations come of it, too.
  bool CanEnd() const { return stage_.is_rough || (weights_.is_steady && (is_new_ || !end_.has_fields)); }

  JointStageResult Fail() {
    result_.failure = evaluator_->last_failure();
    return std::move(result_);
  }

  // Gradient, cost, weights and scale at the point, with a new Jacobian where the last does not serve.
  bool Linearize(bool is_later) {
    Linearization& own = result_.known.linearization;
    is_new_ = own.jacobian.size() == 0 || (is_later && (!end_.has_fields || needs_new_ || HasMovedFar()));
    if (is_new_) {
      if (!evaluator_->Linearize(*coordinates_, basis().combinations, &own, stage_.precision)) return false;
      result_.known.made_at = *coordinates_;
    }
    // The gradient of the adjoint is as exact as the rollout; that of the sweep is not.
    if (!Evaluate()) return false;
    SetData();
    if (!stage_.with_weights) return true;
    weights_ = ChooseWeights(result_.known, *coordinates_, problem_);
    evaluator_->SupersedeBest();
    if (!Evaluate()) return false;
    scale_ = SquaredScale();
    return true;
  }

  bool Evaluate() {
    return evaluator_->Evaluate(*coordinates_, FitEvaluator::Derivative::kGradient, &cost_, &gradient_,
                                stage_.precision);
  }

  // Takes all that is believed but of starts out of the linearization's gradient and residuals.
  void SetData() {
    Linearization& own = result_.known.linearization;
    own.gradient = basis().Restrict(gradient_ - problem_->PriorGradient(*coordinates_));
    own.squared_residual = 2.0 * (cost_ - problem_->PriorCost(*coordinates_));
    scale_ = SquaredScale();
  }

  bool HasMovedFar() const {
    const Eigen::Index f = problem_->num_field_unknowns();
    const Eigen::VectorXd moved = *coordinates_ - result_.known.made_at;
    return moved.tail(f).norm() > kSameCurvature * std::sqrt(static_cast<double>(f)) ||
           moved.head(problem_->num_blocks()).norm() > kSameCurvature;
  }

  double SquaredScale() const {
    return result_.known.linearization.SquaredScale(problem_->num_blocks() + weights_.num_determined);
  }

  WidenedBasis OwnBasis() const {
    const Eigen::MatrixXd& jacobian = result_.known.linearization.jacobian;
    const Eigen::MatrixXd believed = problem_->PriorRows(basis().combinations);
    return {basis(), jacobian.transpose() * jacobian + believed.transpose() * believed};
  }

  bool Widen(WidenedBasis* own) {
    const Eigen::MatrixXd hessian = own->hessian;
    return WidenBasis(options_, *problem_, basis(), hessian, *coordinates_, gradient_, stage_.precision, evaluator_,
                      own);
  }

  void MakeRows(const WidenedBasis& own, std::optional<LaggedRows>* rows) const {
    rows->emplace(*problem_, own.basis, own.hessian, gradient_, cost_, *coordinates_, stage_.precision, evaluator_);
  }

  // A few iterations with one H.
  void RunCeres(LaggedRows* rows) {
    Eigen::VectorXd free = rows->FreeCoordinates(*coordinates_);
    const std::unique_ptr<ceres::Problem> ceres_problem = rows->MakeCeresProblem(free.data());
    StopLagging stop(*rows, free.data(), end_, scale_);
    Renumbered renumbered(num_iterations_, callback_);
    // The answer to weights that are on their way is not worth more than a step.
    const int most = weights_.is_steady ? kMostIterations : 1;
    ceres::Solver::Options solver =
        StageSolver(trust_region_, std::min(max_iterations_ - num_iterations_, most), options_.parameter_tolerance);
    solver.max_num_line_search_step_size_iterations = kMostShortenings;
    solver.function_tolerance = 0.0;
    solver.update_state_every_iteration = true;
    solver.callbacks = {&renumbered, &stop};
    ceres::Solver::Summary summary;
    ceres::Solve(solver, ceres_problem.get(), &summary);
    *coordinates_ = rows->Unknowns(free.data());
    trust_region_ = std::min(kTrustRegion, kRegionGrowth * summary.iterations.back().trust_region_radius);
    num_iterations_ += static_cast<int>(summary.iterations.size()) - 1;
  }

  const UnknownBasis& basis() const { return result_.known.basis; }

  const FitOptions& options_;
  const FitStage& stage_;
  int max_iterations_;
  ceres::IterationCallback* callback_;
  FitProblem* problem_;
  Eigen::VectorXd* coordinates_;
  FitEvaluator* evaluator_;
  StageEnd end_;
  bool goes_beyond_ = false;  // outside of the basis
  JointStageResult result_;
  bool is_new_ = false, needs_new_ = false;
  WeightChoice weights_;
  double cost_ = 0.0, scale_ = 1.0;
  Eigen::VectorXd gradient_;
  int num_iterations_ = 0, num_stuck_ = 0;
  double trust_region_ = kTrustRegion;
};

}  // namespace

JointStageResult RunJointStage(const FitOptions& options, const FitStage& stage, int max_iterations,
                               BasisLinearization known, ceres::IterationCallback* callback, FitProblem* problem,
                               Eigen::VectorXd* coordinates, FitEvaluator* evaluator) {
  return JointStage(options, stage, max_iterations, std::move(known), callback, problem, coordinates, evaluator).Run();
}

}  // namespace clothid
