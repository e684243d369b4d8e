#include "identify/export/mujoco_geom.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <memory>
#include <string>

#include "sim/obstacle/box.h"
#include "sim/obstacle/round_shapes.h"
#include "sim/obstacle/triangulated_surface.h"
#include "tests/sim/scene/triangle_meshes.h"

namespace clothid::mujoco_geom_test {
namespace {

using Eigen::Vector3d;

template <typename Shape>
std::string GeomOf(const Shape& shape) {
  return MujocoGeom({"it", std::make_shared<Shape>(shape), 0.3, 0.0}, 0.5);
}

constexpr char kTail[] = " friction=\"0.5 0.005 0.0001\" condim=\"3\"/>\n";

TEST(MujocoGeom, HasSizeAndPlaceOfWhatMujocoHas) {
  EXPECT_EQ(GeomOf(Plane({0, 0, 1}, {0, 2, 0})),
            std::string("    <geom type=\"plane\" size=\"0 0 1\" pos=\"0 0 1\" zaxis=\"0 1 0\"") + kTail);
  EXPECT_EQ(GeomOf(Sphere({1, 2, 3}, 0.5)),
            std::string("    <geom type=\"sphere\" size=\"0.5\" pos=\"1 2 3\"") + kTail);
  EXPECT_EQ(GeomOf(Capsule({0, 0, 0}, {0, 0, 2}, 0.25)),
            std::string("    <geom type=\"capsule\" size=\"0.25\" fromto=\"0 0 0 0 0 2\"") + kTail);
  EXPECT_EQ(GeomOf(Cylinder({0, 0, 0}, {0, 0, 2}, 0.25)),
            std::string("    <geom type=\"cylinder\" size=\"0.25\" fromto=\"0 0 0 0 0 2\"") + kTail);
  EXPECT_EQ(GeomOf(Box({1, 2, 3}, {0.5, 1.0, 2.0}, Eigen::Quaterniond(0, 1, 0, 0))),
            std::string("    <geom type=\"box\" size=\"0.25 0.5 1\" pos=\"1 2 3\" quat=\"0 1 0 0\"") + kTail);
}

TEST(MujocoGeom, SaysWhatMujocoHasNot) {
  const std::string round = GeomOf(Box({0, 0, 0}, {1, 1, 1}, Eigen::Quaterniond::Identity(), 0.125));
  EXPECT_EQ(round.find("    <!-- the edges of this box are round, with a radius of 0.125 m"), 0u) << round;
  EXPECT_NE(round.find("\n    <geom type=\"box\""), std::string::npos) << round;
  const TriangleMesh cube = CubeMesh(1.0);
  const Vector3d zero = Vector3d::Zero(), up = Vector3d::UnitZ();
  EXPECT_EQ(GeomOf(Torus(zero, up, 1.0, 0.5)),
            "    <!-- a torus is left out: MuJoCo has no such geom; its friction is 0.5 -->\n");
  EXPECT_EQ(GeomOf(Bowl(zero, up, 1.0, 1.0, 0.5)),
            "    <!-- a bowl is left out: MuJoCo has no such geom; its friction is 0.5 -->\n");
  EXPECT_EQ(GeomOf(TriangulatedSurface(cube.vertices, cube.faces)),
            "    <!-- a mesh is left out: MuJoCo would touch its convex hull; its friction is 0.5 -->\n");
}

}  // namespace
}  // namespace clothid::mujoco_geom_test
