#include "sim/contact/contact.h"

#include <algorithm>

#include "sim/cloth/cloth_model.h"

namespace clothid {
namespace {

// The obstacle with the smallest gap, and the geometry there.
void FindNearestObstacle(const Scene& scene, const Eigen::Vector3d& position, ContactCandidate* nearest) {
  for (size_t i = 0; i < scene.obstacles.size(); ++i) {
    const SurfacePoint point = scene.obstacles[i].shape->Closest(position);
    const double gap = point.gap - scene.obstacles[i].contact_distance;
    if (i > 0 && gap >= nearest->gap) continue;
    nearest->obstacle = static_cast<int>(i);
    nearest->gap = gap;
    nearest->normal = point.normal;
    nearest->normal_gradient = point.normal_gradient;
  }
}

}  // namespace

void FindCandidate(const ClothModel& model, int node, const Eigen::VectorXd& positions, double gap_time,
                   ContactCandidate* candidate) {
  const Scene& scene = model.scene();
  FindNearestObstacle(scene, positions.segment<3>(3 * node), candidate);
  candidate->node = node;
  candidate->gap_speed = candidate->gap_speed_slope = 0.0;
  if (scene.contact_mode != ContactMode::kGap) return;
  const double speed = candidate->gap / gap_time;
  const bool limited = speed < -scene.depenetration_speed;
  candidate->gap_speed = limited ? -scene.depenetration_speed : speed;
  candidate->gap_speed_slope = limited ? 0.0 : 1.0 / gap_time;
}

void FindCandidates(const ClothModel& model, const Eigen::VectorXd& positions, double gap_time,
                    std::vector<ContactCandidate>* candidates) {
  const bool gap_mode = model.scene().contact_mode == ContactMode::kGap;
  candidates->resize(model.num_free());
  size_t num_candidates = 0;
  for (int node = 0; node < model.num_nodes(); ++node) {
    if (model.free_index()[node] < 0) continue;
    ContactCandidate& candidate = (*candidates)[num_candidates];
    FindCandidate(model, node, positions, gap_time, &candidate);
    if (gap_mode || candidate.gap <= model.touch_gap()) ++num_candidates;
  }
  candidates->resize(num_candidates);
}

Eigen::Matrix3d ContactPositionJacobian(const Contact& contact, double friction_coefficient) {
  const ContactCandidate& candidate = contact.candidate;
  const Eigen::Vector3d& n = candidate.normal;
  const Eigen::Matrix3d impulse_gradient = ImpulseForceJacobian(contact.response, n, friction_coefficient);
  Eigen::Matrix3d jacobian = (-contact.weight * candidate.gap_speed_slope * (impulse_gradient * n)) * n.transpose();
  if (candidate.normal_gradient.isZero(0.0)) return jacobian;  // flat: D = 0
  jacobian -=
      (contact.weight * candidate.gap_speed) * (impulse_gradient * candidate.normal_gradient) +
      ImpulsePositionJacobian(contact.response, contact.force, n, candidate.normal_gradient, friction_coefficient);
  return jacobian;
}

}  // namespace clothid
