#include "sim/derivative/second_start_derivative.h"

#include <algorithm>
#include <utility>

#include "sim/step/second_start.h"

namespace clothid {
namespace {

// The rows of the nodes of a contact in columns over some of all nodes, of which they have the numbers `places`, -1:
// none, whose rows are zero; and the sum into such columns.
template <std::size_t kNodes>
using NodeColumns = Eigen::Matrix<double, 3 * static_cast<int>(kNodes), Eigen::Dynamic>;

template <std::size_t kNodes>
NodeColumns<kNodes> GatherNodes(const std::array<int, kNodes>& places, const Eigen::MatrixXd& columns) {
  NodeColumns<kNodes> values = NodeColumns<kNodes>::Zero(3 * kNodes, columns.cols());
  for (std::size_t i = 0; i < kNodes; ++i) {
    if (places[i] >= 0) values.template middleRows<3>(3 * i) = columns.middleRows<3>(3 * places[i]);
  }
  return values;
}

template <std::size_t kNodes, class Values>
void ScatterNodes(const std::array<int, kNodes>& places, const Values& of_nodes, Eigen::MatrixXd* columns) {
  const NodeColumns<kNodes> values = of_nodes;
  for (std::size_t i = 0; i < kNodes; ++i) {
    if (places[i] >= 0) columns->middleRows<3>(3 * places[i]) += values.template middleRows<3>(3 * i);
  }
}

// A number of every node [N], of those of a contact.
template <std::size_t kNodes>
Eigen::Matrix<double, kNodes, 1> OfNodes(const std::array<int, kNodes>& nodes, const Eigen::VectorXd& values) {
  Eigen::Matrix<double, kNodes, 1> result = Eigen::Matrix<double, kNodes, 1>::Zero();
  for (std::size_t i = 0; i < kNodes; ++i) {
    if (nodes[i] >= 0) result[i] = values[nodes[i]];
  }
  return result;
}

// -1: it is not among them.
std::array<int, 4> PlacesAmong(const std::vector<int>& handles, const std::array<int, 4>& nodes) {
  std::array<int, 4> places = {-1, -1, -1, -1};
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    const auto found = std::find(handles.begin(), handles.end(), nodes[i]);
    if (found != handles.end()) places[i] = static_cast<int>(found - handles.begin());
  }
  return places;
}

template <class Derivative>
Derivative Carried(Derivative derivative) {
  derivative.change *= kSecondStageReach;
  derivative.impulse *= kSecondStageReach;
  derivative.position *= kSecondStageReach;
  derivative.masses *= kSecondStageReach;
  return derivative;
}

// Those of an impact among the impulses of a solve: of an obstacle's its node's, of the cloth's its own.
template <class Impact, class Columns>
auto ImpulseRows(const Impact& impact, Columns* impulses) {
  const bool has_own = impact.nodes.size() > 1;
  return (has_own ? impulses->impulses : impulses->velocities)
      .template middleRows<3>(3 * (has_own ? static_cast<Eigen::Index>(impact.contact) : impact.blocks[0]));
}

}  // namespace

SecondStartDerivative::SecondStartDerivative(const StepRecord& first, const SolveStart& start,
                                             const StepDerivative& step, const Parameters& parameters,
                                             const ClothModel& model)
    : num_impulses_(step.num_impulses()), num_rows_(3 * model.num_free()) {
  const ContactSet& contacts = step.contacts();
  const SolveMotion motion{model, parameters.material, start.velocities, first.velocities};
  for (std::size_t i = 0; i < contacts.nodes.size(); ++i) {
    const Contact& contact = contacts.nodes[i];
    const int node = contact.candidate.node;
    const double mass = model.mass(parameters.material, node);
    const Eigen::Vector3d change = motion.ChangeOf(node);
    if (ImpactShare(contact, mass, change) == 0.0) continue;
    impacts_.push_back({{node},
                        {model.free_index()[node]},
                        {-1},
                        i,
                        Carried(DifferentiateImpact(contact, mass, change, step.motion_of(contact)))});
    impacts_.back().derivative.normal *= kSecondStageReach;
  }
  for (ClothImpactDerivative& impact : DifferentiateClothImpacts(contacts, motion, start.positions)) {
    cloth_impacts_.push_back({impact.nodes, impact.blocks, PlacesAmong(model.scene().handles.nodes, impact.nodes),
                              impact.contact, Carried(std::move(impact.derivative))});
  }
}

bool SecondStartDerivative::reaches_handles() const {
  return std::any_of(cloth_impacts_.begin(), cloth_impacts_.end(), [](const ClothImpact& impact) {
    return std::any_of(impact.handles.begin(), impact.handles.end(), [](int handle) { return handle >= 0; });
  });
}

StateColumns SecondStartDerivative::Times(const StateColumns& start, const StateColumns& first) const {
  return {start.positions + kSecondStageReach * (first.positions - start.positions),
          start.velocities + kSecondStageReach * (first.velocities - start.velocities)};
}

