#include "datasets/curves/tensile_curve.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "datasets/motion/noise_estimate.h"
#include "sim/base/error.h"
#include "sim/base/text_file.h"
#include "sim/matrix/dense.h"

namespace clothid {
namespace {

constexpr double kMostOfWidth = 1.05;                              // of two marks: the specimen is not cut exactly
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

// The part of a table that is kept, step by step.
class CurveCutter {
 public:
  CurveCutter(const CurveTable& table, const TensileCurveOptions& options) : table_(table), options_(options) {}

  TensileCurve Cut() {
    curve_.width = DimensionOf(options_.width, table_.width, table_, "width");
    length_ = DimensionOf(options_.length, table_.gauge_length, table_, "length");
    gauge_length_ = options_.gauge_length > 0.0 ? options_.gauge_length : length_;
    TakeLoading();
    int num_used = 0;
    const CurveMeans fine =
        MeansOf(elongations_, forces_, elongations_.minCoeff(), LastOf(elongations_), kSlackIntervals, &num_used);
    FindSlack(fine);
    ThinOut(fine.forces.maxCoeff());
    if (widths_.size() > 0) FindRestWidth();
    return std::move(curve_);
  }

 private:
  static double LastOf(const Eigen::VectorXd& values) { return values[values.size() - 1]; }

  void ExpectTension(const char* which, double force) const {
    if (force > 0.0) return;
    FailOnData(table_.name, std::string("the ") + which + " is " + ShortestText(force) +
                                " N; expected one above 0: tension is positive");
  }

  void TakeLoading() {
    const Eigen::Index count = EndOfLoading(table_.elongations);
    curve_.num_after = static_cast<int>(table_.elongations.size() - count);
    curve_.returns_to_more = table_.elongations.maxCoeff() > table_.elongations[count - 1];
    elongations_ = table_.elongations.head(count) * (table_.is_strain ? gauge_length_ : 1.0);
    forces_ = table_.forces.head(count) * (table_.is_per_width ? curve_.width : 1.0);
    if (table_.widths.size() > 0) {
      widths_ = table_.widths.head(count);
      if (table_.is_width_strain) widths_ = curve_.width * (1.0 + widths_.array());
    }
    const double most = LastOf(elongations_);
    if (!(most > elongations_.minCoeff())) FailOnData(table_.name, "expected an elongation that grows; it never does");
    if (!(most / gauge_length_ <= kMostStrain)) {
      FailOnData(table_.name, "its largest elongation is " + ShortestText(most) + " m, of a gauge length of " +
                                  ShortestText(gauge_length_) + " m; expected a strain of at most 10: is a unit off?");
    }
  }

  // `fine`: the means of the loading in which the end of the slack is looked for.
  void FindSlack(const CurveMeans& fine) {
    const double largest = fine.forces.maxCoeff();
    ExpectTension("force at the largest elongation", LastOf(fine.forces));
    curve_.preload = options_.preload > 0.0 ? options_.preload : kPreloadShare * largest;
    if (!(curve_.preload < largest)) {
      FailOnData(table_.name, "its largest force is " + ShortestText(largest) + " N; expected more than the preload, " +
                                  ShortestText(curve_.preload) + " N");
    }
    const double at_preload = ElongationAt(fine, curve_.preload);
    curve_.has_slack = std::isfinite(at_preload);
    if (curve_.has_slack) {
      const double more = std::min(std::max(2.0 * curve_.preload, kToeShare * largest), largest);
      curve_.slack = at_preload - (ElongationAt(fine, more) - at_preload) * curve_.preload / (more - curve_.preload);
    }
    rest_gauge_ = gauge_length_ + curve_.slack;
    if (!(rest_gauge_ > 0.0)) FailOnData(table_.name, "its slack is negative and longer than the specimen");
    curve_.gauge_length = rest_gauge_;
    curve_.length = length_ * rest_gauge_ / gauge_length_;
    first_strain_ = curve_.has_slack ? (at_preload - curve_.slack) / rest_gauge_ : kAboveZero;
  }

