// Reasons that lie in what the model misses.
#include <algorithm>
#include <cmath>
#include <limits>

#include "identify/verdict/model_error_text.h"
#include "identify/verdict/reason.h"

namespace clothid {
namespace {

// A start or a handle is where it was measured within so many standard deviations.
constexpr double kFarFromMeasured = 3.0;
// Estimates that drift by more than so many standard deviations of the noise, and by this share, ask for care.
constexpr double kFarDrift = 2.0;
constexpr double kSmallDrift = 0.01;
// Weights of frames that move an estimate by more than so many half-widths of its interval, and by this share, say that
// it is one of the model's error.
constexpr double kFarByWeights = 1.5;
constexpr double kLargeMove = 0.25;
// Correlations of innovations that noise explains; what of the weight of the cloth may be lacking without a word.
constexpr double kWhite = 0.1;
constexpr double kSmallForce = 0.01;

std::string StartName(const FitChecks& checks, int recording) {
  return checks.recordings.size() > 1 ? checks.recordings[recording].name + ": the start" : "the start";
}

// Unknowns that a fit moved to where nobody saw the cloth hide an error of the model, and with it move the parameters.
void AddMoved(const FitSummary& summary, const FitChecks& checks, std::vector<Reason>* reasons) {
  for (const StartEstimate& start : summary.starts) {
    const std::string name = StartName(checks, start.recording);
    if (start.first_frame_error > kFarFromMeasured * start.position_std) {
      const std::string brief =
          name + " moved by " + MillimetreText(start.first_frame_error, 2) + " from where the first frame shows it";
      reasons->push_back(Careful({}, brief,
                                 brief + ", beside the noise, " +
                                     NumberText(start.first_frame_error / start.position_std, 2) +
                                     " of its standard deviations: it takes over an error of the model, and parameters "
                                     "are moved with it"));
    }
    if (start.handle_error > kFarFromMeasured) {
      const std::string brief = name + " moved handles by " + NumberText(start.handle_error, 2) +
                                " standard deviations of what was measured of them";
      reasons->push_back(
          Careful({}, brief, brief + ": they take over an error of the model, and parameters are moved with them"));
    }
  }
}

void AddMisses(const RecordingFit& recording, const std::string& prefix, std::vector<Reason>* reasons) {
  const std::string misses = ModelErrorText(recording.model_error);
  if (misses.empty()) return;
  const double largest = std::max(LargestDistance(recording.model_error, PredictedKind::kPoints),
                                  LargestDistance(recording.model_error, PredictedKind::kClouds));
  const std::string brief = prefix + "the model misses " + misses;
  const std::string line =
      brief + (std::isnan(recording.noise) ? "" : ", beside noise of " + MillimetreText(recording.noise, 3)) +
      ": frames count for less where it errs, and intervals count with that";
  reasons->push_back(largest > 0.0 && !(largest <= recording.noise) ? Careful({}, brief, line) : Remark(line));
}

// Two fits of the same frames, all alike and as the model errs, disagree: then what it errs by is not random, and no
// interval that takes it for that is worth anything.
void AddWeights(const FitSummary& summary, std::vector<Reason>* reasons) {
  if (summary.unweighed_values.size() == 0 || !summary.uncertainty) return;
  for (std::size_t i = 0; i < summary.parameters.size(); ++i) {
    const FittedParameter& parameter = summary.parameters[i];
    const ParameterUncertainty& uncertainty = summary.uncertainty->parameters[i];
    const bool is_log = parameter.scale == ParameterScale::kLog;
    const auto coordinate = [is_log](double value) { return is_log ? std::log(value) : value; };
    const double before = summary.unweighed_values[static_cast<Eigen::Index>(i)];
    const double at = coordinate(parameter.value), move = std::abs(coordinate(before) - at);
    const double half_width = std::max(coordinate(uncertainty.upper95) - at, at - coordinate(uncertainty.lower95));
    const double share = is_log ? move : move / std::abs(parameter.value);
    if (!(move > kFarByWeights * half_width) || !(share > kLargeMove)) continue;
    const std::string brief = parameter.name + " hangs on how frames are weighed";
    reasons->push_back(AgainstAll(
        /*is_grave=*/true, brief,
        brief + ": " + NumberText(before, 4) + " where all count alike, " + NumberText(parameter.value, 4) +
            " where they count for less as the model errs: its error is no chance, and intervals do not know of it; "
            "see --discretization mesh"));
  }
}

// What judges fast motion and what judges slow motion disagree.
void AddDrift(const FitSummary& summary, std::vector<Reason>* reasons) {
  if (!summary.assimilation.is_on() || summary.memory_trials.empty() || !summary.uncertainty) return;
  for (std::size_t i = 0; i < summary.parameters.size(); ++i) {
    const FittedParameter& parameter = summary.parameters[i];
    const ParameterUncertainty& uncertainty = summary.uncertainty->parameters[i];
    const double share = uncertainty.memory_error / std::abs(parameter.value);
    if (!(uncertainty.memory_error > kFarDrift * uncertainty.std) || !(share > kSmallDrift)) continue;
    const std::string brief = parameter.name + " drifts by " + NumberText(100.0 * share, 2) + " %";
    reasons->push_back(Careful(
        {static_cast<int>(i)}, brief,
        brief + " between " + NumberText(FirstMemoryOfDrift(summary.memory_trials), 2) + " and " +
            NumberText(summary.memory_trials.back().memory, 2) +
            " s of memory: the model errs otherwise in fast motion than in slow; the interval counts with that"));
  }
}

// What corrections of the rollouts tell.
void AddCorrections(const CorrectionCheck& check, const std::string& prefix, std::vector<Reason>* reasons) {
  const MissingForce& missing = check.missing_force;
  const double alike = check.innovations.autocorrelation();
  const bool is_white = alike < kWhite;
  const std::string correlation = " (correlation " + NumberText(alike, 2) + ")";
  reasons->push_back(Remark(prefix + (is_white ? "what predictions miss from frame to frame is noise" + correlation
                                               : "what predictions miss in consecutive frames is alike" + correlation +
                                                     ": the model errs, or the memory is too short")));
  if (!(missing.share() > kSmallForce)) return;
  reasons->push_back(Remark(prefix + "the model lacks a force of " + NumberText(missing.size, 2) + " N/m^2, " +
                            PercentText(missing.share(), 2) + " of the weight of the cloth: the most, " +
                            NumberText(missing.largest_in_frame, 2) + ", after " + NumberText(missing.time, 3) +
                            " s, and at node " + std::to_string(missing.node) + ", " +
                            NumberText(missing.largest_at_node, 2)));
}

}  // namespace

void AddModelErrorReasons(const FitSummary& summary, const FitChecks& checks, std::vector<Reason>* reasons) {
  AddMoved(summary, checks, reasons);
  AddWeights(summary, reasons);
  AddDrift(summary, reasons);
  for (std::size_t r = 0; r < checks.corrections.size(); ++r) {
    AddCorrections(checks.corrections[r], checks.corrections.size() > 1 ? checks.recordings[r].name + ": " : "",
                   reasons);
  }
  for (const RecordingFit& recording : checks.recordings) {
    AddMisses(recording, checks.recordings.size() > 1 ? recording.name + ": " : std::string(), reasons);
  }
}

}  // namespace clothid
