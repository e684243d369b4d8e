// A tensile test as force over strain: of all that a testing machine wrote down, the first loading of the cloth.
//
// Loading: the readings up to the largest elongation. A curve that falls back on its way, by more than kReturnedShare
// of the range of elongations, ends there: of several loadings the first counts.
//
// Slack: cloth that hangs loosely between the clamps bears nothing at first. It ends where the force passes the preload
// P. Between the mean of 1/kSlackIntervals of the elongations with the last force below P and the next mean the curve
// is a straight line; with u_P and u_Q the elongations at P and at Q, kToeShare of the largest force or 2 P, strain
// counts from
//   u_0 = u_P - (u_Q - u_P) P/(Q - P)
// where the line through both meets the force 0, so that what the preload itself has stretched is strain. The length at
// rest grows by the slack: e = (u - u_0)/(g + u_0), g the gauge length. A curve that starts above the preload has no
// slack, u_0 = 0.
//
// Thinning: the elongations behind u_P are cut into equal intervals, each of which keeps the mean of its readings. A
// mean of a curve that stiffens by exp(b e) over an interval d of strain is high by b^2 d^2/24 of it, 4e-5 for b = 6
// and d = 0.005.
//
// Sigma: EstimateSigma (datasets/motion/noise_estimate.h) of these means over strain: the scatter about the polynomial
// through their neighbours. It does not see errors that last: a gauge that is off, a cloth that relaxes.
// Width: where the table has one, the means of it in the same intervals; at rest it is what the parabola through the
// readings of the first half of the strains has at strain 0.
#ifndef CLOTHID_DATASETS_CURVES_TENSILE_CURVE_H_
#define CLOTHID_DATASETS_CURVES_TENSILE_CURVE_H_

#include <Eigen/Core>
#include <limits>

#include "datasets/curves/curve_table.h"

namespace clothid {

inline constexpr double kReturnedShare = 0.02;    // of the range of elongations: more than a jitter of their gauge
inline constexpr double kPreloadShare = 0.005;    // of the largest force: the preload, if none is given
inline constexpr double kToeShare = 0.03;         // likewise: up to there the curve is a line that leads to no force
inline constexpr int kSlackIntervals = 200;       // in which the end of the slack is looked for
inline constexpr double kLeastSigmaShare = 1e-3;  // of the largest force: gauges do not tell less
inline constexpr int kFewestCurveReadings = 8;    // a law of two constants and the scatter about it

struct TensileCurveOptions {
  double width = 0.0;         // m, of the specimen; 0: that of the table
  double length = 0.0;        // m, between the clamps, at elongation 0; 0: the gauge length of the table
  double gauge_length = 0.0;  // m, over which the elongation was measured; 0: `length`
  double preload = 0.0;       // N; 0: kPreloadShare of the largest force
  double least_strain = 0.0;  // readings of this range are kept
  double most_strain = std::numeric_limits<double>::infinity();
  double force_sigma = 0.0;  // N, of a reading that is kept; 0: it is estimated
  int max_readings = 60;     // intervals of the thinning
};

struct TensileCurve {
  double width = 0.0, length = 0.0;  // m, at rest, slack included
  double gauge_length = 0.0;         // m, likewise: over which the elongation was measured
  Eigen::VectorXd strains;           // [n] increasing, > 0
  Eigen::VectorXd forces;            // [n] N
  Eigen::VectorXd widths;            // [n] m, between two marks at half the length; empty: not measured
  double rest_width = 0.0;           // m, of these at rest, at most `width`
  double width_sigma = 0.0;          // m, the scatter of the widths
  double force_sigma = 0.0;          // N
  bool is_sigma_estimated = false;

  // What became of the readings.
  double preload = 0.0;          // N
  bool has_slack = false;        // the curve starts below the preload
  double slack = 0.0;            // m of elongation, u_0
  int num_slack = 0;             // before the force passed the preload; without slack those not beyond elongation 0
  int num_after = 0;             // behind the end of the loading
  bool returns_to_more = false;  // among those are larger elongations: of a later loading
  int num_outside = 0;           // outside of the range of strain
  int num_thinned = 0;           // that became the means
};

// Throws `Error`: kUsage for options that are not positive, and where neither options nor table tell width or length;
// kBadData, naming the file and what was expected, where the elongation never grows, the force is not above 0, or not
// above the preload, at the end of the loading, less than kFewestCurveReadings are left, or a strain is beyond 10.
TensileCurve MakeTensileCurve(const CurveTable& table, const TensileCurveOptions& options);

}  // namespace clothid

#endif  // CLOTHID_DATASETS_CURVES_TENSILE_CURVE_H_
