#include "sim/contact/step_contacts.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "sim/cloth/cloth_model.h"
#include "sim/cloth/system_matrix.h"
#include "sim/contact/pair_thinning.h"

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

// Where the pair of `features` is, or the end.
std::vector<PairCandidate>::iterator FindPair(const PairFeatures& features, std::vector<PairCandidate>* pairs) {
  return std::find_if(pairs->begin(), pairs->end(),
                      [&](const PairCandidate& pair) { return pair.features == features; });
}

void Sort(std::vector<PairCandidate>* pairs) {
  std::sort(pairs->begin(), pairs->end(),
            [](const PairCandidate& a, const PairCandidate& b) { return a.features < b.features; });
}

double TangentialSpeed(const Eigen::Vector3d& velocity, const Eigen::Vector3d& normal) {
  return (velocity - normal.dot(velocity) * normal).norm();
}

}  // namespace

void StepContacts::Find(const ClothModel& model, const Start& start, std::vector<ObstacleMotion> motions) {
  free_index_ = &model.free_index();
  start_positions_ = &start.positions;
  weights_ = &start.weights;
  gap_time_ = start.gap_time;
  if (model.has_contact()) {
    motions_ = std::move(motions);
    FindCandidates(model, start.positions, gap_time_, motions_, &candidates_);
  }
  if (model.scene().self_contact) FindPairs(model, start);
}

void StepContacts::FindPairs(const ClothModel& model, const Start& start) {
  const Scene& scene = model.scene();
  thickness_ = scene.self_contact->thickness;
  if (search_ == nullptr) {
    search_ = std::make_unique<SelfContactSearch>(scene.mesh, thickness_);
    follow_order_ = FollowOrder(scene.mesh);
  }
  const double fall = scene.gravity.norm() * gap_time_ * gap_time_;
  search_->Find(start.positions, start.velocities, gap_time_, fall, &near_pairs_);
  pairs_.clear();
  for (const PairFeatures& features : near_pairs_) {
    PairCandidate pair =
        MakePairCandidate(features, start.positions, *free_index_, thickness_, gap_time_, scene.depenetration_speed);
    const auto& blocks = pair.blocks;
    if (*std::max_element(blocks.begin(), blocks.end()) < 0) continue;  // of handles alone: nothing can give way
    Eigen::Vector4d weights = Eigen::Vector4d::Zero();
    for (int i = 0; i < 4; ++i) {
      if (blocks[i] >= 0) weights[i] = (*weights_)[blocks[i]];
    }
    pair.SetNodes(start.handle_velocities, weights);
    pairs_.push_back(pair);
  }
  std::vector<bool> can_follow(model.num_nodes());
  for (int node = 0; node < model.num_nodes(); ++node) can_follow[node] = (*free_index_)[node] >= 0;
  for (const ContactCandidate& candidate : candidates_) {
    if (candidate.gap < kNearObstacle * thickness_) can_follow[candidate.node] = false;
  }
  Thin(can_follow, follow_order_, thickness_, &pairs_, &left_out_);
}

int StepContacts::free_block(int candidate) const { return (*free_index_)[candidates_[candidate].node]; }
double StepContacts::weight(int candidate) const { return (*weights_)[free_block(candidate)]; }

bool StepContacts::TakeBack(const Eigen::VectorXd& velocities) {
  const double least = kLeastPairDistance * thickness_;
  const auto is_needed = [&](const PairCandidate& pair) {
    const double approach = pair.geometry.normal.dot(pair.RelativeVelocity(velocities));
    return approach < 0.0 && pair.geometry.distance + gap_time_ * approach < least;
  };
  const std::size_t num_before = pairs_.size();
  for (const PairCandidate& pair : left_out_) {
    if (!is_needed(pair)) continue;
    pairs_.push_back(pair);
    pairs_.back().has_friction = false;
  }
  if (pairs_.size() == num_before) return false;
  left_out_.erase(std::remove_if(left_out_.begin(), left_out_.end(), is_needed), left_out_.end());
  Sort(&pairs_);
  return true;
}

bool StepContacts::Restore(const ContactSet& recorded, const Eigen::VectorXd& velocities, ContactPoint* point) {
  bool are_known = true;
  for (const PairContact& contact : recorded.pairs) {
    const PairCandidate& pair = contact.candidate;
    if (FindPair(pair.features, &pairs_) != pairs_.end()) {
      are_known = are_known && pair.has_friction;
      continue;
    }
    are_known = are_known && !pair.has_friction && FindPair(pair.features, &left_out_) != left_out_.end();
    pairs_.push_back(pair);
  }
  Sort(&pairs_);
  point->pairs.impulses.setZero(3, num_impulses());
  for (const PairContact& contact : recorded.pairs) {
    const auto pair = FindPair(contact.candidate.features, &pairs_);
    point->pairs.impulses.col(pair - pairs_.begin()) =
        pair->weight * (pair->RelativeVelocity(velocities) + pair->gap_speed * pair->geometry.normal) - contact.force;
  }
  return are_known;
}

