#include "identify/prediction/random_start.h"

#include <algorithm>
#include <cmath>

#include "identify/prediction/derived.h"
#include "identify/prediction/random_streams.h"

namespace clothid {
namespace {

Eigen::VectorXd HandleKnots(const Scene& scene, double interval) {
  constexpr Eigen::Index kMostKnots = 1000;
  if (!(interval > 0.0)) return Eigen::Vector2d(scene.start_time, scene.start_time + RandomStart::kSetIn);
  const auto count = static_cast<Eigen::Index>(std::ceil(scene.duration / interval)) + 1;
  const Eigen::Index num_knots = std::clamp<Eigen::Index>(count, 2, kMostKnots);
  return Eigen::VectorXd::LinSpaced(num_knots, scene.start_time,
                                    scene.start_time + interval * static_cast<double>(num_knots - 1));
}

// How deep a node is in the deepest obstacle, m; 0: in none.
double DepthOf(const Scene& scene, const Eigen::Vector3d& position) {
  double depth = 0.0;
  for (const SceneObstacle& obstacle : scene.obstacles) {
    const SurfacePoint closest = obstacle.ShapeAt(scene.start_time)->Closest(position);
    depth = std::max(depth, obstacle.contact_distance - closest.gap);
  }
  return depth;
}

}  // namespace

RandomStart::RandomStart(const Scene& scene, const LearntStart& start, bool with_start, bool with_handles) {
  if (with_start && (start.position > 0.0 || start.velocity > 0.0)) {
    spread_.emplace(scene, start.position, start.velocity);
  }
  if (!with_handles || scene.handles.nodes.empty() || !(start.handles > 0.0)) return;
  handles_ = start.handles;
  gripper_.resize(scene.handles.nodes.size());
  const std::vector<std::vector<int>> grippers = GripperNodes(scene);
  for (std::size_t h = 0; h < gripper_.size(); ++h) {
    const auto holds = [&](const std::vector<int>& held) {
      return std::find(held.begin(), held.end(), scene.handles.nodes[h]) != held.end();
    };
    gripper_[h] = static_cast<int>(std::find_if(grippers.begin(), grippers.end(), holds) - grippers.begin());
  }
  knots_ = HandleKnots(scene, start.handle_interval);
}

void RandomStart::MoveStart(std::uint64_t seed, int draw, Scene* scene) const {
  NormalStream stream(seed, draw, DrawStream::kStart);
  const Eigen::MatrixXd &positions = spread_->position_root(), &velocities = spread_->velocity_root();
  const Eigen::VectorXd moved = spread_->Displacement(positions * stream.Draw(positions.cols(), 1));
  scene->initial_velocities += spread_->Displacement(velocities * stream.Draw(velocities.cols(), 1));
  for (int node = 0; node < scene->mesh.num_nodes(); ++node) {
    const Eigen::Vector3d before = scene->initial_positions.segment<3>(3 * node);
    const Eigen::Vector3d after = before + moved.segment<3>(3 * node);
    if (DepthOf(*scene, after) > DepthOf(*scene, before)) continue;
    scene->initial_positions.segment<3>(3 * node) = after;
  }
}

HandlePath RandomStart::HandleOffsets(std::uint64_t seed, int draw) const {
  NormalStream stream(seed, draw, DrawStream::kHandles);
  const auto num_handles = static_cast<Eigen::Index>(gripper_.size());
  Eigen::MatrixXd offsets = Eigen::MatrixXd::Zero(3 * num_handles, knots_.size());
  for (Eigen::Index knot = 1; knot < knots_.size(); ++knot) {
    const Eigen::MatrixXd of_grippers = handles_ * stream.Draw(3, num_handles);
    for (Eigen::Index h = 0; h < num_handles; ++h) {
      offsets.block<3, 1>(3 * h, knot) = of_grippers.col(gripper_[static_cast<std::size_t>(h)]);
    }
  }
  return HandlePath(knots_, offsets);
}

}  // namespace clothid
