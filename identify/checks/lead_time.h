// How far predictions are off, by their lead time: how long ago they last saw a measurement.
//
// Up to a frame, the launch, the recording corrects the rollout (costs/assimilation/assimilation.h); from there on
// nothing does, and the frames that follow are compared with it. So the error is of state, parameters and model as far
// as they count over that time, whatever was long before. Beside it stands what a cloth misses that stays where it was
// seen at the launch: a prediction is worth something where it is less far off. Points that are compared with the
// surface count by their distance to it, and what was seen at the launch is the predicted surface there.
#ifndef CLOTHID_IDENTIFY_CHECKS_LEAD_TIME_H_
#define CLOTHID_IDENTIFY_CHECKS_LEAD_TIME_H_

#include <Eigen/Core>
#include <array>
#include <vector>

#include "costs/assimilation/assimilation.h"
#include "costs/prediction/recording_model.h"
#include "costs/prediction/robust_loss.h"
#include "datasets/motion/recorded_motion.h"
#include "identify/estimate/fit_summary.h"
#include "identify/problem/problem.h"

namespace clothid {

struct LeadTimeError {
  double lead = 0.0;        // s
  double rmse = 0.0;        // m, of a coordinate, or of a distance to the surface
  double still_rmse = 0.0;  // m, of a cloth that stays where it was at the launch
  int num_predictions = 0;  // launches whose frame after `lead` was seen
};

// Sums over launches and recordings.
class LeadTimes {
 public:
  // What corrects the rollouts until the launch; counts nothing where it is off.
  LeadTimes(const Assimilation& assimilation, const RobustLoss& loss) : assimilation_(assimilation), loss_(loss) {}

  // Simulates `model`, of `motion`, at `coordinates` once per launch: four, evenly over the recording. Nothing is
  // added by rollouts that fail and by recordings that cannot correct. Leaves the model without corrections.
  void Add(const RecordedMotion& motion, const Eigen::VectorXd& coordinates, RecordingModel* model);

  // Of those of .1, .2, .5 and 1 s that some launch was followed by, increasing.
  std::vector<LeadTimeError> Errors() const;

 private:
  struct Sum {
    double squared = 0.0, still = 0.0, num = 0.0;
    int num_predictions = 0;
  };
  // What is missed in `frame`; no prediction is counted.
  static Sum Compare(const RecordedMotion& motion, const Observation& observation, const Eigen::MatrixXd& predicted,
                     Eigen::Index launch, Eigen::Index frame);

  static constexpr std::array<double, 4> kLeads = {0.1, 0.2, 0.5, 1.0};  // s
  Assimilation assimilation_;
  RobustLoss loss_;
  std::array<Sum, kLeads.size()> sums_;
};

// How a fit has corrected rollouts: as its end, or with the last memory that served. Off: never.
Assimilation LastAssimilation(const FitSummary& summary);

// Of the fitted recordings at the estimate.
std::vector<LeadTimeError> PredictAhead(const std::vector<RecordedMotion>& motions, const FitProblem& problem,
                                        const FitSummary& summary, const RobustLoss& loss);

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_CHECKS_LEAD_TIME_H_
