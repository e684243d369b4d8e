// The truth of unknowns that are no parameter of `--set`: fields and a wind that changes. It stands in the scene, and a
// fit is given the scene without it.
#ifndef CLOTHID_TOOLS_BENCHMARK_FITS_COVERAGE_TRUTH_H_
#define CLOTHID_TOOLS_BENCHMARK_FITS_COVERAGE_TRUTH_H_

#include <Eigen/Core>
#include <string>
#include <vector>

#include "costs/field/field_request.h"
#include "datasets/synthetic/true_recording.h"
#include "identify/wind/wind_request.h"
#include "sim/scene/scene.h"

namespace clothid {

struct HiddenUnknowns {
  std::vector<FieldRequest> fields;
  WindRequest wind;

  bool any() const { return !fields.empty() || wind.is_given(); }
};

// Throws `Error` (kUsage), naming the flag, where `scene` has no such truth.
void ExpectTruth(const HiddenUnknowns& unknowns, const Scene& scene);

// The text of a scene, whose fields and profile are in it, without them.
std::string WithoutTruth(const HiddenUnknowns& unknowns, const std::string& scene_text);

// Of the knots of a profile over frames at `times` (s), as parameters are named, then of the control nodes of fields by
// row and column, from 1: "wind.y.3", "k_stretch.2.1". A parameter of `truth` that is the level of a field scales it.
std::vector<TrueParameter> TrueUnknowns(const HiddenUnknowns& unknowns, const std::vector<TrueParameter>& truth,
                                        const Scene& scene, const Eigen::VectorXd& times);

// "wind.y.*" of "wind.y.3" and "k_stretch.*" of "k_stretch.2.1"; any other name as it is.
std::string UnknownsOf(const std::string& name);

}  // namespace clothid

#endif  // CLOTHID_TOOLS_BENCHMARK_FITS_COVERAGE_TRUTH_H_
