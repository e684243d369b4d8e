#include "sim/step/newton_course.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace clothid {
namespace {

constexpr double kLargestForcing = 0.1;    // tolerance of the linear system of a Newton iteration, ...
constexpr double kForcingInContact = 0.3;  // ... where contacts are likely to change on the way, ...
constexpr double kForcing = 0.9;           // ... its share of the square of the last reduction of the residual, ...
constexpr double kGoalShare = 0.3;         // ... and at least so much of the reduction that is left to do
constexpr double kSlowProgress = 0.9;      // a residual above this share of the one before last: a cycle
constexpr double kReversal = 0.25;         // an iteration this far against the one before, as a cosine: likewise
constexpr double kShortestFirstLength = 0.125;
constexpr int kSweptIterations = 8;  // after these many a step is hard for other reasons than its contacts
constexpr int kPatience = 30;        // iterations without progress before Newton's method gives up
constexpr double kProgress = 0.8;    // a residual below this share of the lowest one is progress

constexpr int kSweptPairIterations = 6;      // while pairs change, ...
constexpr int kSweptSettled = 8;             // ... and so many once they are settled
constexpr double kSettledShare = 0.1;        // of |Phi|, below which |R| is small
constexpr int kIdleIterations = 3;           // without progress: a cycle of branches, which shorter steps leave, ...
constexpr double kShortestPairLength = 0.2;  // ... from a half to about this
constexpr double kProgressOfSize = 0.95;     // of the lowest one: progress
constexpr int kMostPairIterations = 60;      // more of them seldom end: a shorter step does
constexpr int kEasyIterations = 20;          // after these many the step is hard, and linear systems ...
constexpr double kHardForcing = 1e-4;        // ... are solved to this tolerance

// The tolerance of a linear system where the last iteration has left `ratio` of the residual: the forcing term of
// Eisenstat and Walker 1996, choice 2, at most `largest`, but no more accurate than is needed where `left` of the
// residual may be left.
double Forcing(double ratio, double largest, double left) {
  return std::max(std::min(largest, kForcing * ratio * ratio), kGoalShare * left);
}

bool InContact(const StepPoint& point) {
  return std::any_of(point.responses.begin(), point.responses.end(),
                     [](const ContactResponse& response) { return response.branch != ContactBranch::kTakeOff; });
}

bool BranchesDiffer(const std::vector<ContactResponse>& a, const std::vector<ContactResponse>& b) {
  return !std::equal(a.begin(), a.end(), b.begin(), b.end(),
                     [](const auto& r, const auto& s) { return r.branch == s.branch; });
}

// Whether Newton's method gets on. In a stiff cloth the residual stays where it is for dozens of iterations, set by
// elastic forces far larger than those of the solution, while the potential falls; in a cycle neither does.
class Progress {
 public:
  explicit Progress(const StepPoint& start) : residual_(start.relative_residual), potential_(start.potential) {}

  bool Continues(const StepPoint& point) {
    const bool gets_on = point.relative_residual < kProgress * residual_ || point.potential < potential_;
    if (point.relative_residual < kProgress * residual_) residual_ = point.relative_residual;
    potential_ = std::min(potential_, point.potential);
    idle_ = gets_on ? 0 : idle_ + 1;
    return idle_ < kPatience;
  }

 private:
  double residual_, potential_;  // the lowest, for progress
  int idle_ = 0;                 // iterations
};

// Of a cloth that touches obstacles alone.
class ObstacleCourse : public NewtonCourse {
 public:
  ObstacleCourse(const StepProblem& problem, const StepPoint& start) : problem_(problem), progress_(start) {}

  IterationPlan Next(const StepPoint& point, const StepPoint& before, double goal) override {
    IterationPlan plan;
    // Without candidates the responses are those of an earlier step.
    const bool may_change = problem_.contacts().may_touch() && iteration_ < kSweptIterations;
    plan.is_swept =
        may_change && (iteration_ == 0 ? InContact(point) : BranchesDiffer(point.responses, before.responses));
    const double residual = point.relative_residual, ratio = last_ > 0.0 ? residual / last_ : 1.0;
    plan.forcing = Forcing(ratio, plan.is_swept ? kForcingInContact : kLargestForcing, goal / residual);
    const bool cycles = iteration_ >= 2 && point.relative_residual > kSlowProgress * before_last_ &&
                        change_.dot(last_change_) < -kReversal * change_.norm() * last_change_.norm();
    first_length_ = cycles ? std::max(0.5 * first_length_, kShortestFirstLength) : std::min(2.0 * first_length_, 1.0);
    plan.first_length = first_length_;
    before_last_ = last_;
    last_ = point.relative_residual;
    last_change_.swap(change_);
    change_ = -point.velocities;
    ++iteration_;
    return plan;
  }

  bool Continues(const StepPoint& point) override {
    change_ += point.velocities;
    return progress_.Continues(point);
  }

 private:
  const StepProblem& problem_;
  Progress progress_;
  int iteration_ = 0;
  Eigen::VectorXd change_, last_change_;  // of the velocities
  double first_length_ = 1.0;
  double before_last_ = 0.0, last_ = 0.0;  // relative residuals before the last iterations; 0: none
};

// Of a cloth that may touch itself.
class PairCourse : public NewtonCourse {
 public:
  explicit PairCourse(const StepProblem& problem) : problem_(problem) {}

  IterationPlan Next(const StepPoint& point, const StepPoint& before, double goal) override {
    const double size = problem_.ResidualSize(point);
    idle_ = size < kProgressOfSize * best_ ? 0 : idle_ + 1;
    best_ = std::min(best_, size);
    if (idle_ == 0) length_ = std::min(1.0, 2.0 * length_);
    if (idle_ > 0 && idle_ % kIdleIterations == 0) length_ = length_ > kShortestPairLength ? 0.5 * length_ : 1.0;
    const bool is_settled =
        iteration_ > 0 && PairsAreSettled(point) && !BranchesDiffer(point.pairs.responses, before.pairs.responses);
    num_settled_ += is_settled ? 1 : 0;
    IterationPlan plan;
    plan.explores = !is_settled;
    plan.is_swept = problem_.contacts().may_touch() &&
                    (is_settled ? num_settled_ <= kSweptSettled : iteration_ < kSweptPairIterations);
    plan.first_length = length_;
    plan.forcing =
        Forcing(iteration_ == 0 ? 1.0 : size / last_, iteration_ < kEasyIterations ? kLargestForcing : kHardForcing,
                goal / point.relative_residual);
    last_ = size;
    ++iteration_;
    return plan;
  }

  bool Continues(const StepPoint&) override { return iteration_ < kMostPairIterations; }

 private:
  const StepProblem& problem_;
  int iteration_ = 0, num_settled_ = 0;
  int idle_ = 0;  // iterations
  double length_ = 1.0, best_ = std::numeric_limits<double>::infinity(), last_ = 0.0;
};

}  // namespace

bool PairsAreSettled(const StepPoint& point) {
  return point.pairs.residuals.norm() <= kSettledShare * point.residual.norm();
}

std::unique_ptr<NewtonCourse> MakeCourse(const StepProblem& problem, const StepPoint& start) {
  if (problem.contacts().may_touch_itself()) return std::make_unique<PairCourse>(problem);
  return std::make_unique<ObstacleCourse>(problem, start);
}

}  // namespace clothid
