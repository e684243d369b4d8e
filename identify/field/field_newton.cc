#include "identify/field/field_newton.h"

#include <Eigen/SparseCholesky>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "identify/field/field_posterior.h"

namespace clothid {
namespace {

constexpr int kWeightNodes = 6;    // a side, of the curvature that the weight is chosen by
constexpr int kMostProducts = 40;  // of one step
// A step may change a field by this factor at first: logarithms, root mean square.
constexpr double kFirstRadius = 0.7;
constexpr double kSmallestRadius = 1e-6;
constexpr double kLargestLog = 9.2;  // a factor of 1e4 from the start
// The loose stage ends where a step promises less than this share of the cost; the fit, where it promises less than
// this in s^2, or this share.
constexpr double kLooseDecrease = 0.03;
constexpr double kFinalDecrease = 0.05, kFinalShare = 1e-4;
constexpr double kSteadyWeight = 0.5;  // the logarithm of lambda changes by less

double Now() { return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count(); }

struct Step {
  Eigen::VectorXd change;  // d [p + n]
  double decrease = 0.0;   // that the quadratic model promises
  bool is_cut = false;     // by the trust region
};

class GaussNewton {
 public:
  GaussNewton(FieldModel* model, const FieldFitOptions& options)
      : model_(model), options_(options), is_chosen_(!(options.weight > 0.0)), weight_(options.weight) {}

  bool Run(FieldPoint* point, FieldResult* result) {
    const FitOptions& fit = options_.fit;
    start_ = Now();
    Precision precision = point->precision;
    int iteration = 0;
    for (; iteration <= fit.max_iterations; ++iteration) {
      const bool is_steady = ChooseWeight(point);
      Tell(iteration, *point);
      if (fit.is_cancelled()) return Fail("stopped on request", result);
      const Step step = SolveStep(point);
      const double cost = Cost(*point);
      if (precision == Precision::kLoose && step.decrease <= kLooseDecrease * cost) {
        precision = Precision::kFull;
        const Eigen::VectorXd here = point->unknowns, next = Next(*point, step);
        if (!model_->MoveTo(next, precision, point) && !model_->MoveTo(here, precision, point)) {
          return Fail(model_->failure(), result);
        }
        continue;
      }
      if (is_steady && !step.is_cut && step.decrease <= std::max(kFinalDecrease * scale_, kFinalShare * cost)) break;
      if (!Try(step, precision, point)) break;
    }
    result->has_converged = iteration <= fit.max_iterations && radius_ > kSmallestRadius;
    result->message = result->has_converged            ? "converged"
                      : iteration > fit.max_iterations ? "stopped at max_iterations"
                                                       : "stopped where no shorter step lowers the cost";
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
    options_.on_iteration({iteration, Now() - start_, Cost(point), point.data_cost, weight_,
                           model_->BlockCoordinates(point.unknowns), model_->counts().rollouts, num_products_});
  }

  // Whether the weight is where it is to stay.
  bool ChooseWeight(FieldPoint* point) {
    if (!is_chosen_) {
      const double degrees = std::max(1, model_->num_measurements() - model_->size());
      scale_ = 2.0 * point->data_cost / degrees;
      if (model_->sigma_is_known()) scale_ = std::max(1.0, scale_);
      return true;
    }
    const FieldCurvature curvature(kWeightNodes, model_, point);
    const double before = weight_;
    // At first as good as flat: what a wrong level and wrong parameters leave unexplained must not become a field. Then
    // less and less smooth.
    if (!(before > 0.0)) weight_ = curvature.NextWeight(Theta(*point), point->data_cost, 1.0);
    for (int i = 0; before > 0.0 && i < 10; ++i) {
      weight_ = curvature.NextWeight(Theta(*point), point->data_cost, weight_);
    }
    weight_ = std::max(weight_, kWeightShare * before);
    scale_ = curvature.SquaredScale(point->data_cost, weight_);
    return before > 0.0 && std::abs(std::log(weight_ / before)) < kSteadyWeight;
  }

  // (lambda P + .. )^-1: what the preconditioner does to the fields; scalars are divided by their own curvature.
  void SetPreconditioner(FieldPoint* point) {
    const Eigen::Index n = model_->num_field_unknowns(), p = model_->num_scalars();
    Eigen::SparseMatrix<double> shifted = weight_ * model_->prior_matrix();
    const double shift = kMeanShift * weight_ / static_cast<double>(n);
    for (Eigen::Index i = 0; i < n; ++i) shifted.coeffRef(i, i) += shift;
    prior_factor_.compute(shifted);
    scalar_curvature_ = Eigen::VectorXd::Ones(p);
    // Any product brings the scalars' columns along.
    if (p > 0 && point->recordings.front().scalar_rows.size() == 0) model_->Times(Eigen::VectorXd::Zero(p + n), point);
    for (Eigen::Index i = 0; i < p; ++i) {
      double sum = 0.0;
      for (const FieldRecordingPoint& at : point->recordings) {
        if (at.scalar_rows.size() > 0) sum += at.scalar_rows.col(i).squaredNorm();
      }
      if (sum > 0.0) scalar_curvature_[i] = sum;
    }
  }

  Eigen::VectorXd Precondition(const Eigen::VectorXd& v) const {
    Eigen::VectorXd solved(v.size());
    solved.head(model_->num_scalars()) = v.head(model_->num_scalars()).cwiseQuotient(scalar_curvature_);
    solved.tail(model_->num_field_unknowns()) = prior_factor_.solve(v.tail(model_->num_field_unknowns()));
    return solved;
  }

