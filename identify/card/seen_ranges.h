// How far a cloth was strained and bent: where the constants of its laws were seen.
#ifndef CLOTHID_IDENTIFY_CARD_SEEN_RANGES_H_
#define CLOTHID_IDENTIFY_CARD_SEEN_RANGES_H_

#include <Eigen/Core>
#include <limits>
#include <map>

#include "sim/scene/scene.h"

namespace clothid {

// From the first to the 99th percentile over triangles and frames.
struct SeenRange {
  double from = std::numeric_limits<double>::quiet_NaN(), to = std::numeric_limits<double>::quiet_NaN();

  bool is_known() const { return to >= from; }
  void Extend(const SeenRange& other);
};

// Of the constants of stretch and of bending by patches that `scene` has, its nodes being at `positions` [3N x T] m:
//   k_stretch                       the larger principal strain
//   k_warp, stiffening_warp, ..     |f| - 1 along warp and weft
//   k_shear                         |cos| of the angle between them
//   k_bend                          1/m, the larger principal curvature beyond that at rest, its size
//   bend_warp, bend_weft, bend_twist  likewise along warp, weft and of twist
std::map<ParameterKind, SeenRange> SeenRanges(const Scene& scene, const Eigen::MatrixXd& positions);

// The mean over the triangles of the strain of `kind`, k_stretch, k_warp or k_weft, in every frame [T].
Eigen::VectorXd MeanStrains(const Scene& scene, const Eigen::MatrixXd& positions, ParameterKind kind);

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_CARD_SEEN_RANGES_H_