Eigen::VectorXd StepContacts::Spread(const Eigen::Ref<const Eigen::VectorXd>& impulses) const {
  Eigen::VectorXd spread = Eigen::VectorXd::Zero(3 * weights_->size());
  for (std::size_t c = 0; c < pairs_.size(); ++c) {
    for (int i = 0; i < 4; ++i) {
      if (pairs_[c].blocks[i] < 0) continue;
      spread.segment<3>(3 * pairs_[c].blocks[i]) +=
          pairs_[c].geometry.weights[i] * impulses.segment<3>(3 * static_cast<Eigen::Index>(c));
    }
  }
  return spread;
}

void StepContacts::SubtractImpulses(const ContactPoint& point, Eigen::VectorXd* momentum_gradient) const {
  for (std::size_t c = 0; c < pairs_.size(); ++c) {
    const PairCandidate& pair = pairs_[c];
    for (int i = 0; i < 4; ++i) {
      if (pair.blocks[i] < 0) continue;
      momentum_gradient->segment<3>(3 * pair.blocks[i]) -=
          pair.geometry.weights[i] * point.pairs.impulses.col(static_cast<Eigen::Index>(c));
    }
  }
}

void StepContacts::ApplyLaw(const ContactFriction& friction, const Eigen::VectorXd& velocities,
                            const Eigen::VectorXd& momentum_gradient, ContactPoint* point,
                            Eigen::VectorXd* residual) const {
  *residual = momentum_gradient;
  if (may_touch()) {
    point->forces.resize(candidates_.size());
    point->responses.resize(candidates_.size());
  }
  for (std::size_t i = 0; i < candidates_.size(); ++i) {
    const ContactCandidate& candidate = candidates_[i];
    const int block = (*free_index_)[candidate.node], row = 3 * block;
    point->forces[i] =
        (*weights_)[block] * (velocities.segment<3>(row) - candidate.target) - momentum_gradient.segment<3>(row);
    point->responses[i] =
        EvaluateContactLaw(point->forces[i], candidate.normal, friction.obstacles[candidate.obstacle]);
    residual->segment<3>(row) -= point->responses[i].impulse;
  }
  ApplyPairLaw(friction, velocities, &point->pairs);
}

void StepContacts::ApplyPairLaw(const ContactFriction& friction, const Eigen::VectorXd& velocities,
                                PairPoint* point) const {
  const Eigen::Index num_pairs = num_impulses();
  point->residuals.resize(3, num_pairs);
  point->forces.resize(pairs_.size());
  point->responses.resize(pairs_.size());
  for (Eigen::Index c = 0; c < num_pairs; ++c) {
    const PairCandidate& pair = pairs_[c];
    const Eigen::Vector3d& n = pair.geometry.normal;
    const Eigen::Vector3d impulse = point->impulses.col(c);
    point->forces[c] = pair.weight * (pair.RelativeVelocity(velocities) + pair.gap_speed * n) - impulse;
    point->responses[c] = EvaluateContactLaw(point->forces[c], n, pair.FrictionOf(friction.self));
    point->residuals.col(c) = impulse - point->responses[c].impulse;
  }
}

double StepContacts::HeldPotential(const ContactFriction& friction, const ContactPoint& lagged,
                                   const Eigen::VectorXd& velocities) const {
  double potential = 0.0;
  for (std::size_t i = 0; i < candidates_.size(); ++i) {
    const double normal_impulse = std::max(0.0, -lagged.responses[i].normal_force);
    if (normal_impulse == 0.0) continue;
    const Eigen::Vector3d velocity = velocities.segment<3>(3 * free_block(static_cast<int>(i)));
    potential +=
        friction.obstacles[candidates_[i].obstacle] * normal_impulse * TangentialSpeed(velocity, candidates_[i].normal);
  }
  for (std::size_t c = 0; c < pairs_.size(); ++c) {
    const double normal_impulse = std::max(0.0, -lagged.pairs.responses[c].normal_force);
    if (normal_impulse == 0.0) continue;
    const Eigen::Vector3d &n = pairs_[c].geometry.normal, velocity = pairs_[c].RelativeVelocity(velocities);
    potential +=
        normal_impulse * (pairs_[c].FrictionOf(friction.self) * TangentialSpeed(velocity, n) - n.dot(velocity));
  }
  return potential;
}

