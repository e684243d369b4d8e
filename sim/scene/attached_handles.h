// Nodes that are fixed to an obstacle that moves: a gripper's jaw, a waistband.
#ifndef CLOTHID_SIM_SCENE_ATTACHED_HANDLES_H_
#define CLOTHID_SIM_SCENE_ATTACHED_HANDLES_H_

#include "sim/path/handle_path.h"
#include "sim/path/rigid_path.h"
#include "sim/scene/scene.h"

namespace clothid {

// The path that takes the handles of `scene` along with `body` from where they are in its initial positions: exact at
// the ends of its steps and half way, a cubic between these. The placement of the body's path does not move them.
HandlePath AttachedPath(const Scene& scene, const RigidPath& body);

}  // namespace clothid

#endif  // CLOTHID_SIM_SCENE_ATTACHED_HANDLES_H_
