#include "identify/export/mujoco_geom.h"

#include <Eigen/Geometry>

#include "sim/base/text_file.h"
#include "sim/obstacle/box.h"
#include "sim/obstacle/round_shapes.h"
#include "sim/obstacle/triangulated_surface.h"

namespace clothid {
namespace {

// MuJoCo's order of a quaternion.
std::string Quaternion(const Eigen::Quaterniond& q) {
  return ShortestText(q.w()) + " " + MujocoNumbers({q.x(), q.y(), q.z()});
}

std::string FromTo(const Eigen::Vector3d& from, const Eigen::Vector3d& to) {
  return "\" fromto=\"" + MujocoNumbers(from) + " " + MujocoNumbers(to);
}

// The type, size and place of a geom; empty where MuJoCo has no such shape.
std::string GeomShape(const Obstacle* shape) {
  if (const auto* plane = dynamic_cast<const Plane*>(shape)) {
    return "plane\" size=\"0 0 1\" pos=\"" + MujocoNumbers(plane->point()) + "\" zaxis=\"" +
           MujocoNumbers(plane->normal());
  }
  if (const auto* sphere = dynamic_cast<const Sphere*>(shape)) {
    return "sphere\" size=\"" + ShortestText(sphere->radius()) + "\" pos=\"" + MujocoNumbers(sphere->center());
  }
  if (const auto* capsule = dynamic_cast<const Capsule*>(shape)) {
    return "capsule\" size=\"" + ShortestText(capsule->radius()) + FromTo(capsule->from(), capsule->to());
  }
  if (const auto* cylinder = dynamic_cast<const Cylinder*>(shape)) {
    return "cylinder\" size=\"" + ShortestText(cylinder->radius()) + FromTo(cylinder->from(), cylinder->to());
  }
  if (const auto* box = dynamic_cast<const Box*>(shape)) {
    return "box\" size=\"" + MujocoNumbers(0.5 * box->size()) + "\" pos=\"" + MujocoNumbers(box->center()) +
           "\" quat=\"" + Quaternion(box->rotation());
  }
  return "";
}

// Of a shape that MuJoCo has not.
std::string WhatIsMissing(const Obstacle* shape) {
  const std::string none = " is left out: MuJoCo has no such geom";
  if (dynamic_cast<const Torus*>(shape) != nullptr) return "a torus" + none;
  if (dynamic_cast<const Bowl*>(shape) != nullptr) return "a bowl" + none;
  if (dynamic_cast<const TriangulatedSurface*>(shape) != nullptr) {
    return "a mesh is left out: MuJoCo would touch its convex hull";
  }
  return "an obstacle of another shape is left out";
}

}  // namespace

std::string MujocoNumbers(const Eigen::Vector3d& vector) {
  return ShortestText(vector[0]) + " " + ShortestText(vector[1]) + " " + ShortestText(vector[2]);
}

std::string MujocoGeom(const SceneObstacle& obstacle, double friction) {
  const std::string shape = GeomShape(obstacle.shape.get());
  if (shape.empty()) {
    const std::string missing =
        obstacle.sequence != nullptr ? "a mesh that deforms is left out" : WhatIsMissing(obstacle.shape.get());
    return "    <!-- " + missing + "; its friction is " + ShortestText(friction) + " -->\n";
  }
  std::string lines;
  const auto* box = dynamic_cast<const Box*>(obstacle.shape.get());
  if (box != nullptr && box->radius() > 0.0) {
    lines = "    <!-- the edges of this box are round, with a radius of " + ShortestText(box->radius()) +
            " m: those of MuJoCo's are sharp -->\n";
  }
  return lines + "    <geom type=\"" + shape + "\" friction=\"" + ShortestText(friction) +
         " 0.005 0.0001\" condim=\"3\"/>\n";
}

}  // namespace clothid
