// One scalar that a fit may change, as a Ceres parameter block of size 1.
//
// Ceres works on an internal coordinate q: q = log(value) for stiffnesses, masses, drags and damping, which are known
// to a factor at best and span decades; q = value for friction coefficients, which live in [0, 2] and may be zero;
// q = value/unit for what may be negative: k_poisson, the wind, and the parameters of a recording itself
// (costs/prediction/alignment.h).
#ifndef CLOTHID_COSTS_PREDICTION_PARAMETER_BLOCK_H_
#define CLOTHID_COSTS_PREDICTION_PARAMETER_BLOCK_H_

#include <map>
#include <string>
#include <vector>

#include "costs/prediction/alignment.h"
#include "datasets/motion/recorded_motion.h"
#include "sim/fabric/fabric.h"
#include "sim/scene/parameters.h"
#include "sim/scene/scene.h"

namespace clothid {

enum class ParameterScale { kLinear, kLog };

// Drag, damping and the k_bend of bending by edges, whose bounds nobody has measured, may move by this factor up and
// down from their start: far enough for any wrong one, near enough that a wandering optimiser simulates what it can.
inline constexpr double kBoundFactor = 1e4;

inline constexpr int kEveryRecording = -1;
inline constexpr int kNoBlock = -1;

struct ParameterBlock {
  // As `FindParameter` reads it, the same in every recording of a joint fit; or, of one recording alone, with a suffix:
  // "drag@2" is the drag of the second recording.
  std::string name;
  // What the name says. An obstacle or a piece has the number of the scene that the block was made of: see `IdIn`.
  ParameterId id;
  int recording = kEveryRecording;  // or the index of the only one
  ParameterScale scale = ParameterScale::kLinear;
  double unit = 1.0;         // linear scale: the value at q = 1
  bool is_signed = false;    // may be negative: k_poisson, wind, and parameters of the recording itself
  double start = 0.0;        // starting value, in the parameter's own unit
  double lower_bound = 0.0;  // in the parameter's own unit; lower_bound < upper_bound
  double upper_bound = 0.0;
  bool frozen = false;  // held at its starting value, never differentiated
  // What is believed beforehand, in the parameter's own unit; log scale: of the logarithm. It is one more residual of
  // whoever minimises, (q - PriorCoordinate())/PriorStd(): `RolloutCost` knows nothing of it.
  ParameterPrior prior;
  // A difference that is believed to be small: to block `linked_to` of the same fit, of the same scale, with a standard
  // deviation in the parameter's own unit. It is one more residual, likewise, that counts as residuals of the recording
  // do (identify/uncertainty/priors.h).
  int linked_to = kNoBlock;
  double link_spread = 0.0;

  // The same parameter in `scene`, whose obstacles and pieces may stand in another order; of a recording it is `id`.
  // Throws `Error` (kUsage) where the scene has no such parameter.
  ParameterId IdIn(const Scene& scene) const;
  double ToCoordinate(double value) const;
  double ToValue(double coordinate) const;
  // d value / d coordinate.
  double ValueDerivative(double coordinate) const;
  // The prior in the internal coordinate; NaN where there is none.
  double PriorCoordinate() const;
  double PriorStd() const;
  bool is_linked() const { return linked_to != kNoBlock; }
  double LinkStd() const { return link_spread / unit; }  // in the internal coordinate, which is linear
  // From bound to bound, in the internal coordinate.
  double CoordinateRange() const;
  // Within 1e-3 of the range from one of the bounds, or of the range without given bounds if that is smaller: from 0 to
  // kMaxFriction, over kBoundFactor up and down, +- unit. A bounded optimiser may reach a bound asymptotically only.
  bool IsAtBound(double coordinate) const;
  // The smallest change of the coordinate that a fit goes for: 1e-6 of the value, of friction below 0.01 1e-8, of the
  // recording's own parameters below a tenth of their unit 1e-7 of that.
  double Resolution(double coordinate) const;
};

// "drag" of "drag@2"; a name without suffix as it is.
std::string BaseName(const std::string& name);

// What was measured of any cloth of constant `kind` of `scene`; null: nothing, as of friction and of bending by edges.
const MeasuredConstant* MeasuredOfAnyCloth(ParameterKind kind, const Scene& scene);

// Log for everything but friction, k_poisson and the wind.
ParameterScale DefaultScale(ParameterKind kind);

// The parameter of a name without suffix in `motion`: one of its scene, or of the recording itself. Throws `Error`
// (kUsage) that lists all that there are. Whether the recording has what such a one corrects: `ExpectMeasured`.
ParameterId ParseParameter(const std::string& name, const RecordedMotion& motion);

// What the user gives over the scene's `parameters`; by parameter name. Of "shift.x@2" the first of "shift.x@2",
// "shift@2", "shift.x" and "shift" that is given counts.
struct ParameterOverrides {
  std::map<std::string, double> start, lower_bounds, upper_bounds;
  std::map<std::string, ParameterPrior> priors;
};

// "k_bend=1e-5:2, mu=0.3:0.1" -> {{"k_bend", {1e-5, 2}}, {"mu", {0.3, 0.1}}}. Empty text: empty map. Throws `Error`
// (kUsage), naming `flag`, unless every item is NAME=CENTER:SPREAD with finite numbers and every name is there once.
std::map<std::string, ParameterPrior> ParseParameterPriors(const std::string& text, const std::string& flag);

// "1e-05, factor 2" of a logarithm, else "0.3 +- 0.1".
std::string PriorText(const ParameterPrior& prior, ParameterScale scale);

// The block of parameter `name` in `scene`. Start: the override, else `parameters.nominal`, else the material or the
// obstacle. Bounds: the override, else the scene's, else [0, kMaxFriction], +- its unit sqrt(k_warp k_weft)
// (k_poisson), of the size of the cloth a factor of 1.25, of the wind +- its unit: twice the nominal value, at least 10
// m/s, of its frequency 10 rad/s, of its phase pi, of its wave vector 10 rad/m, of its shear 10 1/m, of the pressure
// likewise, at least 50 Pa, of the stiffening of yarns 0.05 to 50, of the placement of an obstacle's path 0.1 s, 0.05
// m, 0.2 rad; and kBoundFactor, or 100 times beyond what was measured of any cloth, 10 times of the scene's fabric
// (sim/fabric/fabric.h) and 100 times beyond the start. Throws `Error` (kUsage) for an unknown name, wrong bounds and
// priors, a start outside the bounds, and one of zero in log space: a scene without bending (or drag, or damping) has
// no such term to start at; and for wind in a scene without drag. Prior: the override, else the scene's; of the size of
// the cloth else a median of 1 and a factor of 1.03, for who measures a cloth with a ruler, or lays a grid of 8 x 8
// over what a camera sees, is some per cent off.
ParameterBlock MakeParameterBlock(const std::string& name, const Scene& scene, const ParameterOverrides& overrides);

// The same for a recording, and for its own parameters (costs/prediction/alignment.h), too. Of those: start 0, bounds
// +- `DefaultAlignmentRange`, prior that of their row, the override before any of them. Throws `Error` (kUsage)
// also for bounds beyond `LargestAlignmentBound`.
ParameterBlock MakeParameterBlock(const std::string& name, const RecordedMotion& motion,
                                  const ParameterOverrides& overrides);

// The names of `ParameterOverrides` that speak of parameter `name`, the first before the others.
std::vector<std::string> OverrideNames(const std::string& name);

}  // namespace clothid

#endif  // CLOTHID_COSTS_PREDICTION_PARAMETER_BLOCK_H_