void StepContacts::AddWeighedSquare(const ContactPoint& point, double* square) const {
  for (std::size_t c = 0; c < pairs_.size(); ++c) {
    *square += point.pairs.residuals.col(static_cast<Eigen::Index>(c)).squaredNorm() / pairs_[c].weight;
  }
}

void StepContacts::ClipToFeasible(Eigen::VectorXd* velocities) const {
  for (std::size_t i = 0; i < candidates_.size(); ++i) {
    const Eigen::Vector3d& n = candidates_[i].normal;
    auto v = velocities->segment<3>(3 * free_block(static_cast<int>(i)));
    v += std::max(0.0, candidates_[i].least_speed - n.dot(v)) * n;
  }
}

void StepContacts::Recall(const PairMemory& memory, double time_step, ContactPoint* point) const {
  point->pairs.impulses.setZero(3, num_impulses());
  for (std::size_t c = 0; c < pairs_.size(); ++c) {
    const auto found = memory.find(pairs_[c].features);
    if (found != memory.end()) point->pairs.impulses.col(static_cast<Eigen::Index>(c)) = time_step * found->second;
  }
}

void StepContacts::Remember(const ContactPoint& point, double time_step, PairMemory* memory) const {
  memory->clear();
  for (std::size_t c = 0; c < pairs_.size(); ++c) {
    if (point.pairs.responses[c].branch == ContactBranch::kTakeOff) continue;
    (*memory)[pairs_[c].features] = point.pairs.impulses.col(static_cast<Eigen::Index>(c)) / time_step;
  }
}

void StepContacts::ContactsAt(const ContactFriction& friction, const ContactPoint& point, ContactSet* contacts) const {
  contacts->nodes.clear();
  contacts->nodes.reserve(candidates_.size());
  for (std::size_t i = 0; i < candidates_.size(); ++i) {
    if (point.responses[i].branch == ContactBranch::kTakeOff) continue;
    const ContactCandidate& candidate = candidates_[i];
    contacts->nodes.push_back(
        {candidate, point.responses[i], point.forces[i], weight(static_cast<int>(i)),
         ObstacleGain(motions_, candidate.obstacle, start_positions_->segment<3>(3 * candidate.node)),
         friction.obstacles[candidate.obstacle]});
  }
  contacts->pairs.clear();
  for (std::size_t c = 0; c < pairs_.size(); ++c) {
    contacts->pairs.push_back(
        {pairs_[c], point.pairs.responses[c], point.pairs.forces[c], pairs_[c].FrictionOf(friction.self)});
  }
}

ContactSet RestoreContacts(const ContactRecords& records, const SolvedStep& step,
                           const std::vector<ObstacleMotion>& motions, const Parameters& parameters,
                           const ClothModel& model) {
  const Scene& scene = model.scene();
  const auto weight = [&](int node) { return SystemDiagonal(model, parameters.material, step.time_step, node); };
  ContactSet contacts;
  contacts.nodes.reserve(records.nodes.size());
  for (const ContactRecord& kept : records.nodes) {
    ContactCandidate candidate;
    FindCandidate(model, kept.node, step.start_positions, step.gap_time, motions, &candidate);
    const double mu = parameters.friction_coefficients[kept.obstacle];
    contacts.nodes.push_back(
        {candidate, EvaluateContactLaw(kept.force, candidate.normal, mu), kept.force, weight(kept.node),
         ObstacleGain(motions, candidate.obstacle, step.start_positions.segment<3>(3 * candidate.node)), mu});
  }
  for (const PairContactRecord& kept : records.pairs) {
    PairCandidate candidate =
        MakePairCandidate(kept.features, step.start_positions, model.free_index(), scene.self_contact->thickness,
                          step.gap_time, scene.depenetration_speed);
    Eigen::Vector4d weights = Eigen::Vector4d::Zero();
    for (int i = 0; i < kept.features.num_nodes(); ++i) weights[i] = weight(kept.features.nodes[i]);
    candidate.SetNodes(step.velocities, weights);
    candidate.has_friction = kept.has_friction;
    const double mu = candidate.FrictionOf(parameters.self_friction);
    contacts.pairs.push_back(
        {candidate, EvaluateContactLaw(kept.force, candidate.geometry.normal, mu), kept.force, mu});
  }
  return contacts;
}

}  // namespace clothid
