// The velocity of the air before the cloth disturbs it, and by which law it drags on the cloth.
//
//   w(t, X) = (1 + shear . (X - c)) (mean + profile(t) + gust sin(frequency t + wave_vector . X + phase))
// X the rest position, c the centroid of the cloth at rest (its area's): so the wind varies over the cloth with the
// material, and where the cloth moves to does not matter.
#ifndef CLOTHID_SIM_AIR_WIND_H_
#define CLOTHID_SIM_AIR_WIND_H_

#include <Eigen/Core>
#include <string>
#include <vector>

namespace clothid {

inline constexpr int kMaxWindKnots = 10000;

// How drag_normal and drag_tangential grow with the speed: see "Drag by direction" in sim/README.md.
enum class AirLaw {
  kLinear,     // force in proportion to the speed: slow air, kg/(m^2 s)
  kQuadratic,  // to its square: pressure of the air, kg/m^3
};

// Piecewise linear between its knots, constant before the first and after the last. Without knots: zero.
struct WindProfile {
  Eigen::VectorXd times = {};        // [K] s, increasing, on the clock of the scene
  Eigen::Matrix3Xd velocities = {};  // [3 x K] m/s

  int num_knots() const { return static_cast<int>(times.size()); }
  // What the value of knot `knot` counts for at a time, 0 to 1.
  double Weight(int knot, double time) const;
  Eigen::Vector3d At(double time) const;
};

// A place on the cloth.
struct RestPlace {
  Eigen::Vector3d position = Eigen::Vector3d::Zero();     // X, m
  Eigen::Vector3d from_center = Eigen::Vector3d::Zero();  // X - c, m
};

// Those of all nodes [N], at `positions` [3 x N] m with `areas` [N], which weigh the centroid.
std::vector<RestPlace> RestPlaces(const Eigen::Matrix3Xd& positions, const Eigen::VectorXd& areas);

struct Wind {
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();         // m/s
  Eigen::Vector3d gust = Eigen::Vector3d::Zero();         // m/s
  double frequency = 0.0;                                 // rad/s
  Eigen::Vector3d wave_vector = Eigen::Vector3d::Zero();  // rad/m
  double phase = 0.0;                                     // rad
  Eigen::Vector3d shear = Eigen::Vector3d::Zero();        // 1/m: by which share the wind grows along the rest shape
  WindProfile profile = {};

  Eigen::Vector3d At(double time, const RestPlace& place) const;
  // frequency t + wave_vector . X + phase, rad, and 1 + shear . (X - c).
  double GustAngle(double time, const RestPlace& place) const;
  double ShearFactor(const RestPlace& place) const { return 1.0 + shear.dot(place.from_center); }
  bool is_still() const { return mean.isZero(0.0) && gust.isZero(0.0) && profile.velocities.isZero(0.0); }
};

// Throws `Error` (kBadData), prefixed by `source`, unless all numbers are finite and the times of a profile increase,
// at most kMaxWindKnots, with a velocity each.
void ValidateWind(const Wind& wind, const std::string& source);

}  // namespace clothid

#endif  // CLOTHID_SIM_AIR_WIND_H_
