#include "datasets/curves/curve_findings.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "datasets/checking/finding_words.h"
#include "sim/base/median.h"
#include "sim/fabric/fabric.h"

namespace clothid {
namespace {

constexpr double kManyChanges = 8.0;  // of the median change: no scatter
constexpr Eigen::Index kSlipWindow = 3;
constexpr double kLeastUsualStrain = 0.002, kMostUsualStrain = 2.0;
constexpr double kNarrow = 0.01, kWide = 0.3, kShort = 0.015, kLong = 1.0;  // m

std::string ForceWords(double force) { return Rounded(force) + " N"; }

// The readings, in m or in strain of the gauge, and in N.
struct Readings {
  Readings(const CurveTable& table, const TensileCurve& curve)
      : elongations(table.elongations),
        forces(table.forces * (table.is_per_width ? curve.width : 1.0)),
        num_loading(table.forces.size() - curve.num_after),
        largest(forces.head(num_loading).maxCoeff()) {}

  const Eigen::VectorXd elongations, forces;
  const Eigen::Index num_loading;
  const double largest;  // N
};

// Of readings `first` to `last` - 1 at zero elongation; NaN where there is none.
double ForceAtZero(const Readings& readings, Eigen::Index first, Eigen::Index last) {
  const double least = readings.elongations.head(readings.num_loading).minCoeff();
  const double most = least + kZeroShare * (readings.elongations[readings.num_loading - 1] - least);
  double sum = 0.0, count = 0.0;
  for (Eigen::Index i = first; i < last; ++i) {
    if (readings.elongations[i] > most) continue;
    sum += readings.forces[i];
    count += 1.0;
  }
  return sum / count;
}

Finding CheckZero(const Readings& readings) {
  const double before = ForceAtZero(readings, 0, readings.num_loading);
  const double after = ForceAtZero(readings, readings.num_loading, readings.forces.size());
  const bool has_after = !std::isnan(after);
  const double allowed = kZeroShare * readings.largest;
  Finding finding;
  finding.what = "zero of the force";
  finding.value = ForceWords(before) + " at zero elongation before the loading, " +
                  (has_after ? ForceWords(after) + " after it" : "none after it, where the table does not come back");
  if (before < -allowed || (has_after && (after < -allowed || after > before + allowed))) {
    finding.severity = Severity::kWarning;
    finding.hint = "the gauge is off at zero or drifts: cloth does not push; identify --fit ..,force_bias.z";
  } else if (before > allowed) {
    finding.severity = Severity::kNote;
    finding.hint = "a pretension; or else the gauge is off at zero: identify --fit ..,force_bias.z";
  }
  return finding;
}

Finding CheckSlip(const Readings& readings, const CurveTable& table, const TensileCurve& curve) {
  std::vector<double> changes;
  for (Eigen::Index i = 1; i < readings.num_loading; ++i) {
    changes.push_back(std::abs(readings.forces[i] - readings.forces[i - 1]));
  }
  const double scatter = changes.empty() ? 0.0 : Median(std::move(changes));
  double fall = 0.0;
  Eigen::Index last = 0;  // before the fall
  for (Eigen::Index i = kSlipWindow; i + kSlipWindow <= readings.num_loading; ++i) {
    const double by =
        readings.forces.segment(i - kSlipWindow, kSlipWindow).mean() - readings.forces.segment(i, kSlipWindow).mean();
    if (by <= fall || readings.elongations[i + kSlipWindow - 1] < readings.elongations[i - kSlipWindow]) continue;
    fall = by;
    last = i - 1;
  }
  Finding finding;
  finding.what = "slip";
  finding.value = "none: the force falls by " + ForceWords(fall) + " at most while the elongation grows";
  if (fall <= std::max(kSlipShare * readings.largest, kManyChanges * scatter)) return finding;
  const double gauge = table.is_strain ? curve.gauge_length - curve.slack : 1.0;
  const double strain = (readings.elongations[last] * gauge - curve.slack) / curve.gauge_length;
  finding.severity = Severity::kWarning;
  finding.value = "the force falls by " + ForceWords(fall) + " at a strain of " + Rounded(100.0 * strain) + " %";
  finding.hint = "it slips in the clamps, or tears: keep what comes before, --strain 0:" + Rounded(0.99 * strain);
  return finding;
}

std::string InRange(const MeasuredConstant& range) {
  return Rounded(range.lowest) + " to " + Rounded(range.highest) + " " + range.unit;
}

Finding CheckUnits(const TensileCurve& curve) {
  const MeasuredConstant& usual = AnyFabric().k_stretch;
  Eigen::VectorXd secants = curve.forces.array() / (curve.width * curve.strains.array());
  std::sort(secants.begin(), secants.end());
  const double stiffness = secants[secants.size() / 4];
  const double largest = curve.strains[curve.strains.size() - 1];
  const bool is_usual_size =
      curve.width >= kNarrow && curve.width <= kWide && curve.length >= kShort && curve.length <= kLong;
  Finding finding;
  finding.what = "units";
  finding.value = Rounded(stiffness) + " N/m (lower quartile of force per width over strain), strains up to " +
                  Rounded(100.0 * largest) + " %, a specimen of " + Rounded(1e3 * curve.width) + " x " +
                  Rounded(1e3 * curve.length) + " mm";
  if (!is_usual_size) {
    finding.hint = "expected a specimen 10 to 300 mm wide and 15 to 1000 mm long, in mm: --specimen";
  } else if (!(largest >= kLeastUsualStrain && largest <= kMostUsualStrain)) {
    finding.hint =
        "expected strains up to 0.2 to 200 %: is the unit of the elongation off, or the length between clamps?";
  } else if (usual.IsFarFrom(stiffness)) {
    const double power = std::round(std::log10(stiffness / std::sqrt(usual.lowest * usual.highest)));
    finding.hint = "of cloth " + InRange(usual) + " were measured: is the unit of the force off" +
                   (std::isfinite(power) ? " by 10^" + Rounded(power) : "") + "?";
  }
  if (!finding.hint.empty()) finding.severity = Severity::kWarning;
  return finding;
}

}  // namespace

std::vector<Finding> CheckCurve(const CurveTable& table, const TensileCurve& curve) {
  const Readings readings(table, curve);
  return {CheckZero(readings), CheckSlip(readings, table, curve), CheckUnits(curve)};
}

}  // namespace clothid