void SecondStartDerivative::SubtractImpacts(const StateColumns& start, const StateColumns& first,
                                            const StepColumns& impulses, StateColumns* second) const {
  ForEach([&](const auto& impact) {
    const auto gather = [&](const Eigen::MatrixXd& columns) { return GatherNodes(impact.blocks, columns); };
    const auto& derivative = impact.derivative;
    ScatterNodes(impact.blocks,
                 -(derivative.change * (gather(first.velocities) - gather(start.velocities)) +
                   derivative.impulse * ImpulseRows(impact, &impulses) + derivative.position * gather(start.positions)),
                 &second->velocities);
  });
}

void SecondStartDerivative::SubtractHandleImpacts(const Eigen::MatrixXd& positions, const Eigen::MatrixXd& changes,
                                                  Eigen::MatrixXd* velocities) const {
  Eigen::MatrixXd sum = Eigen::MatrixXd::Zero(velocities->rows(), positions.cols());
  for (const ClothImpact& impact : cloth_impacts_) {
    ScatterNodes(impact.blocks,
                 impact.derivative.position * GatherNodes(impact.handles, positions) +
                     impact.derivative.change * GatherNodes(impact.handles, changes),
                 &sum);
  }
  velocities->rightCols(sum.cols()) -= sum;
}

void SecondStartDerivative::AddHandleImpactsTransposed(const StateColumns& second, Eigen::MatrixXd* positions,
                                                       Eigen::MatrixXd* changes) const {
  for (const ClothImpact& impact : cloth_impacts_) {
    const Eigen::MatrixXd rows = -GatherNodes(impact.blocks, second.velocities);
    ScatterNodes(impact.handles, impact.derivative.position.transpose() * rows, positions);
    ScatterNodes(impact.handles, impact.derivative.change.transpose() * rows, changes);
  }
}

void SecondStartDerivative::SubtractMasses(int column, const Eigen::VectorXd& masses, StateColumns* second) const {
  ForEach([&](const auto& impact) {
    const auto change = (impact.derivative.masses * OfNodes(impact.nodes, masses)).eval();
    for (std::size_t i = 0; i < impact.blocks.size(); ++i) {
      if (impact.blocks[i] < 0) continue;
      second->velocities.col(column).segment<3>(3 * impact.blocks[i]) -= change.template segment<3>(3 * i);
    }
  });
}

void SecondStartDerivative::AddTransposed(const StateColumns& second, StateColumns* start, StateColumns* first) const {
  start->positions += (1.0 - kSecondStageReach) * second.positions;
  start->velocities += (1.0 - kSecondStageReach) * second.velocities;
  first->positions += kSecondStageReach * second.positions;
  first->velocities += kSecondStageReach * second.velocities;
}

StepColumns SecondStartDerivative::AddImpactsTransposed(const StateColumns& second, StateColumns* start,
                                                        StateColumns* first) const {
  const Eigen::Index num_columns = second.velocities.cols();
  StepColumns impulses{Eigen::MatrixXd::Zero(num_rows_, num_columns),
                       Eigen::MatrixXd::Zero(num_impulses_, num_columns)};
  ForEach([&](const auto& impact) {
    const Eigen::MatrixXd rows = GatherNodes(impact.blocks, second.velocities);
    const Eigen::MatrixXd by_change = impact.derivative.change.transpose() * rows;
    ScatterNodes(impact.blocks, -by_change, &first->velocities);
    ScatterNodes(impact.blocks, by_change, &start->velocities);
    ScatterNodes(impact.blocks, -(impact.derivative.position.transpose() * rows), &start->positions);
    ImpulseRows(impact, &impulses) = -(impact.derivative.impulse.transpose() * rows);
  });
  return impulses;
}

Eigen::VectorXd SecondStartDerivative::MotionDerivative(const std::vector<MotionChange>& changes) const {
  Eigen::VectorXd derivative = Eigen::VectorXd::Zero(num_rows_);
  for (const ObstacleImpact& impact : impacts_) {
    const MotionChange& change = changes[impact.contact];
    derivative.segment<3>(3 * impact.blocks[0]) =
        impact.derivative.normal * change.normal - impact.derivative.change * change.velocity_change;
  }
  return derivative;
}

Eigen::RowVectorXd SecondStartDerivative::MassGradient(const Eigen::VectorXd& slopes,
                                                       const StateColumns& second) const {
  Eigen::RowVectorXd gradient = Eigen::RowVectorXd::Zero(second.velocities.cols());
  ForEach([&](const auto& impact) {
    const Eigen::MatrixXd by_masses =
        impact.derivative.masses.transpose() * GatherNodes(impact.blocks, second.velocities);
    gradient -= OfNodes(impact.nodes, slopes).transpose() * by_masses;
  });
  return gradient;
}

void SecondStartDerivative::AddMassGradient(const StateColumns& second, Eigen::MatrixXd* gradient) const {
  ForEach([&](const auto& impact) {
    const Eigen::MatrixXd by_masses =
        impact.derivative.masses.transpose() * GatherNodes(impact.blocks, second.velocities);
    for (std::size_t i = 0; i < impact.nodes.size(); ++i) {
      if (impact.nodes[i] >= 0) gradient->row(impact.nodes[i]) -= by_masses.row(i);
    }
  });
}

}  // namespace clothid
