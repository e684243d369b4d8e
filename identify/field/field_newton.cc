#include "identify/field/field_newton.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "identify/field/field_posterior.h"
#include "identify/field/field_preconditioner.h"
#include "sim/base/phase_seconds.h"

namespace clothid {
namespace {

// Half waves a side of the smoothest modes that the fit has at first, then; after that all. Of the last the curvature
// is that which the weight is chosen by and the preconditioner has.
constexpr int kStageModes[] = {4, 8};
constexpr int kNumStages = 2;
constexpr int kMostProducts = 40;  // of one step
constexpr double kForcing = 0.1;   // of the gradient, what a step may leave
// A step may change a field by this factor at first: logarithms, root mean square.
constexpr double kFirstRadius = 0.7;
constexpr double kLargestLog = 9.2;  // a factor of 1e4 from the start
// Of a step that does not lower the cost by this share of what it promises, shorter ones are tried.
constexpr double kLeastRatio = 1e-3, kShorter = 0.3;
constexpr int kMostTrials = 7;
// A stage of few modes and the loose one end where a step promises less than this share of the cost; the fit, where it
// promises less than this in s^2, or this share.
constexpr double kLooseDecrease = 0.03;
constexpr double kFinalDecrease = 0.05, kFinalShare = 1e-5;
constexpr double kSteadyWeight = 0.5;  // the logarithm of lambda changes by less
// A curvature serves on while logarithms have moved by less, root mean square.
constexpr double kSameCurvature = 0.05;

struct Step {
  Eigen::VectorXd change;               // d [p + n]
  double slope = 0.0, curvature = 0.0;  // g^T d and d^T H d
  bool is_cut = false;                  // by the trust region

  // What the quadratic model promises of a share of it.
  double Decrease(double share) const { return -share * slope - 0.5 * share * share * curvature; }
};

enum class End { kNone, kConverged, kStuck };

class GaussNewton {
 public:
  GaussNewton(FieldModel* model, const FieldFitOptions& options)
      : model_(model), options_(options), is_chosen_(!(options.weight > 0.0)), weight_(options.weight) {}

  bool Run(FieldPoint* point, FieldResult* result) {
    const FitOptions& fit = options_.fit;
    start_ = SteadySeconds();
    int iteration = 0;
    for (; iteration <= fit.max_iterations; ++iteration) {
      Linearize(point);
      Tell(iteration, *point);
      if (fit.is_cancelled()) return Fail("stopped on request", result);
      if (!Advance(SolveStep(point), point)) return Fail(model_->failure(), result);
      if (end_ != End::kNone) break;
    }
    result->has_converged = end_ == End::kConverged;
    result->message = result->has_converged ? "converged"
                      : end_ == End::kStuck ? "stopped where no shorter step lowers the cost"
                                            : "stopped at max_iterations";
    result->num_iterations = std::min(iteration, fit.max_iterations);
    result->weight = weight_;
    return true;
  }

 private:
  static bool Fail(const std::string& reason, FieldResult* result) {
    result->message = reason;
    return false;
  }

  Eigen::VectorXd Theta(const FieldPoint& point) const { return point.unknowns.tail(model_->num_field_unknowns()); }

  double Prior(const Eigen::VectorXd& unknowns) const {
    return 0.5 * weight_ * (model_->prior_root() * unknowns.tail(model_->num_field_unknowns())).squaredNorm();
  }
  double Cost(const FieldPoint& point) const { return point.data_cost + Prior(point.unknowns); }

  void Tell(int iteration, const FieldPoint& point) const {
    if (!options_.on_iteration) return;
    options_.on_iteration({iteration, SteadySeconds() - start_, Cost(point), point.data_cost, weight_,
                           model_->BlockCoordinates(point.unknowns), model_->counts().rollouts, num_products_});
  }

  bool has_all_modes() const { return stage_ == kNumStages; }

  // Takes the step and goes over to what is next where it promises little: more modes, full precision, the end. False
  // where the fit cannot go on.
  bool Advance(const Step& step, FieldPoint* point) {
    const double cost = Cost(*point), decrease = step.Decrease(1.0);
    const bool is_loose = point->precision == Precision::kLoose, is_little = decrease <= kLooseDecrease * cost;
    if (!has_all_modes()) {
      const bool works = decrease > kFinalDecrease * scale_ && Try(step, point);
      if (is_little || !works) ++stage_;
      return true;
    }
    if (is_loose && is_little) return MoveToFull(step, point);
    if (!step.is_cut && decrease <= std::max(kFinalDecrease * scale_, kFinalShare * cost)) {
      if (is_steady_) end_ = End::kConverged;
      return true;  // the next weight may ask for more
    }
    if (Try(step, point)) return true;
    if (is_loose) return MoveToFull({Eigen::VectorXd::Zero(model_->size())}, point);
    if (curvature_at_ == point->unknowns) end_ = End::kStuck;
    curvature_modes_ = 0;  // a curvature of this very point may find a step
    return true;
  }

