// Before the laboratory: how sure a fit would be of a cloth's parameters if candidate experiments were recorded.
//
//   PlanOptions options;
//   options.scene_paths = {"swing.json", "drape.json"};
//   options.fit.parameters = {"mu", "k_stretch", "k_bend"};
//   options.sigma = 0.002;
//   options.frame_rate = 30.0;
//   const Plan plan = PlanExperiment(options);
//   if (plan.candidates[0].parameters[2].is_told) Record();
//
// Every candidate is a scene. Its cloth is simulated, seen without noise, and the Jacobian J of the residuals over
// sigma is taken there, at the truth, by one forward sweep. What a fit of such a recording would estimate beside the
// parameters (its start, where its handles are) is eliminated as the fit does (identify/uncertainty/marginal.h), priors
// are added, and what is left is judged as after a fit (identify/uncertainty/uncertainty.h), with the error of the time
// step (identify/checks/step_error.h). Two recordings tell what both do: their rows add up, priors count once.
//
// What is known beforehand decides what a motion tells. So the cloth is the nominal one and `num_draws` others, the
// same draws for every candidate. Parameters of the cloth and of obstacles are drawn from their priors; without one,
// stiffness, density, drag, damping and friction are the nominal ones times 1.5^z with a standard normal z, within 1 %
// of the range off their bounds. All else stays nominal: wind, k_poisson and what belongs to a recording itself. Of an
// unknown start these others are swept along the directions that the nominal cloth tells of
// (identify/experiment/informed_start.h).
//
// Over the cloths that could be simulated,
//   std        = root mean square of the standard deviations, of the logarithm of what is a scale and else of the value
//                (ParameterScale), over those in which the parameter is told
//   told       = in more than half of the cloths; but not by the error of the step alone, nor where the cost is rough:
//                1 % away that of the nominal cloth, frames counting by the error of the step, rises by less than a
//                tenth of what its slope says (identify/estimate/interval_check.h)
//   told_share = the share of cloths in which a fit would call the parameter identifiable
//   step_error = how far the step of the nominal cloth moves the estimate of a fit whose frames count by what the step
//                makes them err (identify/checks/step_error.h, datasets/observation/model_error.h), and how much less
//                sure they make it
//   interval   = the nominal value -+ 1.96 sqrt(std^2 + step_error^2), or times exp(-+ ..), cut at the bounds
//
// What would help most is told by the same sweep with other rows or other weights:
//   kTwiceFrames   twice the frame rate
//   kHalfNoise     half the standard deviation of the points, forces as they are
//   kGauge         the forces on all handles together at every frame, with `force_sigma`
//   kMoreMarkers   twice the markers; of a recording that sees every node, points between them that tell as much
//   kLonger        half as long again, handles as they move by then
//   kKnownStart    the start is stated: where the cloth and its handles are, and how fast, is known exactly
//   kHalfStep      half the time step, whose error is half as large
//   kBothScenes    another candidate as well
// each with the factor by which the width of every interval changes: of its part from noise, but with kHalfStep of all
// of it. There an interval counts with what was believed before: its prior, or the range between bounds (`BelievedStd`)
// as one more measurement. So it is finite, and what nothing tells has the factor 1. The worst told parameter is the
// one whose interval from noise is the widest beside that belief. kLonger is told of the nominal cloth alone.
#ifndef CLOTHID_IDENTIFY_EXPERIMENT_EXPERIMENT_PLAN_H_
#define CLOTHID_IDENTIFY_EXPERIMENT_EXPERIMENT_PLAN_H_

#include <cstddef>
#include <string>

#include "identify/experiment/plan_options.h"
#include "identify/experiment/planned_experiment.h"

namespace clothid {

// Throws `Error`: kUsage for what `Validate` rejects, for parameters that no scene has and for what is said of those
// that are not fitted; kIo and kBadData for scenes; kIo for the output. A cloth that cannot be simulated never throws.
// The same bytes on any number of threads. Where `FitOptions::cancel` turned true, cloths fail, and nothing is written.
Plan PlanExperiment(const PlanOptions& options);

// What tells parameter i of the plan with the narrowest interval, over the share of cloths of which it tells it: a
// candidate, a pair; -1: none tells it.
int BestCandidate(const Plan& plan, std::size_t parameter);
int BestPair(const Plan& plan, std::size_t parameter);
// What makes the prediction the narrowest, likewise.
int BestCandidateToPredict(const Plan& plan);
int BestPairToPredict(const Plan& plan);

// What is expected of every candidate and of the best pairs, and what would help, for people.
std::string PlanTable(const Plan& plan);
// plan.json, for programs: null for NaN; what follows parameters is by their names.
//   schema      "clothid.plan/1"
//   recorded    sigma_m, frame_rate_hz, markers, forces, force_sigma_n, handle_sigma_m, initial, draws, seed
//   parameters  names
//   candidates  of each: name, scene (its path), failure (null; else there is nothing more), start (scene, rest or
//               moving), duration_s, time_step_s, frames, points, nodes, cloths, failed_cloths (why), worst_told, and
//     parameters    of each: in_scene, scale (log or linear), value, told, told_share, std, known_start_std,
//                   step_error, lower95, upper95, share_of_belief, not_told, made_up_by, as in ExpectedParameter
//     improvements  the best first: what (`ImprovementName`), with (a candidate, of "both scenes" alone), of (noise, or
//                   the whole interval), worst, factors of each parameter, tells
//     information   InformationMap: times_s [T], and of each parameter nodes [N], frames [T], forces
//   pairs       candidates (two names), cloths, parameters as above
//   prediction  of PlanOptions::predicted_path: name, scene, believed_width_m; and of every candidate and pair
//               prediction_width_m (identify/experiment/prediction_width.h)
//   provenance  version, git, flags
std::string PlanJson(const PlanOptions& options, const Plan& plan);
// plan.html: what plan.json says, as pictures: the motion that tells each parameter best, expected intervals as bars on
// a common axis, how wide a prediction would be, and every motion as a replay in the colours of the information per
// node, with that per frame below it. The page is like that of a fit (identify/report/report_page.h): one file below
// kMaxReportBytes, for which frames are left out, that asks no server for anything, in which names are shown and never
// run. The same bytes for the same plan.
std::string PlanHtml(const PlanOptions& options, const Plan& plan);

inline constexpr char kPlanFile[] = "plan.json", kPlanPageFile[] = "plan.html";

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_EXPERIMENT_EXPERIMENT_PLAN_H_
