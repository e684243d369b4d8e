#include "sim/derivative/correction_derivative.h"

#include "sim/cloth/cloth_model.h"
#include "sim/step/obstacle_motions.h"

namespace clothid {
namespace {

// (I - n n^T) y.
Eigen::MatrixXd Along(const Eigen::Vector3d& n, const Eigen::MatrixXd& columns) {
  return columns - n * (n.transpose() * columns);
}

}  // namespace

CorrectionDerivative::CorrectionDerivative(const Correction& correction, int step, const Eigen::VectorXd& start,
                                           const StepRecord& record, const Parameters& parameters,
                                           const std::vector<ParameterId>& ids, const ClothModel& model)
    : correction_(correction),
      step_(step),
      ends_{start, record.positions},
      record_(record),
      parameters_(parameters),
      model_(model) {
  const CorrectedState& corrected = *record.correction;
  if (corrected.limits.empty()) return;
  motions_ = ObstacleMotions(model.scene(), parameters, TimesAfter(record));
  const StateChange change = RequestedChange(correction, step, ends_, model, corrected.scale, corrected.groups);
  for (const CorrectionLimit& limit : corrected.limits) {
    LimitedNode node;
    node.limit = limit;
    node.point = ClosestOf(model, motions_, limit.obstacle, record.positions.segment<3>(3 * limit.node));
    node.change = change.positions.segment<3>(3 * limit.node);
    node.velocity_change = change.velocities.segment<3>(3 * limit.node);
    SetPlacement(ids, &node);
    nodes_.push_back(std::move(node));
  }
}

void CorrectionDerivative::SetPlacement(const std::vector<ParameterId>& ids, LimitedNode* node) const {
  for (std::size_t p = 0; p < ids.size(); ++p) {
    if (!IsPlacement(ids[p].kind) || ids[p].part != node->limit.obstacle) continue;
    if (node->normals.cols() == 0) {
      node->normals = Eigen::MatrixXd::Zero(3, static_cast<Eigen::Index>(ids.size()));
      node->distances = Eigen::RowVectorXd::Zero(static_cast<Eigen::Index>(ids.size()));
    }
    const int obstacle = node->limit.obstacle;
    const ObstacleChange change(model_.scene().obstacles[obstacle], motions_[obstacle], parameters_.placement(obstacle),
                                PlacementPartOf(ids[p]), TimesAfter(record_));
    const MotionChange motion =
        change.At(record_.positions.segment<3>(3 * node->limit.node), node->point.normal, node->point.normal_gradient);
    node->normals.col(static_cast<Eigen::Index>(p)) = motion.normal;
    node->distances[static_cast<Eigen::Index>(p)] = motion.distance;
  }
}

void CorrectionDerivative::Advance(const Eigen::MatrixXd& start_changes, const Eigen::MatrixXd& end_changes,
                                   StateColumns* tangent) const {
  Eigen::MatrixXd positions, velocities;
  correction_.Times(step_, ends_, start_changes, end_changes, &positions, &velocities);
  const CorrectedState& corrected = *record_.correction;
  for (Eigen::MatrixXd* part : {&positions, &velocities}) {
    *part *= corrected.scale;
    MoveTogether(corrected.groups, *part);
  }
  for (const LimitedNode& node : nodes_) AdvanceNode(node, positions, velocities, tangent);
  // What limited nodes have got already.
  for (const LimitedNode& node : nodes_) {
    positions.middleRows<3>(3 * node.limit.node).setZero();
    if (node.limit.touches) velocities.middleRows<3>(3 * node.limit.node).setZero();
  }
  tangent->positions += model_.GatherColumns(positions);
  tangent->velocities += model_.GatherColumns(velocities);
}

void CorrectionDerivative::AdvanceNode(const LimitedNode& node, const Eigen::MatrixXd& positions,
                                       const Eigen::MatrixXd& velocities, StateColumns* tangent) const {
  const Eigen::Vector3d& n = node.point.normal;
  const int row = 3 * model_.free_index()[node.limit.node];
  auto dx = tangent->positions.middleRows<3>(row);
  Eigen::MatrixXd normals = node.point.normal_gradient * dx;  // dn
  if (node.normals.cols() > 0) normals.leftCols(node.normals.cols()) += node.normals;
  Eigen::MatrixXd change = Along(n, positions.middleRows<3>(3 * node.limit.node));
  change -= (n.dot(node.change) + node.held_gap()) * normals + n * (node.change.transpose() * normals);
  if (node.limit.touches) {
    const Eigen::MatrixXd asked = velocities.middleRows<3>(3 * node.limit.node);
    tangent->velocities.middleRows<3>(row) +=
        Along(n, asked) - n.dot(node.velocity_change) * normals - n * (node.velocity_change.transpose() * normals);
  } else if (node.limit.is_outside) {
    Eigen::RowVectorXd gaps = n.transpose() * dx;  // dphi
    if (node.distances.size() > 0) gaps.head(node.distances.size()) += node.distances;
    change -= n * gaps;
  }
  dx += change;
}

void CorrectionDerivative::PullBack(StateColumns* lambda, Eigen::MatrixXd* by_start, Eigen::MatrixXd* by_end,
                                    Eigen::MatrixXd* gradient) const {
  Eigen::MatrixXd positions = model_.ScatterColumns(lambda->positions);
  Eigen::MatrixXd velocities = model_.ScatterColumns(lambda->velocities);
  for (const LimitedNode& node : nodes_) PullBackNode(node, &positions, &velocities, lambda, gradient);
  const CorrectedState& corrected = *record_.correction;
  for (Eigen::MatrixXd* part : {&positions, &velocities}) {
    MoveTogether(corrected.groups, *part);
    for (const int handle : model_.scene().handles.nodes) part->middleRows<3>(3 * handle).setZero();
    *part *= corrected.scale;
  }
  correction_.TimesTransposed(step_, ends_, positions, velocities, by_start, by_end);
}

void CorrectionDerivative::PullBackNode(const LimitedNode& node, Eigen::MatrixXd* positions,
                                        Eigen::MatrixXd* velocities, StateColumns* lambda,
                                        Eigen::MatrixXd* gradient) const {
  const Eigen::Vector3d& n = node.point.normal;
  const int row = 3 * model_.free_index()[node.limit.node];
  auto by_change = positions->middleRows<3>(3 * node.limit.node);
  const Eigen::MatrixXd by_position = by_change;
  Eigen::MatrixXd by_normal =
      -(n.dot(node.change) + node.held_gap()) * by_position - node.change * (n.transpose() * by_position);
  Eigen::RowVectorXd by_gap;
  by_change = Along(n, by_position);
  if (node.limit.touches) {
    auto by_velocity_change = velocities->middleRows<3>(3 * node.limit.node);
    const Eigen::MatrixXd by_velocity = by_velocity_change;
    by_normal -= n.dot(node.velocity_change) * by_velocity + node.velocity_change * (n.transpose() * by_velocity);
    by_velocity_change = Along(n, by_velocity);
  } else if (node.limit.is_outside) {
    by_gap = -n.transpose() * by_position;
  }
  lambda->positions.middleRows<3>(row) += node.point.normal_gradient.transpose() * by_normal;
  if (by_gap.size() > 0) lambda->positions.middleRows<3>(row) += n * by_gap;
  if (node.normals.cols() == 0) return;
  *gradient += node.normals.transpose() * by_normal;
  if (by_gap.size() > 0) *gradient += node.distances.transpose() * by_gap;
}

void CorrectionTangent::StartStep(int step, double time, const Eigen::VectorXd& positions,
                                  const StateColumns& tangent) {
  if (correction_ == nullptr || !correction_->Corrects(step)) return;
  start_ = positions;
  start_changes_ = AllRows(time, tangent);
}

bool CorrectionTangent::EndStep(int step, const StepRecord& record, StateColumns* tangent) const {
  if (record.correction == nullptr) return false;
  CorrectionDerivative(*correction_, step, start_, record, parameters_, ids_, model_)
      .Advance(start_changes_, AllRows(record.time, *tangent), tangent);
  return true;
}

Eigen::MatrixXd CorrectionTangent::AllRows(double time, const StateColumns& tangent) const {
  Eigen::MatrixXd all = model_.ScatterColumns(tangent.positions);
  handles_->SetRows(time, &all);
  return all;
}

}  // namespace clothid
