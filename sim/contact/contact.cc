#include "sim/contact/contact.h"

#include <algorithm>

#include "sim/cloth/cloth_model.h"

namespace clothid {
namespace {

struct NearestObstacle {
  double slope = 1.0;                      // of its gap
  const ObstacleMotion* motion = nullptr;  // null: it stands still
  int face = 0;                            // of one that deforms
};

// The obstacle with the smallest gap, and the geometry there.
NearestObstacle FindNearestObstacle(const Scene& scene, const Eigen::Vector3d& position,
                                    const std::vector<ObstacleMotion>& motions, ContactCandidate* candidate) {
  NearestObstacle nearest;
  for (size_t i = 0; i < scene.obstacles.size(); ++i) {
    const bool moves = !motions.empty() && motions[i].moves();
    const Obstacle& shape = *scene.obstacles[i].shape;
    const MovedSurfacePoint point =
        moves ? motions[i].Closest(shape, position) : MovedSurfacePoint{shape.Closest(position)};
    const double gap = point.surface.gap - scene.obstacles[i].contact_distance;
    if (i > 0 && gap >= candidate->gap) continue;
    candidate->obstacle = static_cast<int>(i);
    candidate->gap = gap;
    candidate->normal = point.surface.normal;
    candidate->normal_gradient = point.surface.normal_gradient;
    nearest = {point.slope, moves ? &motions[i] : nullptr, point.face};
  }
  return nearest;
}

}  // namespace

void FindCandidate(const ClothModel& model, int node, const Eigen::VectorXd& positions, double gap_time,
                   const std::vector<ObstacleMotion>& motions, ContactCandidate* candidate) {
  const Scene& scene = model.scene();
  const Eigen::Vector3d position = positions.segment<3>(3 * node);
  const NearestObstacle nearest = FindNearestObstacle(scene, position, motions, candidate);
  candidate->node = node;
  candidate->gap_speed = candidate->gap_speed_slope = 0.0;
  if (scene.contact_mode == ContactMode::kGap) {
    const double speed = candidate->gap / gap_time;
    const bool limited = speed < -scene.depenetration_speed;
    candidate->gap_speed = limited ? -scene.depenetration_speed : speed;
    candidate->gap_speed_slope = limited ? 0.0 : nearest.slope / gap_time;
  }
  candidate->target = -candidate->gap_speed * candidate->normal;
  candidate->least_speed = -candidate->gap_speed;
  if (nearest.motion == nullptr) return;
  const Eigen::Vector3d velocity = nearest.motion->VelocityAt(position, nearest.face);
  candidate->target += velocity;
  candidate->least_speed += candidate->normal.dot(velocity);
}

void FindCandidates(const ClothModel& model, const Eigen::VectorXd& positions, double gap_time,
                    const std::vector<ObstacleMotion>& motions, std::vector<ContactCandidate>* candidates) {
  const bool gap_mode = model.scene().contact_mode == ContactMode::kGap;
  candidates->resize(model.num_free());
  size_t num_candidates = 0;
  for (int node = 0; node < model.num_nodes(); ++node) {
    if (model.free_index()[node] < 0) continue;
    ContactCandidate& candidate = (*candidates)[num_candidates];
    FindCandidate(model, node, positions, gap_time, motions, &candidate);
    if (gap_mode || candidate.gap <= model.touch_gap()) ++num_candidates;
  }
  candidates->resize(num_candidates);
}

Eigen::Vector3d ObstacleGain(const std::vector<ObstacleMotion>& motions, int obstacle,
                             const Eigen::Vector3d& position) {
  if (motions.empty()) return Eigen::Vector3d::Zero();
  return motions[obstacle].Near(position).velocity_change().At(position);
}

Eigen::Matrix3d ContactPositionJacobian(const Contact& contact, const AffineMotion* motion) {
  const ContactCandidate& candidate = contact.candidate;
  const Eigen::Vector3d& n = candidate.normal;
  const Eigen::Matrix3d impulse_gradient = ImpulseForceJacobian(contact.response, n, contact.friction_coefficient);
  Eigen::Matrix3d jacobian = (-contact.weight * candidate.gap_speed_slope * (impulse_gradient * n)) * n.transpose();
  if (motion != nullptr) jacobian += contact.weight * (impulse_gradient * motion->velocity().gradient);
  if (candidate.normal_gradient.isZero(0.0)) return jacobian;  // flat: D = 0
  jacobian -= (contact.weight * candidate.gap_speed) * (impulse_gradient * candidate.normal_gradient) +
              ImpulsePositionJacobian(contact.response, contact.force, n, candidate.normal_gradient,
                                      contact.friction_coefficient);
  return jacobian;
}

Eigen::Vector3d ContactMotionDerivative(const Contact& contact, const MotionChange& change) {
  const ContactCandidate& candidate = contact.candidate;
  const Eigen::Vector3d& n = candidate.normal;
  const Eigen::Vector3d target =
      change.velocity - candidate.gap_speed_slope * change.distance * n - candidate.gap_speed * change.normal;
  const Eigen::Matrix3d normal_change = change.normal * Eigen::RowVector3d::UnitX();
  return -contact.weight * (ImpulseForceJacobian(contact.response, n, contact.friction_coefficient) * target) +
         ImpulsePositionJacobian(contact.response, contact.force, n, normal_change, contact.friction_coefficient)
             .col(0);
}

}  // namespace clothid
