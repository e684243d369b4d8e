// What the contacts of a cloth with itself are in the equations of a step.
#include <algorithm>
#include <cmath>

#include "sim/contact/pair_thinning.h"
#include "sim/step/step_problem.h"

namespace clothid {
namespace {

// Pairs whose gaps differ by less than this share of the thickness are equally near.
constexpr double kTie = 0.5;
// Nodes nearer to an obstacle than this share of the thickness are likely to stick to it.
constexpr double kNearObstacle = 0.25;

// Leaves those of `pairs` that thinning accepts, in their order, and puts the others into `left_out`.
void Thin(const std::vector<bool>& can_follow, const std::vector<int>& follow_order, double thickness,
          std::vector<PairCandidate>* pairs, std::vector<PairCandidate>* left_out) {
  std::vector<ThinningPair> all;
  all.reserve(pairs->size());
  for (const PairCandidate& pair : *pairs) all.push_back({pair.features, pair.geometry, pair.gap});
  std::vector<bool> is_kept(pairs->size(), false);
  for (const AcceptedPair& accepted : ThinPairs(all, can_follow, kTie * thickness, follow_order).accepted) {
    is_kept[accepted.pair] = true;
  }
  left_out->clear();
  std::size_t num_kept = 0;
  for (std::size_t c = 0; c < pairs->size(); ++c) {
    if (is_kept[c]) {
      std::swap((*pairs)[num_kept++], (*pairs)[c]);
    } else {
      left_out->push_back((*pairs)[c]);
    }
  }
  pairs->resize(num_kept);
}

}  // namespace

void StepProblem::FindPairs(const SolveStart& start, double gap_time) {
  const Scene& scene = model_.scene();
  const double thickness = scene.self_contact->thickness;
  if (work_.search == nullptr) {
    work_.search = std::make_unique<SelfContactSearch>(scene.mesh, thickness);
    work_.follow_order = FollowOrder(scene.mesh);
  }
  const double fall = scene.gravity.norm() * gap_time * gap_time;
  work_.search->Find(start.positions, start.velocities, gap_time, fall, &work_.near_pairs);
  Eigen::VectorXd ends = start.positions;
  PlaceHandles(&ends);
  const Eigen::VectorXd held = (ends - start.positions) / time_step_;
  work_.pairs.clear();
  for (const PairFeatures& features : work_.near_pairs) {
    PairCandidate pair = MakePairCandidate(features, start.positions, model_.free_index(), thickness, gap_time,
                                           scene.depenetration_speed);
    const auto& blocks = pair.blocks;
    if (*std::max_element(blocks.begin(), blocks.end()) < 0) continue;  // of handles alone: nothing can give way
    Eigen::Vector4d weights = Eigen::Vector4d::Zero();
    for (int i = 0; i < 4; ++i) {
      if (blocks[i] >= 0) weights[i] = work_.weights[blocks[i]];
    }
    pair.SetNodes(held, weights);
    work_.pairs.push_back(pair);
  }
  std::vector<bool> can_follow(model_.num_nodes());
  for (int node = 0; node < model_.num_nodes(); ++node) can_follow[node] = model_.free_index()[node] >= 0;
  for (const ContactCandidate& candidate : work_.candidates) {
    if (candidate.gap < kNearObstacle * thickness) can_follow[candidate.node] = false;
  }
  Thin(can_follow, work_.follow_order, thickness, &work_.pairs, &work_.left_out);
}

bool StepProblem::TakeBackPairs(const StepPoint& point) {
  const double least = kLeastPairDistance * model_.scene().self_contact->thickness;
  const auto is_needed = [&](const PairCandidate& pair) {
    const double approach = pair.geometry.normal.dot(pair.RelativeVelocity(point.velocities));
    return approach < 0.0 && pair.geometry.distance + gap_time_ * approach < least;
  };
  const std::size_t num_before = work_.pairs.size();
  for (const PairCandidate& pair : work_.left_out) {
    if (!is_needed(pair)) continue;
    work_.pairs.push_back(pair);
    work_.pairs.back().has_friction = false;
  }
  if (work_.pairs.size() == num_before) return false;
  work_.left_out.erase(std::remove_if(work_.left_out.begin(), work_.left_out.end(), is_needed), work_.left_out.end());
  std::sort(work_.pairs.begin(), work_.pairs.end(),
            [](const PairCandidate& a, const PairCandidate& b) { return a.features < b.features; });
  return true;
}

void StepProblem::AddPairImpulses(StepPoint* point) const {
  for (std::size_t c = 0; c < work_.pairs.size(); ++c) {
    const PairCandidate& pair = work_.pairs[c];
    for (int i = 0; i < 4; ++i) {
      if (pair.blocks[i] < 0) continue;
      point->momentum_gradient.segment<3>(3 * pair.blocks[i]) -=
          pair.geometry.weights[i] * point->pairs.impulses.col(static_cast<Eigen::Index>(c));
    }
  }
}

void StepProblem::ApplyPairLaw(StepPoint* point) const {
  const Eigen::Index num_pairs = static_cast<Eigen::Index>(work_.pairs.size());
  point->pairs.residuals.resize(3, num_pairs);
  point->pairs.forces.resize(work_.pairs.size());
  point->pairs.responses.resize(work_.pairs.size());
  for (Eigen::Index c = 0; c < num_pairs; ++c) {
    const PairCandidate& pair = work_.pairs[c];
    const Eigen::Vector3d& n = pair.geometry.normal;
    const Eigen::Vector3d impulse = point->pairs.impulses.col(c);
    point->pairs.forces[c] = pair.weight * (pair.RelativeVelocity(point->velocities) + pair.gap_speed * n) - impulse;
    point->pairs.responses[c] = EvaluateContactLaw(point->pairs.forces[c], n, pair.FrictionOf(self_friction()));
    point->pairs.residuals.col(c) = impulse - point->pairs.responses[c].impulse;
  }
}

}  // namespace clothid
