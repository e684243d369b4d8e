// How often bands hold what a fit has not seen: predictions of held-out measurements that know their error, judged.
//
// A draw is a rollout of a held-out recording with parameters of the posterior of the fit
// (identify/prediction/posterior.h), with a draw of the force that its model lacks, and with so much of what half the
// step and a mesh of twice the density change as identify/prediction/prediction.h says; to what it predicts of a
// measurement noise is added, of the standard deviation that the recording knows. So the bands are of what is measured;
// of points that are compared with the surface, as those of clouds, of their distance to it, signed, along its normal.
// Lead times count from the start of the rollout: what comes after it nothing corrects.
#ifndef CLOTHID_IDENTIFY_PREDICTION_HELD_BANDS_H_
#define CLOTHID_IDENTIFY_PREDICTION_HELD_BANDS_H_

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "identify/prediction/coverage.h"

namespace clothid {

inline constexpr std::array<double, 4> kHeldLeads = {0.1, 0.3, 1.0, std::numeric_limits<double>::infinity()};  // s

// The first of `kHeldLeads` that a time after the start, s, is not beyond.
std::size_t LeadOf(double time);

// How they are made.
struct HeldBandOptions {
  int num_draws = 20;  // at least kLeastDraws
  std::uint64_t seed = 1;
  int num_threads = 1;
  bool with_step = true, with_mesh = true;  // what those of the scenes are off by
  // Finds the factor that makes them hold 90 %, by three times as many rollouts more where they hold what right ones do
  // not.
  bool calibrates = false;
  const std::atomic<bool>* cancel = nullptr;
};

// Of the measurements from one lead time to the next. Lengths are of a coordinate, m; N where only forces were held
// out.
struct HeldBandCell {
  double until = std::numeric_limits<double>::infinity();  // s after the start; infinite: to the end
  double num = 0.0;                                        // of measurements that were looked at
  double inside = 0.0;                                     // the share that lies in the band of 90 %
  double rmse = 0.0;                                       // of the median
  double score = 0.0;                                      // the mean of `RankedScore`
  double half_width = 0.0;                                 // the mean over bands
  // What `inside` and `rmse` would be of a right prediction (identify/prediction/coverage.h).
  RightRange inside_if_right, rmse_if_right;

  bool IsTooNarrow() const { return inside < inside_if_right.low || rmse > rmse_if_right.high; }
  bool IsTooWide() const { return !IsTooNarrow() && rmse < rmse_if_right.low; }
};

// Of one of several recordings.
struct HeldRecordingBands {
  std::string name;
  HeldBandCell all;
  // s after the start: the last time at which, over the measurements so far, the median has missed by less than a cloth
  // that stays where it starts, as root mean squares; 0: it never has, infinite: to the end. NaN of forces.
  double worth_until = std::numeric_limits<double>::quiet_NaN();
};

// One factor on the force that the model lacks, by which bands hold what they say.
struct BandCalibration {
  // 1 where the bands hold what right ones may hold; else from kLeastBandFactor to its inverse, where they are as near
  // to 90 % as that goes.
  double factor = 1.0;
  double inside = 0.0;  // the share in bands of 90 % with it, by rollouts of their own
};

inline constexpr double kLeastBandFactor = 0.05;

struct HeldBands {
  std::vector<HeldBandCell> leads;  // up to .1, .3, 1 s, and from there on: those in which something was held out
  HeldBandCell all;
  std::vector<HeldRecordingBands> recordings;  // in which something was held out
  int num_draws = 0, num_failed = 0;           // of every recording; those that failed are in no number
  bool has_force = false;
  std::optional<BandCalibration> calibration;  // where that was asked for, and there is a force
  std::string why_not;  // why there are none, in words that go on after "bands: "; empty: there are
};

// "71 to 100 %".
std::string RangeText(const RightRange& range);

// "bands of 90 % held 84 % of what was held out (a right prediction: 71 to 100 %); 70 % to 0.1 s (right: 60 to 100 %)
// and ..; +- 3 mm about a median that misses by 2 mm (right: 1 to 4 mm), ..": one line, which begins with "bands of 90
// % are too narrow: they held", or "too wide", where they are.
std::string HeldBandsText(const HeldBands& bands, bool has_only_forces);

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_PREDICTION_HELD_BANDS_H_
