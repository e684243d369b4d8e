#include "sim/contact.h"

#include <algorithm>

#include "sim/cloth_model.h"

namespace clothid {
namespace {

// The obstacle with the smallest gap, and the geometry there.
ContactCandidate NearestObstacle(const Scene& scene, const Eigen::Vector3d& position) {
  ContactCandidate nearest;
  for (size_t i = 0; i < scene.obstacles.size(); ++i) {
    const SurfacePoint point = scene.obstacles[i].shape->Closest(position);
    const double gap = point.gap - scene.obstacles[i].contact_distance;
    if (i > 0 && gap >= nearest.gap) continue;
    nearest.obstacle = static_cast<int>(i);
    nearest.gap = gap;
    nearest.normal = point.normal;
    nearest.normal_gradient = point.normal_gradient;
  }
  return nearest;
}

}  // namespace

ContactCandidate MakeCandidate(const ClothModel& model, int node, const Eigen::VectorXd& positions, double time_step) {
  const Scene& scene = model.scene();
  ContactCandidate candidate = NearestObstacle(scene, positions.segment<3>(3 * node));
  candidate.node = node;
  if (scene.contact_mode == ContactMode::kGap) {
    const double speed = candidate.gap / time_step;
    const bool limited = speed < -scene.depenetration_speed;
    candidate.gap_speed = limited ? -scene.depenetration_speed : speed;
    candidate.gap_speed_slope = limited ? 0.0 : 1.0 / time_step;
  }
  return candidate;
}

void FindCandidates(const ClothModel& model, const Eigen::VectorXd& positions, double time_step,
                    std::vector<ContactCandidate>* candidates) {
  const bool gap_mode = model.scene().contact_mode == ContactMode::kGap;
  candidates->clear();
  for (int node = 0; node < model.num_nodes(); ++node) {
    if (model.free_index()[node] < 0) continue;
    const ContactCandidate candidate = MakeCandidate(model, node, positions, time_step);
    if (gap_mode || candidate.gap <= model.touch_gap()) candidates->push_back(candidate);
  }
}

Eigen::Matrix3d ContactPositionJacobian(const Contact& contact, double friction_coefficient) {
  const ContactCandidate& candidate = contact.candidate;
  const Eigen::Vector3d& n = candidate.normal;
  const Eigen::Matrix3d force_gradient = contact.weight * (candidate.gap_speed_slope * n * n.transpose() +
                                                           candidate.gap_speed * candidate.normal_gradient);
  return -ImpulsePositionJacobian(contact.response, contact.force, n, candidate.normal_gradient, friction_coefficient) -
         ImpulseForceJacobian(contact.response, n, friction_coefficient) * force_gradient;
}

}  // namespace clothid