  void ThinOut(double largest_force) {
    const Eigen::VectorXd strains = (elongations_.array() - curve_.slack) / rest_gauge_;
    const double first = std::max(first_strain_, options_.least_strain);
    const double last = std::min(LastOf(strains), options_.most_strain);
    CurveMeans means;
    if (first < last) means = MeansOf(strains, forces_, first, last, options_.max_readings, &curve_.num_thinned);
    curve_.num_slack = static_cast<int>((strains.array() < first_strain_).count());
    curve_.num_outside = static_cast<int>(strains.size()) - curve_.num_slack - curve_.num_thinned;
    if (means.size() < kFewestCurveReadings) {
      FailOnData(table_.name, "expected at least " + std::to_string(kFewestCurveReadings) +
                                  " readings of the loading at different elongations, of strains from " +
                                  ShortestText(first) + " to " + ShortestText(last) + ", found " +
                                  std::to_string(means.size()));
    }
    ExpectTension("last force that is kept", LastOf(means.forces));
    curve_.strains = means.elongations;
    curve_.forces = means.forces;
    if (widths_.size() > 0) {
      const CurveMeans across = MeansOf(strains, widths_, first, last, options_.max_readings, &curve_.num_thinned);
      curve_.widths = across.forces;
      curve_.width_sigma = ScatterOf(across, kLeastSigmaShare * curve_.width);
    }
    curve_.is_sigma_estimated = options_.force_sigma == 0.0;
    curve_.force_sigma =
        curve_.is_sigma_estimated ? ScatterOf(means, kLeastSigmaShare * largest_force) : options_.force_sigma;
  }

  // By least squares.
  void FindRestWidth() {
    const Eigen::VectorXd strains = (elongations_.array() - curve_.slack) / rest_gauge_;
    const double most = 0.5 * LastOf(curve_.strains);
    std::vector<Eigen::Index> rows;
    for (Eigen::Index i = 0; i < strains.size(); ++i) {
      if (strains[i] >= 0.0 && strains[i] <= most) rows.push_back(i);
    }
    if (rows.size() < kFewestCurveReadings) {
      FailOnData(table_.name, "expected at least " + std::to_string(kFewestCurveReadings) +
                                  " widths of the first half of the strains, found " + std::to_string(rows.size()));
    }
    const Eigen::ArrayXd own = strains(rows);
    Eigen::MatrixXd powers(own.size(), 3);
    powers << Eigen::VectorXd::Ones(own.size()), own, own.square();
    const Eigen::Vector3d parabola = LeastSquaresSolution(powers, widths_(rows));
    if (!(parabola[0] > 0.0 && curve_.widths.minCoeff() > 0.0 && parabola[0] <= kMostOfWidth * curve_.width)) {
      FailOnData(table_.name, "its width at rest is " + ShortestText(parabola[0]) + " m, and " +
                                  ShortestText(curve_.widths.minCoeff()) +
                                  " m at the least; expected more than 0 and at most that of the specimen, " +
                                  ShortestText(curve_.width) + " m: is a unit off?");
    }
    curve_.rest_width = std::min(parabola[0], curve_.width);
  }

  const CurveTable& table_;
  const TensileCurveOptions& options_;
  TensileCurve curve_;
  double length_ = 0.0, gauge_length_ = 0.0;  // m, as they are given
  double rest_gauge_ = 0.0;                   // m, slack included
  double first_strain_ = 0.0;                 // at the preload
  Eigen::VectorXd elongations_, forces_;      // m, N: of the loading
  Eigen::VectorXd widths_;                    // m; empty: not measured
};

}  // namespace

TensileCurve MakeTensileCurve(const CurveTable& table, const TensileCurveOptions& options) {
  CheckCurveOptions(options);
  return CurveCutter(table, options).Cut();
}

}  // namespace clothid
