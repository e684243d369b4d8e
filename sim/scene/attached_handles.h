// How handles move that are fixed to a body, a gripper's jaw or a waistband, and the directions in which a cloth leaves
// handles that clamp it.
#ifndef CLOTHID_SIM_SCENE_ATTACHED_HANDLES_H_
#define CLOTHID_SIM_SCENE_ATTACHED_HANDLES_H_

#include <Eigen/Core>
#include <memory>
#include <optional>
#include <vector>

#include "sim/path/handle_path.h"
#include "sim/path/rigid_path.h"
#include "sim/scene/scene.h"

namespace clothid {

// The path that takes `nodes` of `scene` along with `body` from where they are in its initial positions: exact at the
// ends of its steps and half way, a cubic between these. The placement of the body's path does not move them.
HandlePath AttachedPath(const Scene& scene, const std::vector<int>& nodes, const RigidPath& body);

// The path of groups of handles, one after the other: `paths` has one for each of `groups`, empty where the group stays
// in the initial positions. The knots are those of the paths where all have the same, else the ends of the steps and
// half way. Empty where all are.
HandlePath JoinPaths(const Scene& scene, const std::vector<std::vector<int>>& groups,
                     const std::vector<HandlePath>& paths);

// A jaw that holds a row of nodes.
struct Clamp {
  std::vector<int> nodes;
  // The direction in which the cloth leaves it at the start, or where the path of `body` begins; its part along the row
  // does not count. Nothing: that in which the mesh does, turned with the row from the rest shape on, the shortest way
  // where the row is straight.
  std::optional<Eigen::Vector3d> direction = std::nullopt;
  std::shared_ptr<const RigidPath> body = nullptr;  // what turns it; null: the motion of the row itself
};

// Sets `clamped` and `slopes` of the handles of `scene`, whose nodes and paths are there. The slopes have the ends of
// its steps and half way as knots; clamps that do not turn have one knot. Throws `Error` (kBadData) for a clamp without
// an edge of the cloth that leaves it, or with a direction along its row.
void ClampHandles(const std::vector<Clamp>& clamps, Scene* scene);

}  // namespace clothid

#endif  // CLOTHID_SIM_SCENE_ATTACHED_HANDLES_H_
