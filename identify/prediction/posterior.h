// What a finished fit left behind, as a distribution: where its parameters may be, and what its model lacks.
//
// With the coordinates q of costs/prediction/parameter_block.h (the logarithm of a stiffness, friction as it is),
//   Cov(q) = N R N + diag(e^2),
// N the standard deviations from the noise, R the correlation, and e what intervals count beside the noise (step, mesh,
// drift over memories): of which nobody knows how it goes together between parameters. Both are those of result.json:
//   N_i = std_i dq_i/dvalue,   N_i^2 + e_i^2 = (half the width of the interval / quantile)^2,
// the wider half where a bound has cut the other.
//
// What a fit was free to move and tells no interval of is not known either: it is drawn from where it may be
// (identify/uncertainty/untold_range.h), apart from the others.
#ifndef CLOTHID_IDENTIFY_PREDICTION_POSTERIOR_H_
#define CLOTHID_IDENTIFY_PREDICTION_POSTERIOR_H_

#include <Eigen/Core>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "costs/prediction/parameter_block.h"
#include "identify/checks/lasting_force.h"
#include "identify/estimate/fit_summary.h"
#include "identify/uncertainty/untold_range.h"
#include "sim/scene/scene.h"

namespace clothid {

struct PosteriorParameter {
  std::string name;
  ParameterScale scale = ParameterScale::kLinear;
  double value = 0.0;  // the estimate, in its own unit
  double lower_bound = 0.0, upper_bound = 0.0;
  std::optional<UntoldRange> untold = {};  // none: it has an interval

  double ToCoordinate(double at) const;
  double ToValue(double coordinate) const;  // cut at the bounds
};

// How far recordings start from where they were taken to, as their fit has found: root mean squares, of a coordinate,
// of what it moved and of what it is not sure of.
struct LearntStart {
  double position = 0.0, velocity = 0.0;  // m and m/s, of the free nodes
  double handles = 0.0;                   // m, what the path of the handles is off by
  double handle_interval = 0.0;           // s, in which that changes; 0: it does not
};

struct FitPosterior {
  std::string path, key = "parameters";        // the file and its key that holds them, for messages
  std::string warning;                         // the verdict of a fit that must not be used; empty: it may be
  std::vector<PosteriorParameter> parameters;  // [p] those with an interval, and those that may be anywhere in a range
  Eigen::MatrixXd covariance;                  // [p x p] of q; of the latter of the number that `UntoldRange::At` takes
  std::map<std::string, double> held;          // estimates of others: frozen, stalled, hidden together
  std::vector<std::string> left_out;           // of a recording alone, which say nothing of another scene
  // What the model lacks is their sum (identify/prediction/force_match.h); empty: it lacks nothing. With the factor of
  // a calibration.
  std::vector<LastingForce> forces;
  double force_factor = 1.0;            // that they have been multiplied by (identify/prediction/held_bands.h)
  std::optional<LearntStart> start;     // none: starts and paths of handles counted as known
  std::optional<std::string> membrane;  // the laws of the cloth, in the words of a scene; none: older results
  std::optional<std::string> bending;   // likewise; none where it has no bending, too
};

// Throws `Error` (kIo, kBadData), naming file and key and what was expected, for a result that tells no intervals: of a
// fit that failed, was interrupted, or of fields, which result.json does not hold.
FitPosterior ReadPosterior(const std::string& path);
// The same of the text of one, or of the card of a cloth (datasets/fabric/fabric_card.h); `path` names it in errors.
//
// Of a card parameters are the constants that it tells, each for itself, as wide as interval and scatter together; what
// it assumes is left to the scene. Starts count as known.
FitPosterior ParsePosterior(const std::string& text, const std::string& path);

// That of a fit that has just ended, with an uncertainty, and of the forces that its model lacks. Unlike one that was
// read it has the parameters that belong to one recording, and leaves nothing out.
FitPosterior PosteriorOf(const FitSummary& summary, const std::vector<LastingForce>& forces);

// What `scene` has no use for is moved to `left_out`: friction where nothing is to be touched. Throws `Error`
// (kBadData), naming file and key, where the scene has no such parameter or its cloth has other laws than the one that
// was fitted. `scene_name`: for messages.
void FitToScene(const Scene& scene, const std::string& scene_name, FitPosterior* posterior);

// Values [p x D] of D clothes, in the parameters' own units: draw d depends on seed and d alone.
Eigen::MatrixXd DrawParameters(const FitPosterior& posterior, int num_draws, std::uint64_t seed);

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_PREDICTION_POSTERIOR_H_
