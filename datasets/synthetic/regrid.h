// The same cloth on another grid.
#ifndef CLOTHID_DATASETS_SYNTHETIC_REGRID_H_
#define CLOTHID_DATASETS_SYNTHETIC_REGRID_H_

#include <Eigen/Core>
#include <array>
#include <string>
#include <vector>

#include "datasets/motion/recorded_motion.h"
#include "sim/scene/scene.h"

namespace clothid {

// The scene text with its path, and what was read from it.
struct GridScene {
  std::string text;
  std::string path;            // names it in errors
  std::array<int, 2> nodes{};  // of its grid
  Scene scene;
};

// Throws `Error`: what `ReadScene` throws, and kBadData where the scene cannot be put on another grid: its mesh is not
// a grid, it has a force per node, which on another grid would be another force, or pieces, which are of the triangles
// of its own.
GridScene ReadGridScene(const std::string& path);

// The scene with `nodes[0]` x `nodes[1]` nodes on the same rectangle. Start and paths of handles are interpolated
// linearly over the triangles of the given mesh. A node is a handle where the given mesh moves that material point by
// handles alone: on a handle, on an edge between two, in a triangle of three. Throws `Error` (kUsage), naming --nodes,
// where a handle of the given mesh would be held by none of the new ones.
Scene Regrid(const GridScene& scene, const std::array<int, 2>& nodes);

// Material points on a mesh: a node where the point is one, else the corners of its triangle with barycentric
// coordinates. `rest_points` [3 x P] m lie on the mesh at rest.
std::vector<ObservedPoint> PlaceOnMesh(const Mesh& mesh, const Eigen::Matrix3Xd& rest_points);

// values [3N x c] at the nodes of a mesh, to [3P x c] at points placed on it.
Eigen::MatrixXd Interpolate(const std::vector<ObservedPoint>& points, const Eigen::MatrixXd& values);

}  // namespace clothid

#endif  // CLOTHID_DATASETS_SYNTHETIC_REGRID_H_