  // Root mean square of the logarithms, and of the other unknowns.
  double Length(const Eigen::VectorXd& change) const {
    const double n = static_cast<double>(model_->num_field_unknowns());
    return std::sqrt(change.tail(model_->num_field_unknowns()).squaredNorm() / n +
                     change.head(model_->num_scalars()).squaredNorm());
  }

  // Parameters that are pushed against a bound stay.
  void Hold(const Eigen::VectorXd& unknowns, const Eigen::VectorXd& gradient) {
    held_.clear();
    for (int i = 0; i < model_->num_scalars(); ++i) {
      const ParameterBlock& block = model_->blocks()[model_->scalars()[i]];
      const double lower = block.ToCoordinate(block.lower_bound), upper = block.ToCoordinate(block.upper_bound);
      if ((unknowns[i] <= lower && gradient[i] > 0.0) || (unknowns[i] >= upper && gradient[i] < 0.0))
        held_.push_back(i);
    }
  }

  void ZeroHeld(Eigen::VectorXd* gradient) const {
    for (const int i : held_) (*gradient)[i] = 0.0;
  }

  Step SolveStep(FieldPoint* point) {
    const Eigen::Index n = model_->num_field_unknowns();
    Eigen::VectorXd gradient = model_->DataGradient(*point);
    gradient.tail(n) += weight_ * (model_->prior_matrix() * Theta(*point));
    Hold(point->unknowns, gradient);
    ZeroHeld(&gradient);
    SetPreconditioner(point);
    Step step;
    step.change = Eigen::VectorXd::Zero(model_->size());
    Eigen::VectorXd residual = -gradient, product = Eigen::VectorXd::Zero(model_->size());
    Eigen::VectorXd z = Precondition(residual);
    ZeroHeld(&z);
    Eigen::VectorXd direction = z;
    double square = residual.dot(z);
    const double size = std::sqrt(square), forcing = Forcing(size);
    for (int i = 0; i < kMostProducts && std::sqrt(square) > forcing * size && !options_.fit.is_cancelled(); ++i) {
      Eigen::VectorXd curved = model_->TimesCurvature(direction, point);
      curved.tail(n) += weight_ * (model_->prior_matrix() * direction.tail(n));
      ZeroHeld(&curved);
      ++num_products_;
      const double length = square / direction.dot(curved);
      step.is_cut = Length(step.change + length * direction) >= radius_;
      const double taken = step.is_cut ? ToBoundary(step.change, direction) : length;
      step.change += taken * direction;
      product += taken * curved;
      residual -= taken * curved;
      if (step.is_cut) break;
      z = Precondition(residual);
      ZeroHeld(&z);
      const double next = residual.dot(z);
      direction = z + (next / square) * direction;
      square = next;
    }
    step.decrease = -gradient.dot(step.change) - 0.5 * step.change.dot(product);
    return step;
  }

  // Loose at first, tighter as the gradient falls.
  double Forcing(double size) {
    if (!(first_size_ > 0.0)) first_size_ = size;
    return std::clamp(std::sqrt(size / first_size_), 0.05, 0.3);
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

  Eigen::VectorXd Next(const FieldPoint& point, const Step& step) const {
    Eigen::VectorXd next = point.unknowns + step.change;
    for (int i = 0; i < model_->num_scalars(); ++i) {
      const ParameterBlock& block = model_->blocks()[model_->scalars()[i]];
      next[i] = std::clamp(next[i], block.ToCoordinate(block.lower_bound), block.ToCoordinate(block.upper_bound));
    }
    auto theta = next.tail(model_->num_field_unknowns());
    theta = theta.cwiseMax(-kLargestLog).cwiseMin(kLargestLog);
    return next;
  }

  // Takes the step where it lowers the cost, and adapts the trust region; false where that has become too small.
  bool Try(const Step& step, Precision precision, FieldPoint* point) {
    FieldPoint trial;
    const bool works = model_->MoveTo(Next(*point, step), precision, &trial);
    const double ratio = works ? (Cost(*point) - Cost(trial)) / std::max(step.decrease, 1e-300) : -1.0;
    if (ratio < 0.1) {
      radius_ = 0.25 * std::min(radius_, Length(step.change));
    } else if (ratio > 0.75 && step.is_cut) {
      radius_ *= 2.0;
    }
    if (ratio > 1e-3) *point = std::move(trial);
    return radius_ > kSmallestRadius;
  }

  static constexpr double kWeightShare = 0.1;  // of the last, the least that the next may be
  // Of the smoothest field that is not flat, cos(pi x): pi^4, times the squares of the control nodes.
  static constexpr double kMeanShift = 97.0;

  FieldModel* model_;
  const FieldFitOptions& options_;
  bool is_chosen_;
  double weight_, scale_ = 0.0;  // lambda, s^2
  double start_ = 0.0, radius_ = kFirstRadius, first_size_ = 0.0;
  int num_products_ = 0;
  std::vector<int> held_;
  Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> prior_factor_;
  Eigen::VectorXd scalar_curvature_;
};

}  // namespace

bool RunFieldNewton(const FieldFitOptions& options, FieldModel* model, FieldPoint* point, FieldResult* result) {
  return GaussNewton(model, options).Run(point, result);
}

}  // namespace clothid
