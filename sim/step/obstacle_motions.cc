#include "sim/step/obstacle_motions.h"

#include <algorithm>

namespace clothid {
namespace {

// `pose_at`: PoseJet of a time. The maps are linear in what it gives.
template <typename PoseAt>
SolveMaps MapsOf(const SolveTimes& times, const PoseAt& pose_at) {
  const double eta = times.time_step;
  SolveMaps maps;
  switch (times.stage) {
    case Stage::kOnly: {
      maps.start = pose_at(times.end_time - eta).pose;
      maps.velocity = (pose_at(times.end_time).pose - maps.start) / eta;
      break;
    }
    case Stage::kFirst: {
      const PoseJet start = pose_at(times.end_time - eta);
      maps.start = start.pose;
      maps.velocity = pose_at(times.end_time).rate;
      maps.velocity_change = maps.velocity - start.rate;
      break;
    }
    case Stage::kSecond: {
      const double step_start = times.end_time - eta / kStageShare;
      maps.start = pose_at(step_start).pose + kSecondStageReach * eta * pose_at(step_start + eta).rate;
      maps.velocity = (pose_at(times.end_time).pose - maps.start) / eta;
      break;
    }
  }
  return maps;
}

}  // namespace

std::vector<ObstacleMotion> ObstacleMotions(const Scene& scene, const Parameters& parameters, const SolveTimes& times) {
  if (!scene.has_moving_obstacles()) return {};
  std::vector<ObstacleMotion> motions(scene.obstacles.size());
  for (std::size_t i = 0; i < motions.size(); ++i) {
    const SceneObstacle& obstacle = scene.obstacles[i];
    if (obstacle.path == nullptr) continue;
    motions[i] = ObstacleMotion(MapsOf(times, [&](double time) {
      return PlacedPose(*obstacle.path, parameters.placement(static_cast<int>(i)), time);
    }));
  }
  return motions;
}

SolveMaps ObstacleMapsChange(const SceneObstacle& obstacle, const Placement& placement, PlacementPart part,
                             const SolveTimes& times) {
  return MapsOf(times, [&](double time) { return PlacedPoseChange(*obstacle.path, placement, part, time); });
}

}  // namespace clothid