  // At the end of the step, or, where that cannot be simulated, here.
  bool MoveToFull(const Step& step, FieldPoint* point) {
    const Eigen::VectorXd here = point->unknowns, next = Next(*point, step, 1.0);
    return model_->MoveTo(next, Precision::kFull, point) || model_->MoveTo(here, Precision::kFull, point);
  }

  // Sets gradient, curvature, weight and preconditioner.
  void Linearize(FieldPoint* point) {
    const Eigen::VectorXd theta = Theta(*point);
    data_gradient_ = model_->DataGradient(*point);
    FormCurvature(point);
    const double before = weight_;
    if (is_chosen_) weight_ = curvature_->FollowWeight(theta, data_gradient_, point->data_cost, weight_);
    is_steady_ = !is_chosen_ || (before > 0.0 && std::abs(std::log(weight_ / before)) < kSteadyWeight);
    scale_ = curvature_->SquaredScale(point->data_cost, weight_);
    gradient_ = data_gradient_;
    gradient_.tail(theta.size()) += weight_ * (model_->prior_matrix() * theta);
    Hold(point->unknowns);
    ZeroHeld(&gradient_);
    preconditioner_ = std::make_unique<FieldPreconditioner>(*curvature_, weight_, *model_, held_);
  }

  // Where there are no more modes than a stage has, it is the last.
  void FormCurvature(FieldPoint* point) {
    const int modes = kStageModes[std::min(stage_, kNumStages - 1)];
    if (modes == curvature_modes_ && Length(point->unknowns - curvature_at_) < kSameCurvature) return;
    curvature_.emplace(modes, model_, point);
    curvature_modes_ = modes;
    curvature_at_ = point->unknowns;
    if (!curvature_->is_complete()) return;
    stage_ = kNumStages;
    curvature_modes_ = kStageModes[kNumStages - 1];
  }

  // Root mean square of the logarithms, and of the other unknowns.
  double Length(const Eigen::VectorXd& change) const {
    const double n = static_cast<double>(model_->num_field_unknowns());
    return std::sqrt(change.tail(model_->num_field_unknowns()).squaredNorm() / n +
                     change.head(model_->num_scalars()).squaredNorm());
  }

  // Parameters that are pushed against a bound stay.
  void Hold(const Eigen::VectorXd& unknowns) {
    held_.clear();
    for (int i = 0; i < model_->num_scalars(); ++i) {
      const ParameterBlock& block = model_->blocks()[model_->scalars()[i]];
      const double lower = block.ToCoordinate(block.lower_bound), upper = block.ToCoordinate(block.upper_bound);
      if ((unknowns[i] <= lower && gradient_[i] > 0.0) || (unknowns[i] >= upper && gradient_[i] < 0.0))
        held_.push_back(i);
    }
  }

  void ZeroHeld(Eigen::VectorXd* vector) const {
    for (const int i : held_) (*vector)[i] = 0.0;
  }

  Eigen::VectorXd Precondition(const Eigen::VectorXd& v) const {
    Eigen::VectorXd solved = preconditioner_->Solve(v);
    ZeroHeld(&solved);
    return solved;
  }

  // H times `direction`.
  Eigen::VectorXd TimesHessian(const Eigen::VectorXd& direction, FieldPoint* point) {
    const Eigen::Index n = model_->num_field_unknowns();
    Eigen::VectorXd curved = model_->TimesCurvature(direction, point);
    curved.tail(n) += weight_ * (model_->prior_matrix() * direction.tail(n));
    ZeroHeld(&curved);
    ++num_products_;
    return curved;
  }

  Step SolveStep(FieldPoint* point) {
    return has_all_modes() && !curvature_->is_complete() ? SolveOverAll(point) : SolveOverModes(*point);
  }

