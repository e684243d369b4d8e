// What several recordings of one experiment tell together: each was fitted for itself, and of every parameter that they
// share the estimates are pooled (identify/repetition/random_effects.h).
//
// y_r is the estimate in the parameter's coordinate: the logarithm of a stiffness, mass, drag or damping, the value of
// all others (costs/prediction/parameter_block.h). s_r is the standard deviation of the fit from noise and correlated
// residuals, with frames weighed by the error of the model. The errors of time step and mesh are common to all
// repetitions, which were simulated alike: they are no part of s_r, and no reason for estimates to differ, but widen
// the intervals of the mean and of the next specimen.
#ifndef CLOTHID_IDENTIFY_REPETITION_REPETITIONS_H_
#define CLOTHID_IDENTIFY_REPETITION_REPETITIONS_H_

#include <limits>
#include <string>
#include <vector>

#include "costs/prediction/parameter_block.h"
#include "identify/repetition/random_effects.h"

namespace clothid {

// In the parameter's own unit. NaN: not known.
struct SingleEstimate {
  std::string name;
  ParameterScale scale = ParameterScale::kLinear;
  bool is_frozen = false;
  double value = std::numeric_limits<double>::quiet_NaN();
  double std = std::numeric_limits<double>::quiet_NaN();  // without the errors of time step and mesh
  double lower95 = std::numeric_limits<double>::quiet_NaN(), upper95 = std::numeric_limits<double>::quiet_NaN();
  double step_error = std::numeric_limits<double>::quiet_NaN(), mesh_error = std::numeric_limits<double>::quiet_NaN();
  // Of the fit; infinite: not known.
  double lower_bound = -std::numeric_limits<double>::infinity(), upper_bound = std::numeric_limits<double>::infinity();

  // Has an estimate to pool.
  bool is_told() const;
};

// The fit of one recording for itself.
struct SingleFit {
  std::string name;          // of the recording, or of the folder of the fit
  std::string sha256;        // of the recording; empty: not known
  std::string why_not_used;  // one line; empty: it is used
  std::vector<SingleEstimate> estimates;

  const SingleEstimate* Find(const std::string& parameter) const;  // null: it has none
};

// One parameter over all recordings.
struct PooledParameter {
  std::string name;
  ParameterScale scale = ParameterScale::kLinear;
  std::vector<int> fits;  // those that are pooled, indices into Repetitions::fits, rising
  RandomEffects effects;  // of these, in the coordinate; meaningless where there are fewer than two
  // In the parameter's own unit, cut at the widest bounds of the fits; NaN where fewer recordings were pooled than they
  // take.
  double mean = std::numeric_limits<double>::quiet_NaN();
  double lower95 = std::numeric_limits<double>::quiet_NaN(), upper95 = std::numeric_limits<double>::quiet_NaN();
  double next_lower95 = std::numeric_limits<double>::quiet_NaN(),
         next_upper95 = std::numeric_limits<double>::quiet_NaN();

  bool is_pooled() const { return fits.size() > 1; }
  // The recordings differ by more than their intervals say, and by more than a thousandth of the mean: what is less is
  // that of the optimiser (`FitOptions::parameter_tolerance`), as between recordings without noise.
  bool varies() const;
};

struct Repetitions {
  std::vector<SingleFit> fits;              // in the order of --target
  std::vector<PooledParameter> parameters;  // that all recordings share, frozen ones left out
  bool is_of_folders = false;               // of finished fits: there is no joint one

  bool any_varies() const;
};

// Throws `Error` (kUsage), naming both, where two fits are of one recording, by their sha256: it must not count twice.
void ExpectDifferentRecordings(const std::vector<SingleFit>& fits);

// Pools parameters `names`.
Repetitions Pool(const std::vector<SingleFit>& fits, const std::vector<std::string>& names);

// A difference in the coordinate for people: "12 %" of a logarithm, "0.034" else.
std::string DifferenceText(ParameterScale scale, double difference);

// "mean of 5 recordings, 95 % interval 64.1 .. 76.9; they scatter by 12 %" of a parameter that is pooled.
std::string MeanText(const PooledParameter& parameter);

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_REPETITION_REPETITIONS_H_
