// What a run knows of a fit beside the fit itself.
#ifndef CLOTHID_IDENTIFY_VERDICT_FIT_CHECKS_H_
#define CLOTHID_IDENTIFY_VERDICT_FIT_CHECKS_H_

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "datasets/checking/finding.h"
#include "identify/base/options.h"
#include "identify/checks/correction_check.h"
#include "identify/checks/discretization_check.h"
#include "identify/checks/gradient_check.h"
#include "identify/checks/holdout.h"
#include "identify/checks/lead_time.h"
#include "identify/checks/multi_start.h"
#include "identify/checks/prediction_check.h"
#include "identify/checks/profile.h"
#include "identify/checks/step_choice.h"
#include "identify/checks/step_error.h"
#include "identify/landscape/fit_landscape.h"
#include "identify/prediction/held_bands.h"
#include "identify/prediction/transfer.h"
#include "identify/repetition/repetitions.h"
#include "identify/verdict/recording_fit.h"
#include "identify/wind/wind_result.h"

namespace clothid {

// What a run looked at beside the fit itself, and how it was called. Absent: not asked for.
struct FitChecks {
  JacobianMethod jacobian = JacobianMethod::kAdjoint;
  std::optional<GradientCheck> gradient_check;
  std::optional<WindResult> wind;  // profiles over time
  std::optional<MultiStart> starts;
  std::vector<Profile> profiles;
  std::vector<FitLandscape> landscapes;  // which `MatchLandscape` has seen
  std::optional<StepChoice> step_choice;
  StepErrorEstimate step_error;
  std::optional<DiscretizationCheck> discretization;
  std::optional<Holdout> holdout;
  std::optional<HeldBands> held_bands;  // of what was held out, where the fit tells intervals
  // Over all recordings, of rollouts at the estimates that nothing corrects, where those of the fit were; absent where
  // one of them failed.
  std::optional<PredictionError> uncorrected_error;
  std::vector<LeadTimeError> lead_times;     // likewise of rollouts that are corrected up to a launch
  std::vector<CorrectionCheck> corrections;  // of every recording; empty: the fit corrected no rollouts
  std::vector<LastingForce> missing_forces;  // of all recordings together (identify/prediction/force_match.h)
  std::optional<Transfer> transfer;          // who predicts whom
  std::optional<Repetitions> repetitions;
  std::vector<EnergyGain> energy;                // of every recording; empty: nobody looked
  std::vector<SelfContactAudit> self_contact;    // likewise
  std::vector<RecordingFit> recordings;          // of `DescribeRecordings`; empty: nobody looked
  std::vector<std::vector<Finding>> findings;    // of every recording, before the fit
  std::vector<Eigen::MatrixXd> predicted_nodes;  // see identify/report/node_prediction.h
  std::string flags;                             // the command line
  std::uint64_t seed = 0;
  int num_threads = 1;
};

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_VERDICT_FIT_CHECKS_H_