  // Without any product.
  Step SolveOverModes(const FieldPoint& point) const {
    Eigen::VectorXd change = curvature_->Step(Theta(point), data_gradient_, weight_, held_);
    Step step;
    const double length = Length(curvature_->basis() * change);
    step.is_cut = length >= radius_;
    if (step.is_cut) change *= radius_ / length;
    step.change = curvature_->basis() * change;
    step.slope = gradient_.dot(step.change);
    step.curvature = change.dot(curvature_->Hessian(weight_) * change);
    return step;
  }

  Step SolveOverAll(FieldPoint* point) {
    Step step;
    step.change = Eigen::VectorXd::Zero(model_->size());
    Eigen::VectorXd residual = -gradient_, product = Eigen::VectorXd::Zero(model_->size());
    Eigen::VectorXd z = Precondition(residual), direction = z;
    double square = residual.dot(z);
    const double enough = kForcing * kForcing * square;
    for (int i = 0; i < kMostProducts && square > enough && !options_.fit.is_cancelled(); ++i) {
      const Eigen::VectorXd curved = TimesHessian(direction, point);
      const double length = square / direction.dot(curved);
      step.is_cut = Length(step.change + length * direction) >= radius_;
      const double taken = step.is_cut ? ToBoundary(step.change, direction) : length;
      step.change += taken * direction;
      product += taken * curved;
      residual -= taken * curved;
      if (step.is_cut) break;
      z = Precondition(residual);
      const double next = residual.dot(z);
      direction = z + (next / square) * direction;
      square = next;
    }
    step.slope = gradient_.dot(step.change);
    step.curvature = step.change.dot(product);
    return step;
  }

  // The factor of `direction` that leads from `change` to the boundary of the trust region.
  double ToBoundary(const Eigen::VectorXd& change, const Eigen::VectorXd& direction) const {
    double low = 0.0, high = 1.0;
    while (Length(change + high * direction) < radius_) high *= 2.0;
    for (int i = 0; i < 60; ++i) {
      const double middle = 0.5 * (low + high);
      (Length(change + middle * direction) < radius_ ? low : high) = middle;
    }
    return low;
  }

  Eigen::VectorXd Next(const FieldPoint& point, const Step& step, double share) const {
    Eigen::VectorXd next = point.unknowns + share * step.change;
    for (int i = 0; i < model_->num_scalars(); ++i) {
      const ParameterBlock& block = model_->blocks()[model_->scalars()[i]];
      next[i] = std::clamp(next[i], block.ToCoordinate(block.lower_bound), block.ToCoordinate(block.upper_bound));
    }
    auto theta = next.tail(model_->num_field_unknowns());
    theta = theta.cwiseMax(-kLargestLog).cwiseMin(kLargestLog);
    return next;
  }

  // Takes the step, or a share of it, where that lowers the cost, and adapts the trust region; false where none does.
  bool Try(const Step& step, FieldPoint* point) {
    const double length = Length(step.change);
    double share = 1.0;
    for (int i = 0; i < kMostTrials && !options_.fit.is_cancelled(); ++i, share *= kShorter) {
      FieldPoint trial;
      const bool works = model_->MoveTo(Next(*point, step, share), point->precision, &trial);
      const double ratio = works ? (Cost(*point) - Cost(trial)) / std::max(step.Decrease(share), 1e-300) : -1.0;
      if (!(ratio > kLeastRatio)) continue;
      if (i > 0 || ratio < 0.1) {
        radius_ = std::max(share, kShorter) * length;
      } else if (ratio > 0.75 && step.is_cut) {
        radius_ *= 2.0;
      }
      *point = std::move(trial);
      return true;
    }
    return options_.fit.is_cancelled();
  }

  FieldModel* model_;
  const FieldFitOptions& options_;
  bool is_chosen_;
  double weight_, scale_ = 0.0;  // lambda, s^2
  double start_ = 0.0, radius_ = kFirstRadius;
  int stage_ = 0, num_products_ = 0;
  bool is_steady_ = false;  // the weight is where it is to stay
  End end_ = End::kNone;
  Eigen::VectorXd data_gradient_, gradient_;  // of the recordings, and of the cost with the prior, zero where held
  std::vector<int> held_;
  std::optional<FieldCurvature> curvature_;
  int curvature_modes_ = 0;       // half waves a side, ..
  Eigen::VectorXd curvature_at_;  // .. and the unknowns that it was formed at
  std::unique_ptr<FieldPreconditioner> preconditioner_;
};

}  // namespace

bool RunFieldNewton(const FieldFitOptions& options, FieldModel* model, FieldPoint* point, FieldResult* result) {
  return GaussNewton(model, options).Run(point, result);
}

}  // namespace clothid
