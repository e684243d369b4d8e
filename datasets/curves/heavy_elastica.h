// The shape of a strip that is held level at one end and hangs over an edge by its own weight.
//
// An inextensible strip of the flexural rigidity B (N m) and the weight w per area (N/m^2) that overhangs by L has, at
// the arc length s, the slope theta (rad, downwards) of the heavy elastica
//   B theta'' = -w (L - s) cos(theta),   theta(0) = 0,   theta'(L) = 0
// Its shape depends on c/L alone, c = (B/w)^(1/3) the bending length. In v = (L - s)/c, from the tip on, that is
// theta_vv = -v cos(theta) with theta_v(0) = 0: for each slope at the tip an initial value problem, up to v = L/c where
// theta is 0 (Runge and Kutta of fourth order).
//
// Peirce's formula for the angle a of the line from the edge to the tip, c/L = (cos(a/2)/(8 tan a))^(1/3) (1930,
// Journal of the Textile Institute 21), is close to it: B comes out 0.4 % high at 12 degrees, 3 % at 30, 6 % at 41.5, 9
// % at 51 and 14 % at 60.
#ifndef CLOTHID_DATASETS_CURVES_HEAVY_ELASTICA_H_
#define CLOTHID_DATASETS_CURVES_HEAVY_ELASTICA_H_

namespace clothid {

inline constexpr double kLeastSag = 0.0174532925, kMostSag = 1.3089969;  // rad: angles of 1 to 75 degrees

// Everything over the overhang L.
struct SaggingStrip {
  double bending_length = 0.0;      // c/L
  double tip_x = 0.0, tip_z = 0.0;  // of the tip from the edge: forwards, and upwards (< 0)
};

// Of the angle to the tip below the level, kLeastSag to kMostSag, and of a bending length over L that these have.
SaggingStrip SagOfAngle(double angle);
SaggingStrip SagOfBendingLength(double share);

}  // namespace clothid

#endif  // CLOTHID_DATASETS_CURVES_HEAVY_ELASTICA_H_
