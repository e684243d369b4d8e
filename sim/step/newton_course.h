// How Newton's method goes about a step: before every iteration it is asked for a plan, after it whether it gets on.
#ifndef CLOTHID_SIM_STEP_NEWTON_COURSE_H_
#define CLOTHID_SIM_STEP_NEWTON_COURSE_H_

#include <memory>

#include "sim/step/step_problem.h"

namespace clothid {

struct IterationPlan {
  double forcing = 0.1;       // tolerance of its linear system
  double first_length = 1.0;  // that is tried along its direction
  bool is_swept = false;      // with ContactSweeps
  // Takes the first length at which the residual does not explode: it rises on the way of an iteration that changes
  // branches of pairs.
  bool explores = false;
};

class NewtonCourse {
 public:
  virtual ~NewtonCourse() = default;
  // Of the next iteration, from `point`. `before`: where the last one started, if there was one. `goal`: the relative
  // residual that is asked for at `point`.
  virtual IterationPlan Next(const StepPoint& point, const StepPoint& before, double goal) = 0;
  // After an iteration that ends at `point`: false where Newton's method does not get on.
  virtual bool Continues(const StepPoint& point) = 0;
};

// |R| is small beside |Phi|.
bool PairsAreSettled(const StepPoint& point);

// From `start` on. Where obstacles are all that the cloth may touch, the length of the first trial is halved where an
// iteration undoes the one before it: a cycle between branches. Where it may touch itself, iterations explore, and are
// shortened where the size of the residual does not fall for three of them; once pairs keep their branches and are
// settled, obstacles and the cloth are what is left to solve. Both must outlive the object.
std::unique_ptr<NewtonCourse> MakeCourse(const StepProblem& problem, const StepPoint& start);

}  // namespace clothid

#endif  // CLOTHID_SIM_STEP_NEWTON_COURSE_H_
