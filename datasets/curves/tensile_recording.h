// A recording of a tensile test: a strip between two clamps in place of the curve.
//
// The strip is a flat grid in the plane y = 0, its length at rest along z. Its lowest and its uppermost row of nodes
// are handles, the clamps: the lower one stands, the upper one moves along z from a strain of 0 to that of the last
// reading, at constant speed, so that a reading at the strain e belongs to the time T e/e_last. The only forces that
// are told are those of the upper clamp along z. A recording has a point at least: of a curve with widths the right of
// its two marks, half the length up, whose x is half the width at every reading; without, the node in the middle, which
// is never seen. The left mark would tell the same once more. Whoever tracked other markers can put them in its place.
//
// The clock is not that of the machine. A curve has no rate: the laws of stretch have none, and what of a real curve
// is creep and relaxation no constant can express. T = 10 s in 100 steps of backward Euler, no gravity, no air. What
// then is in the predicted force beside that of the stretched cloth is inertia. Points of a strip that stretches evenly
// have the velocity v z/l, v that of the clamp; with density rho, width w and length l, the virtual work of their
// inertia gives the clamp
//   rho w l/3 v/h in the first step of length h, then 0
// and oscillations, which a step divides by h w with their angular frequency w, hundreds per second. That is 2e-5 N for
// 0.2 kg/m^2, 50 x 200 mm and 15 %: see `InertiaAtClamp`. In balance that is also the largest term of a step, to which
// its residual is compared: a step tolerance of 0.01 leaves a hundredth of that force. With the usual 1e-8 a cloth that
// has stiffened by exp(2.5) is not solved at all: its forces are rounded by more. Readings lie in between steps on a
// straight line, which is high by b^2 d^2/8 of the force for a curve that stiffens by exp(b e), d the strain of a step:
// 3e-5 for b = 6, 25 %.
#ifndef CLOTHID_DATASETS_CURVES_TENSILE_RECORDING_H_
#define CLOTHID_DATASETS_CURVES_TENSILE_RECORDING_H_

#include <array>
#include <string>

#include "datasets/curves/tensile_curve.h"
#include "datasets/motion/motion_tensors.h"
#include "sim/scene/scene.h"

namespace clothid {

enum class PullDirection { kWarp, kWeft, kBias };  // kBias: at 45 degrees to both

struct TensileStrip {
  PullDirection direction = PullDirection::kWarp;
  MembraneLaw membrane = MembraneLaw::kYarn;  // or kOrthotropic
  std::array<int, 2> nodes = {9, 9};          // across and along the pull, at least 2 and 3
};

// Nine across and along; of a bias strip so many along, up to 65, that cells are as long as they are wide. Even stretch
// needs no mesh, but between clamps a bias strip shears in triangles and stays as it is in others: on 9 x 9 nodes a
// strip of 50 x 200 mm is 12 % too stiff, on 9 x 33 it is 1 %.
std::array<int, 2> UsualNodes(const TensileCurve& curve, PullDirection direction);

// The recording, which `ReadMotion` has been tried on. Nominal values of the scene: k of warp and weft is the power of
// ten nearest to that of the curve, the shear stiffness half of it, k_poisson 0, stiffening 3. A bias strip of these
// has, at small strain, the same stiffness 4/(1/k_warp + 1/k_weft + 1/k_shear). They know no more of the curve, so that
// a curve that is held out is judged against what does not know it. Throws `Error`: kUsage for a strip that is none.
MotionTensors RecordTensileTest(const TensileCurve& curve, const TensileStrip& strip, const std::string& provenance);

// N, the bound above, for the density of the scene of RecordTensileTest.
double InertiaAtClamp(const TensileCurve& curve);

// The parameters that such a curve determines, "k_weft,stiffening_weft"; of a bias strip k_shear, if it is fitted
// jointly with curves along warp and weft, which tell the others. With widths k_poisson, too.
std::string ParametersOfPull(const TensileStrip& strip, bool has_widths = false);

}  // namespace clothid

#endif  // CLOTHID_DATASETS_CURVES_TENSILE_RECORDING_H_
