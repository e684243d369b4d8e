// Small random scenes: what a property has to hold for.
#ifndef CLOTHID_TESTS_SIM_RANDOM_SCENE_H_
#define CLOTHID_TESTS_SIM_RANDOM_SCENE_H_

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "sim/obstacle/obstacle.h"
#include "sim/scene/scene.h"
#include "tests/sim/scene/triangle_meshes.h"

namespace clothid {

// An obstacle in the numbers that it is made of, which `Obstacle` does not give away: tests move and rescale them.
struct Shape {
  enum class Kind { kPlane, kSphere, kCapsule, kSurface, kBox, kCylinder, kTorus, kBowl };
  Kind kind = Kind::kPlane;
  Eigen::Vector3d point = Eigen::Vector3d::Zero();    // m: of the plane, a centre, start of the capsule and cylinder
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();  // of the plane; axis of torus and bowl
  Eigen::Vector3d end = Eigen::Vector3d::Zero();      // m: of the capsule and cylinder
  double radius = 0.0;                                // m
  double thickness = 0.0;                             // m: of the bowl; of the torus's tube and the box's round edges
  double angle = 0.0;                                 // rad: of the bowl
  Eigen::Vector3d size = Eigen::Vector3d::Zero();     // m: of the box
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();  // of the box
  TriangleMesh surface;

  void Shift(const Eigen::Vector3d& offset);
  std::shared_ptr<const Obstacle> Make() const;
};

struct RandomScene {
  Scene scene;
  std::vector<Shape> shapes;  // of the scene's obstacles
  std::string description;    // one line, with the seed
};

// What a scene may have; whether it does is random.
struct RandomSceneOptions {
  bool handles = true;    // none, fixed or moving
  bool obstacles = true;  // none to three
  bool air = true;        // drag of either kind, added mass, steady wind, gusts
};

// 3 to 60 nodes: a triangle, grids, strips or irregular triangulations, in one piece or two, turned and strained at the
// start; time step, stiffness, density, bending and size over decades; 4 to 14 steps. The same arguments give the same
// scene on every machine, up to the rounding of its compiler.
RandomScene MakeRandomScene(std::uint64_t seed, const RandomSceneOptions& options = {});

}  // namespace clothid

#endif  // CLOTHID_TESTS_SIM_RANDOM_SCENE_H_
