#include "sim/step/obstacle_motions.h"

#include <memory>

#include "sim/obstacle/deformed_surface.h"
#include "sim/obstacle/surface_sequence.h"

namespace clothid {
namespace {

// A_0. `jet_at`: what a time gives, `pose` and `rate`. The result is linear in that.
template <typename JetAt>
auto StartOf(const SolveTimes& times, const JetAt& jet_at) {
  if (times.stage != Stage::kSecond) return jet_at(times.end_time - times.time_step).pose;
  const double step_start = times.end_time - times.time_step / kStageShare;
  auto start = jet_at(step_start).pose;
  start += kSecondStageReach * times.time_step * jet_at(step_start + times.time_step).rate;
  return start;
}

// `pose_at`: PoseJet of a time. The maps are linear in what it gives.
template <typename PoseAt>
SolveMaps MapsOf(const SolveTimes& times, const PoseAt& pose_at) {
  SolveMaps maps;
  if (times.stage == Stage::kFirst) {
    const PoseJet start = pose_at(times.end_time - times.time_step);
    maps.start = start.pose;
    maps.velocity = pose_at(times.end_time).rate;
    maps.velocity_change = maps.velocity - start.rate;
  } else {
    maps.start = StartOf(times, pose_at);
    maps.velocity = (pose_at(times.end_time).pose - maps.start) / times.time_step;
  }
  return maps;
}

ObstacleMotion MotionOfSequence(const std::shared_ptr<const SurfaceSequence>& sequence, const Placement& placement,
                                const SolveTimes& times) {
  TriangulatedSurface start =
      sequence->MovedTo(StartOf(times, [&](double time) { return sequence->At(placement, time); }));
  const auto maps = [=](int face) {
    return MapsOf(times, [&](double time) { return sequence->FaceAt(face, placement, time); });
  };
  return ObstacleMotion(std::make_shared<const DeformedSurface>(std::move(start), maps));
}

}  // namespace

std::vector<ObstacleMotion> ObstacleMotions(const Scene& scene, const Parameters& parameters, const SolveTimes& times) {
  if (!scene.has_moving_obstacles()) return {};
  std::vector<ObstacleMotion> motions(scene.obstacles.size());
  for (std::size_t i = 0; i < motions.size(); ++i) {
    const SceneObstacle& obstacle = scene.obstacles[i];
    if (!obstacle.moves()) continue;
    const Placement placement = parameters.placement(static_cast<int>(i));
    motions[i] = obstacle.sequence != nullptr ? MotionOfSequence(obstacle.sequence, placement, times)
                                              : ObstacleMotion(AffineMotion(MapsOf(times, [&](double time) {
                                                  return PlacedPose(*obstacle.path, placement, time);
                                                })));
  }
  return motions;
}

ObstacleChange::ObstacleChange(const SceneObstacle& obstacle, const ObstacleMotion& motion, const Placement& placement,
                               PlacementPart part, const SolveTimes& times)
    : motion_(motion) {
  if (motion.surface() == nullptr) {
    maps_ = MapsOf(times, [&](double time) { return PlacedPoseChange(*obstacle.path, placement, part, time); });
    return;
  }
  faces_ = [=, sequence = obstacle.sequence](int face) {
    return MapsOf(times, [&](double time) { return sequence->FaceChange(face, placement, part, time); });
  };
}

MotionChange ObstacleChange::At(const Eigen::Vector3d& position, const Eigen::Vector3d& normal,
                                const Eigen::Matrix3d& normal_gradient) const {
  return motion_.surface() != nullptr ? motion_.surface()->Differentiate(faces_, position)
                                      : motion_.body().Differentiate(maps_, position, normal, normal_gradient);
}

}  // namespace clothid
