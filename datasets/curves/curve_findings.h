// What is wrong or doubtful about a curve, which the recording that is made of it no longer shows.
#ifndef CLOTHID_DATASETS_CURVES_CURVE_FINDINGS_H_
#define CLOTHID_DATASETS_CURVES_CURVE_FINDINGS_H_

#include <vector>

#include "datasets/checking/finding.h"
#include "datasets/curves/curve_table.h"
#include "datasets/curves/tensile_curve.h"

namespace clothid {

// `curve` is what was made of `table`. Always, in this order:
//   zero of the force     the mean force within kZeroShare of the range above the least elongation, before and after
//                         the loading. Cloth cannot push, and bears no more at zero after a test than before it: a
//                         warning where the mean is below 0, or has grown, by more than kZeroShare of the largest
//                         force; a note where the curve starts with more than that: a pretension, or an offset
//   slip                  the largest fall of the force while the elongation grows, the mean of three readings less
//   that
//                         of the next three: a warning above kSlipShare of the largest force and eight times the median
//                         change from reading to reading
//   units                 the stiffness, the lower quartile of force per width over strain; the largest strain; the
//   specimen. A
//                         warning where the stiffness is far from what was measured of any cloth (sim/fabric/fabric.h),
//                         with the power of ten that would make it usual; the strain is below 0.2 or above 200 %; the
//                         specimen is not 10 to 300 mm wide or 15 to 1000 mm long
std::vector<Finding> CheckCurve(const CurveTable& table, const TensileCurve& curve);

inline constexpr double kZeroShare = 0.01, kSlipShare = 0.05;

}  // namespace clothid

#endif  // CLOTHID_DATASETS_CURVES_CURVE_FINDINGS_H_
