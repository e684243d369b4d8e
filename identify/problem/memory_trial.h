// Fits whose rollouts the recordings correct (costs/assimilation/assimilation.h), from a short memory to a long one.
//
// They follow a fit without corrections whose residuals are no noise: those of consecutive frames resemble each other,
// so that the model errs, or the fit has ended in another minimum.
//
// A short memory judges what happens within a few frames: the cost is smooth and has one minimum, but fast waves, in
// which step and mesh err the most, decide. A long one judges slow motion, and its cost gets rough. So a fit goes
// through memories, each three times as long as the one before, from two frames up to a third of the recording, every
// one from the estimate of the last. It ends at the longest that serves: where an estimate jumps away from the one
// before, by more than chance explains, the cost has got other minima.
//
// Rollouts without corrections may explain the recordings as well: the fit that was there before is compared with the
// last trial, and stands where it costs no more. Where it has ended elsewhere, it is tried once more from the end of
// the trials, if a rollout there leaves about as much. What is left of noise alone falls with the memory, as
// corrections follow the noise and predictions from them have its error; where the model errs it rises. So where the
// longest memory leaves the least, it is tried as well.
//
// Corrected rollouts judge fast motion, which coarse steps damp. Where half the step would move the end of the trials
// by more than 5 %, and the first fit by less, and both agree as far as that lets anybody tell, the first fit stands,
// unless it has stalled.
//
// The estimates along the way are the picture of the model's error. Where they drift, the interval counts with it: the
// largest difference of an estimate to that of the end, over the memories that are at most five times shorter, is taken
// for a standard deviation.
#ifndef CLOTHID_IDENTIFY_PROBLEM_MEMORY_TRIAL_H_
#define CLOTHID_IDENTIFY_PROBLEM_MEMORY_TRIAL_H_

#include <Eigen/Core>
#include <string>
#include <vector>

#include "identify/problem/problem.h"

namespace clothid {

class FitEvaluator;
struct QuadraticModel;

// A fit with one memory.
struct MemoryTrial {
  double memory = 0.0;               // s
  Eigen::VectorXd coordinates;       // [p] of the blocks
  Eigen::VectorXd values;            // [p] in the parameters' own units
  Eigen::VectorXd std;               // [p] of q, of independent residuals; NaN: not told
  Eigen::VectorXd lower95, upper95;  // [p] of the values, by these; NaN likewise
  double cost = 0.0;                 // of the recordings alone
  double residual_scale = 0.0;       // s
};

// Those to try for the recordings of `problem`, in s, increasing.
std::vector<double> MemoriesOf(const FitProblem& problem);

// Why a recording cannot correct its rollouts, one line that names it; empty where all can.
std::string WhyNotAssimilated(const FitProblem& problem);

// What the evaluator's best point, the end of a fit with `memory`, says: where the next step of Gauss and Newton leads,
// and the cost that it promises, as a trial ends before the last digits are found.
MemoryTrial DescribeTrial(const FitProblem& problem, const FitEvaluator& evaluator, double memory);

// Whether the estimate of `next` follows from that of `last`, as far as both are sure of it.
bool Follows(const std::vector<ParameterBlock>& blocks, const MemoryTrial& last, const MemoryTrial& next);

// Whether the derivatives of `model` are those of rollouts that forget where they come from: stiff cloth that
// corrections drive may amplify every change without bound. Its cost then has no slope to follow, and no width. So it
// is where a unit of the coordinate of a parameter moves what is measured by more than kMostMoved times the size of the
// cloth, in the mean.
inline constexpr double kMostMoved = 100.0;
bool AmplifiesBeyondTheCloth(const FitProblem& problem, const QuadraticModel& model);

// Whether what predictions without corrections of `cost`, per recording [R x T] m, leave is rounding, or as noise is:
// of another sign from frame to frame.
bool LeavesNoise(const FitProblem& problem, const std::vector<Eigen::MatrixXd>& predicted, double cost);

// Rollouts without corrections and the last of the trials. Whether they leave about as much where they are; whether,
// whatever they cost, nothing but noise may be left: the last of several trials leaves the least; and whether the end
// of a fit of them explains the recordings as well, or leaves rounding. All true where there is no trial.
bool LeavesAsLittle(double uncorrected_cost, const std::vector<MemoryTrial>& trials);
bool MayBeNoise(const std::vector<MemoryTrial>& trials);
bool IsNoWorse(double uncorrected_cost, const std::vector<MemoryTrial>& trials);

// The shortest memory, s, whose estimate counts in the drift towards the last of the trials, which are not none.
double FirstMemoryOfDrift(const std::vector<MemoryTrial>& trials);
// How far estimates of q drift [p] towards the last of the trials, which has ended at `coordinates` [p].
Eigen::VectorXd DriftOf(const std::vector<MemoryTrial>& trials, const Eigen::VectorXd& coordinates);

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_PROBLEM_MEMORY_TRIAL_H_
