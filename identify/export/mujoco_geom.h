// Obstacles as geoms of MuJoCo.
#ifndef CLOTHID_IDENTIFY_EXPORT_MUJOCO_GEOM_H_
#define CLOTHID_IDENTIFY_EXPORT_MUJOCO_GEOM_H_

#include <Eigen/Core>
#include <string>

#include "sim/scene/scene.h"

namespace clothid {

// "x y z", in as many digits as tell the numbers.
std::string MujocoNumbers(const Eigen::Vector3d& vector);

// Lines of XML: the obstacle as a geom with this friction. A comment, always a line of its own, says what of the shape
// MuJoCo has not; it stands alone where there is no such geom.
std::string MujocoGeom(const SceneObstacle& obstacle, double friction);

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_EXPORT_MUJOCO_GEOM_H_
