// The noise of a recording, from the recording itself: what of a point's path its neighbours in time do not tell.
//
// A coordinate y_i is compared with the polynomial through its nearest seen neighbours in time, at any spacing:
//   d_i = (y_i - sum_k c_k y_k)/sqrt(1 + sum_k c_k^2),  k over 2 (linear) or 4 (cubic) neighbours on both sides,
// c the weights of Lagrange's interpolation. Independent noise of variance sigma^2 gives d the variance sigma^2, and
// smooth motion adds little (Gasser, Sroka and Jennen-Steinmetz 1986, Biometrika 73). The spread of d is taken as
// 1.4826 median |d|, taken again without what is five times as large: so rare jumps do not count. Of both orders the
// one that finds less noise over all points is used, because motion only adds.
//
// It is an upper bound where the motion between frames is not smooth, and misses errors that last longer than a frame.
#ifndef CLOTHID_DATASETS_MOTION_NOISE_ESTIMATE_H_
#define CLOTHID_DATASETS_MOTION_NOISE_ESTIMATE_H_

#include <Eigen/Core>

namespace clothid {

// Per point the standard deviation of a coordinate [P] m: the root mean square over x, y and z. Points with fewer than
// kFewestDifferences in an axis have that of all points. times [T] s, increasing; positions [3P x T] m, NaN: not seen.
// Never below `least`, m. Empty where no point is seen often enough to tell.
Eigen::VectorXd EstimateSigma(const Eigen::VectorXd& times, const Eigen::MatrixXd& positions, double least);

inline constexpr int kFewestDifferences = 12;

}  // namespace clothid

#endif  // CLOTHID_DATASETS_MOTION_NOISE_ESTIMATE_H_
