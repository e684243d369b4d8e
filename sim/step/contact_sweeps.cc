#include "sim/step/contact_sweeps.h"

#include <Eigen/LU>
#include <cmath>

#include "sim/contact/contact_law.h"
#include "sim/matrix/block_product.h"

namespace clothid {
namespace {

constexpr double kShare = 0.3;  // of the residual that a linear solve leaves: not worth a sweep
constexpr int kSweeps = 3;
constexpr int kMaxNodeIterations = 10;  // of Newton's method at one node
constexpr int kMaxNodeHalvings = 4;     // of the length of each of them
constexpr double kReduction = 0.1;      // of the residual of a node, at which it is done with

// F, see contact_law.h.
Eigen::Vector3d ContactForce(double weight, const ContactCandidate& candidate, const Eigen::Vector3d& velocity,
                             const Eigen::Vector3d& momentum) {
  return weight * (velocity - candidate.target) - momentum;
}

// The equation of one node while its neighbours are held.
class NodeEquation {
 public:
  // `stiffness`: K_ii.
  NodeEquation(const StepProblem& problem, int candidate, const Eigen::Matrix3d& stiffness)
      : weight_(problem.contacts().weight(candidate)),
        friction_coefficient_(problem.friction_coefficient(candidate)),
        candidate_(problem.contacts().candidates()[candidate]),
        stiffness_(stiffness) {}

  // A velocity, the momentum balance there and what the contact law makes of both.
  struct State {
    Eigen::Vector3d velocity, momentum;
    ContactResponse response;
    double residual = 0.0;  // |g_i - r_i|
  };
  State At(const Eigen::Vector3d& velocity, const Eigen::Vector3d& momentum) const {
    State state{velocity, momentum, {}, 0.0};
    state.response = EvaluateContactLaw(ContactForce(weight_, candidate_, velocity, momentum), candidate_.normal,
                                        friction_coefficient_);
    state.residual = (momentum - state.response.impulse).norm();
    return state;
  }

  // The solution, or the nearest to it that Newton's method with halved lengths has come.
  State Solve(State state) const {
    const double goal = kReduction * state.residual;
    for (int iteration = 0; iteration < kMaxNodeIterations && state.residual > goal; ++iteration) {
      if (!Improve(&state)) break;
    }
    return state;
  }

 private:
  bool Improve(State* state) const {
    const Eigen::Matrix3d slope = ImpulseForceJacobian(state->response, candidate_.normal, friction_coefficient_);
    const Eigen::Matrix3d jacobian = stiffness_ + slope * (stiffness_ - weight_ * Eigen::Matrix3d::Identity());
    Eigen::Vector3d change = jacobian.partialPivLu().solve(state->response.impulse - state->momentum);
    for (int halving = 0; halving <= kMaxNodeHalvings; ++halving, change *= 0.5) {
      const State next = At(state->velocity + change, state->momentum + stiffness_ * change);
      if (next.residual < state->residual) {
        *state = next;
        return true;
      }
    }
    return false;
  }

  double weight_, friction_coefficient_;
  const ContactCandidate& candidate_;
  Eigen::Matrix3d stiffness_;
};

}  // namespace

double ContactSweeps::Start(const StepProblem& problem, const BlockMatrix& hessian, const StepPoint& point,
                            const Eigen::VectorXd& direction, const Eigen::VectorXd* other_impulse) {
  velocities_ = point.velocities + direction;
  MultiplySymmetric(hessian, direction, &momentum_);
  momentum_ += point.momentum_gradient;
  if (other_impulse != nullptr) momentum_.col(0) -= *other_impulse;
  candidates_.clear();
  double square = 0.0;
  for (size_t i = 0; i < problem.contacts().candidates().size(); ++i) {
    const int index = static_cast<int>(i), row = 3 * problem.contacts().free_block(index);
    const ContactCandidate& candidate = problem.contacts().candidates()[i];
    const Eigen::Vector3d momentum = momentum_.col(0).segment<3>(row);
    const ContactResponse response = EvaluateContactLaw(
        ContactForce(problem.contacts().weight(index), candidate, velocities_.segment<3>(row), momentum),
        candidate.normal, problem.friction_coefficient(index));
    if (response.branch == ContactBranch::kTakeOff && point.responses[i].branch == ContactBranch::kTakeOff) continue;
    candidates_.push_back(index);
    square += (momentum - response.impulse).squaredNorm();
  }
  return std::sqrt(square);
}

void ContactSweeps::Move(const BlockMatrix& hessian, int block, const Eigen::Vector3d& change) {
  const BlockPattern& pattern = hessian.pattern();
  velocities_.segment<3>(3 * block) += change;
  const int* const rows = pattern.rows_begin(block);
  for (int k = 0; k < pattern.num_rows(block); ++k) {
    momentum_.col(0).segment<3>(3 * rows[k]) += hessian.block(pattern.Position(block, k)) * change;
  }
}

bool ContactSweeps::Correct(const StepProblem& problem, const BlockMatrix& hessian, const StepPoint& point,
                            double tolerance, Eigen::VectorXd* direction, const Eigen::VectorXd* other_impulse) {
  const double goal = kShare * tolerance * point.residual.norm();
  if (Start(problem, hessian, point, *direction, other_impulse) <= goal) return false;
  // What is left where every node has its share of the goal.
  const double node_goal = goal / std::sqrt(static_cast<double>(candidates_.size()));
  for (int sweep = 0; sweep < kSweeps; ++sweep) {
    for (const int candidate : candidates_) {
      const int block = problem.contacts().free_block(candidate), row = 3 * block;
      const NodeEquation equation(problem, candidate, hessian.block(hessian.pattern().Diagonal(block)));
      const NodeEquation::State start = equation.At(velocities_.segment<3>(row), momentum_.col(0).segment<3>(row));
      if (start.residual <= node_goal) continue;
      const NodeEquation::State end = equation.Solve(start);
      if (end.residual < start.residual) Move(hessian, block, end.velocity - start.velocity);
    }
  }
  *direction = velocities_ - point.velocities;
  return true;
}

}  // namespace clothid
