#include "sim/rollout/correction.h"

#include <algorithm>
#include <numeric>

#include "sim/cloth/cloth_model.h"
#include "sim/contact/contact.h"
#include "sim/rollout/step_record.h"
#include "sim/step/obstacle_motions.h"

namespace clothid {
namespace {

// Sets of nodes that grow together.
class NodeSets {
 public:
  explicit NodeSets(int num_nodes) : parent_(num_nodes) { std::iota(parent_.begin(), parent_.end(), 0); }

  int Find(int node) {
    while (parent_[node] != node) node = parent_[node] = parent_[parent_[node]];
    return node;
  }
  // The smallest node of a set stands for it.
  void Join(int one, int other) {
    const auto [low, high] = std::minmax({Find(one), Find(other)});
    parent_[high] = low;
  }

 private:
  std::vector<int> parent_;
};

std::vector<CorrectionGroup> GroupsOf(const StepRecord& record, const ClothModel& model) {
  const std::vector<std::array<int, 4>> touching = record.contacts.TouchingNodes();
  if (touching.empty()) return {};
  const int num_nodes = model.num_nodes();
  NodeSets sets(num_nodes);
  std::vector<char> touches(num_nodes, 0), stays(num_nodes, 0);
  for (const std::array<int, 4>& nodes : touching) {
    for (const int node : nodes) {
      if (node < 0) continue;
      touches[node] = 1;
      sets.Join(nodes[0], node);
    }
  }
  for (const ContactRecord& contact : record.contacts.nodes) stays[contact.node] = 1;
  for (const int handle : model.scene().handles.nodes) stays[handle] = 1;
  std::vector<CorrectionGroup> groups;
  std::vector<int> place(num_nodes, -1);  // by what stands for the set
  for (int node = 0; node < num_nodes; ++node) {
    if (!touches[node]) continue;
    int& group = place[sets.Find(node)];
    if (group < 0) {
      group = static_cast<int>(groups.size());
      groups.emplace_back();
    }
    groups[group].nodes.push_back(node);
    if (stays[node]) groups[group].moves = false;
  }
  return groups;
}

// What obstacles leave of the change of a node, and how; nothing to do where none is near.
void Limit(const CorrectionLimit& limit, const SurfacePoint& point, StateChange* change) {
  const Eigen::Vector3d& n = point.normal;
  auto d = change->positions.segment<3>(3 * limit.node);
  d -= n * n.dot(d);
  if (!limit.touches) {
    if (limit.is_outside) d -= point.gap * n;
    return;
  }
  auto dv = change->velocities.segment<3>(3 * limit.node);
  dv -= n * n.dot(dv);
}

// Limits the changes of free nodes, and says which.
std::vector<CorrectionLimit> LimitByObstacles(const StepRecord& record, const Parameters& parameters,
                                              const ClothModel& model, StateChange* change) {
  std::vector<CorrectionLimit> limits;
  if (!model.has_contact()) return limits;
  const std::vector<ObstacleMotion> motions = ObstacleMotions(model.scene(), parameters, TimesAfter(record));
  const std::vector<ContactRecord>& contacts = record.contacts.nodes;
  std::size_t next = 0;  // contacts ascend
  for (int node = 0; node < model.num_nodes(); ++node) {
    if (model.free_index()[node] < 0) continue;
    while (next < contacts.size() && contacts[next].node < node) ++next;
    CorrectionLimit limit;
    limit.node = node;
    limit.touches = next < contacts.size() && contacts[next].node == node;
    if (limit.touches) {
      limit.obstacle = contacts[next].obstacle;
    } else {
      ContactCandidate candidate;
      FindCandidate(model, node, record.positions, /*gap_time=*/1.0, motions, &candidate);
      const double normal_change = candidate.normal.dot(change->positions.segment<3>(3 * node));
      if (!(normal_change < -std::max(candidate.gap, 0.0))) continue;
      limit.obstacle = candidate.obstacle;
      limit.is_outside = candidate.gap > 0.0;
    }
    Limit(limit, ClosestOf(model, motions, limit.obstacle, record.positions.segment<3>(3 * node)), change);
    limits.push_back(limit);
  }
  return limits;
}

}  // namespace

SolveTimes TimesAfter(const StepRecord& record) { return {record.time_step, record.time + record.time_step}; }

SurfacePoint ClosestOf(const ClothModel& model, const std::vector<ObstacleMotion>& motions, int index,
                       const Eigen::Vector3d& position) {
  const SceneObstacle& obstacle = model.scene().obstacles[index];
  const bool moves = !motions.empty() && motions[index].moves();
  SurfacePoint point =
      moves ? motions[index].Closest(*obstacle.shape, position).surface : obstacle.shape->Closest(position);
  point.gap -= obstacle.contact_distance;
  return point;
}

void MoveTogether(const std::vector<CorrectionGroup>& groups, Eigen::Ref<Eigen::MatrixXd> columns) {
  for (const CorrectionGroup& group : groups) {
    Eigen::MatrixXd mean = Eigen::MatrixXd::Zero(3, columns.cols());
    if (group.moves) {
      for (const int node : group.nodes) mean += columns.middleRows<3>(3 * node);
      mean /= static_cast<double>(group.nodes.size());
    }
    for (const int node : group.nodes) columns.middleRows<3>(3 * node) = mean;
  }
}

StateChange RequestedChange(const Correction& correction, int step, const StepEnds& ends, const ClothModel& model,
                            double scale, const std::vector<CorrectionGroup>& groups) {
  StateChange change;
  correction.Evaluate(step, ends, &change.positions, &change.velocities);
  for (Eigen::VectorXd* part : {&change.positions, &change.velocities}) {
    *part *= scale;
    for (const int handle : model.scene().handles.nodes) part->segment<3>(3 * handle).setZero();
    MoveTogether(groups, *part);
  }
  return change;
}

CorrectedState CorrectState(const Correction& correction, int step, const Eigen::VectorXd& start,
                            const StepRecord& record, const Parameters& parameters, const ClothModel& model,
                            double scale) {
  CorrectedState state;
  state.scale = scale;
  state.groups = GroupsOf(record, model);
  StateChange change = RequestedChange(correction, step, {start, record.positions}, model, scale, state.groups);
  state.limits = LimitByObstacles(record, parameters, model, &change);
  state.positions = record.positions + change.positions;
  state.velocities = record.velocities + change.velocities;
  return state;
}

}  // namespace clothid
