#include "datasets/curves/tensile_curve.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <string>

#include "datasets/motion/noise_estimate.h"
#include "sim/base/error.h"
#include "sim/base/text_file.h"

namespace clothid {
namespace {

constexpr double kMostStrain = 10.0;                               // beyond it a unit is wrong
constexpr double kAboveZero = std::numeric_limits<double>::min();  // at rest no law has a force

// Means of readings, by elongation.
struct CurveMeans {
  Eigen::VectorXd elongations, forces;

  Eigen::Index size() const { return forces.size(); }
};

// Of equal intervals from `first` to `last`; empty ones and readings outside are left out. `num_used` gets how many
// readings the means are of.
CurveMeans MeansOf(const Eigen::VectorXd& elongations, const Eigen::VectorXd& forces, double first, double last,
                   int num_intervals, int* num_used) {
  Eigen::MatrixXd sums = Eigen::MatrixXd::Zero(3, num_intervals);  // elongation, force, count
  for (Eigen::Index i = 0; i < elongations.size(); ++i) {
    if (!(elongations[i] >= first && elongations[i] <= last)) continue;
    const double place = (elongations[i] - first) / (last - first) * num_intervals;
    const int interval = std::min(static_cast<int>(place), num_intervals - 1);
    sums.col(interval) += Eigen::Vector3d(elongations[i], forces[i], 1.0);
  }
  CurveMeans means;
  means.elongations.resize(num_intervals);
  means.forces.resize(num_intervals);
  Eigen::Index count = 0;
  for (const auto sum : sums.colwise()) {
    if (sum[2] == 0.0) continue;
    means.elongations[count] = sum[0] / sum[2];
    means.forces[count++] = sum[1] / sum[2];
  }
  means.elongations.conservativeResize(count);
  means.forces.conservativeResize(count);
  *num_used = static_cast<int>(sums.row(2).sum());
  return means;
}

// The number of readings up to the largest elongation before the curve falls back. What falls back without having risen
// is no loading yet: the clamps are brought to where the test begins.
Eigen::Index EndOfLoading(const Eigen::VectorXd& elongations) {
  const double returned = kReturnedShare * (elongations.maxCoeff() - elongations.minCoeff());
  Eigen::Index largest = 0;
  double least = elongations[0], start = least;  // up to this reading, and up to the largest
  for (Eigen::Index i = 1; i < elongations.size(); ++i) {
    least = std::min(least, elongations[i]);
    if (elongations[i] >= elongations[largest]) {
      largest = i;
      start = least;
    } else if (elongations[largest] - elongations[i] > returned) {
      if (elongations[largest] - start > returned) break;
      largest = i;
      start = least = elongations[i];
    }
  }
  return largest + 1;
}

// Where the means pass `force` for the last time on their way up; nothing where the first is above it.
double ElongationAt(const CurveMeans& means, double force) {
  Eigen::Index below = means.size() - 1;
  while (below >= 0 && !(means.forces[below] < force)) --below;
  if (below < 0) return -std::numeric_limits<double>::infinity();
  const Eigen::Index above = std::min(below + 1, means.size() - 1);
  const double rise = means.forces[above] - means.forces[below];
  if (!(rise > 0.0)) return means.elongations[below];
  return means.elongations[below] +
         (force - means.forces[below]) / rise * (means.elongations[above] - means.elongations[below]);
}

// N, of a mean, about the smooth curve through its neighbours.
double ScatterOf(const CurveMeans& means, double least) {
  const Eigen::VectorXd sigma = EstimateSigma(means.elongations, means.forces.transpose().replicate(3, 1), least);
  return sigma.size() > 0 ? sigma[0] : least;
}

void CheckCurveOptions(const TensileCurveOptions& options) {
  const auto expect = [](double value, const char* name) {
    ExpectUsage(value >= 0.0 && std::isfinite(value), std::string(name) + ": expected a number > 0");
  };
  expect(options.width, "width");
  expect(options.length, "length");
  expect(options.gauge_length, "gauge_length");
  expect(options.preload, "preload");
  expect(options.force_sigma, "force_sigma");
  ExpectUsage(options.least_strain >= 0.0 && options.least_strain < options.most_strain,
              "strain: expected a range above 0");
  ExpectUsage(options.max_readings >= kFewestCurveReadings,
              "max_readings: expected at least " + std::to_string(kFewestCurveReadings));
}

double DimensionOf(double given, const std::optional<double>& told, const CurveTable& table, const char* name) {
  ExpectUsage(given > 0.0 || told, table.name + ": does not tell the " + name +
                                       " of the specimen; expected it as WIDTHxLENGTH in mm, or in a line above the "
                                       "columns");
  return given > 0.0 ? given : *told;
}

}  // namespace

TensileCurve MakeTensileCurve(const CurveTable& table, const TensileCurveOptions& options) {
  CheckCurveOptions(options);
  TensileCurve curve;
  curve.width = DimensionOf(options.width, table.width, table, "width");
  const double length = DimensionOf(options.length, table.gauge_length, table, "length");
  const double gauge_length = options.gauge_length > 0.0 ? options.gauge_length : length;

  const Eigen::Index num_loading = EndOfLoading(table.elongations);
  curve.num_after = static_cast<int>(table.elongations.size() - num_loading);
  const Eigen::VectorXd elongations = table.elongations.head(num_loading) * (table.is_strain ? gauge_length : 1.0);
  const Eigen::VectorXd forces = table.forces.head(num_loading) * (table.is_per_width ? curve.width : 1.0);
  curve.returns_to_more = table.elongations.maxCoeff() > table.elongations[num_loading - 1];
  const double least = elongations.minCoeff(), most = elongations[num_loading - 1];
  if (!(most > least)) FailOnData(table.name, "expected an elongation that grows; it never does");
  if (!(most / gauge_length <= kMostStrain)) {
    FailOnData(table.name, "its largest elongation is " + ShortestText(most) + " m, of a gauge length of " +
                               ShortestText(gauge_length) + " m; expected a strain of at most 10: is a unit off?");
  }

  int num_used = 0;
  const CurveMeans fine = MeansOf(elongations, forces, least, most, kSlackIntervals, &num_used);
  const double largest_force = fine.forces.maxCoeff();
  if (!(largest_force > 0.0) || !(fine.forces[fine.size() - 1] > 0.0)) {
    FailOnData(table.name, "the force at the largest elongation is " + ShortestText(fine.forces[fine.size() - 1]) +
                               " N; expected one above 0: tension is positive");
  }
  curve.preload = options.preload > 0.0 ? options.preload : kPreloadShare * largest_force;
  if (!(curve.preload < largest_force)) {
    FailOnData(table.name, "its largest force is " + ShortestText(largest_force) +
                               " N; expected more than the preload, " + ShortestText(curve.preload) + " N");
  }
  const double at_preload = ElongationAt(fine, curve.preload);
  curve.has_slack = std::isfinite(at_preload);
  if (curve.has_slack) {
    const double more = std::min(std::max(2.0 * curve.preload, kToeShare * largest_force), largest_force);
    curve.slack = at_preload - (ElongationAt(fine, more) - at_preload) * curve.preload / (more - curve.preload);
  }
  const double rest_gauge = gauge_length + curve.slack;
  if (!(rest_gauge > 0.0)) FailOnData(table.name, "its slack is negative and longer than the specimen");
  curve.length = length * rest_gauge / gauge_length;

  const Eigen::VectorXd strains = (elongations.array() - curve.slack) / rest_gauge;
  const double first_strain = curve.has_slack ? (at_preload - curve.slack) / rest_gauge : kAboveZero;
  const double first = std::max(first_strain, options.least_strain);
  const double last = std::min(strains[num_loading - 1], options.most_strain);
  curve.num_slack = static_cast<int>((strains.array() < first_strain).count());
  const CurveMeans means =
      first < last ? MeansOf(strains, forces, first, last, options.max_readings, &curve.num_thinned) : CurveMeans();
  curve.num_outside = static_cast<int>(num_loading) - curve.num_slack - curve.num_thinned;
  if (means.size() < kFewestCurveReadings) {
    FailOnData(table.name, "expected at least " + std::to_string(kFewestCurveReadings) +
                               " readings of the loading at different elongations, of strains from " +
                               ShortestText(first) + " to " + ShortestText(last) + ", found " +
                               std::to_string(means.size()));
  }
  curve.strains = means.elongations;
  curve.forces = means.forces;
  if (!(curve.forces[means.size() - 1] > 0.0)) {
    FailOnData(table.name, "the last force that is kept is " + ShortestText(curve.forces[means.size() - 1]) +
                               " N; expected one above 0: tension is positive");
  }
  curve.is_sigma_estimated = options.force_sigma == 0.0;
  curve.force_sigma =
      options.force_sigma > 0.0 ? options.force_sigma : ScatterOf(means, kLeastSigmaShare * largest_force);
  return curve;
}

}  // namespace clothid
