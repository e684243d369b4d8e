// The same scene seen otherwise: from another place, in other units, with its nodes in another order.
#ifndef CLOTHID_TESTS_SIM_SCENE_TRANSFORMS_H_
#define CLOTHID_TESTS_SIM_SCENE_TRANSFORMS_H_

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "sim/scene/parameters.h"
#include "sim/scene/scene.h"
#include "tests/sim/random_scene.h"

namespace clothid {

// x -> rotation x + translation.
struct TurnAndShift {
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
  Eigen::Vector3d translation = Eigen::Vector3d::Zero();  // m

  // Of columns that hold several points, or vectors that have no place, [3n x c].
  Eigen::MatrixXd OfPoints(const Eigen::MatrixXd& points) const;
  Eigen::MatrixXd OfVectors(const Eigen::MatrixXd& vectors) const;
};

// Everything that has a place or a direction: start, handles' path, obstacles, gravity, forces, wind. The rest shape,
// which only wind knows the place of, is moved by `rest`, which must not translate it where there are gusts.
Scene Moved(const RandomScene& original, const TurnAndShift& motion, const TurnAndShift& rest);

// How many new units make an old one: a length of 1 m is `length` new ones. Powers of two, those of mass and length
// even ones of which a square root is taken, change no bit of a mantissa.
struct Units {
  double length = 1.0, mass = 1.0, time = 1.0;

  double speed() const { return length / time; }
  double acceleration() const { return length / (time * time); }
  double force() const { return mass * acceleration(); }
  double Of(ParameterKind kind, AirLaw law = AirLaw::kLinear) const;
};

// Every number of the scene in the new units. Relative ones (touch, tolerances, mu) have none.
Scene Rescaled(const RandomScene& original, const Units& units);
Parameters Rescaled(const Parameters& parameters, const Units& units, AirLaw law = AirLaw::kLinear);

// Node i of `scene` becomes node new_index[i]; handles, faces and their corners come in another order, too.
Scene Renumbered(const Scene& scene, const std::vector<int>& new_index, std::uint64_t seed);
Eigen::VectorXd Renumbered(const Eigen::VectorXd& state, const std::vector<int>& new_index);  // [3N]

}  // namespace clothid

#endif  // CLOTHID_TESTS_SIM_SCENE_TRANSFORMS_H_
