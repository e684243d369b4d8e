#include "sim/derivative/adjoint_iteration.h"

#include <algorithm>

#include "sim/matrix/block_product.h"

namespace clothid {
namespace {

// A relative residual above this has diverged: an error that decays in the end grows far less on its way.
constexpr double kDiverged = 1e3;

// S^T of `contact` for d = `mass` in place of its own d. The branch is that of the step. `velocity` is v at the node.
Eigen::Matrix3d ImpulseTransposed(const Contact& contact, const Eigen::Vector3d& velocity, double mass) {
  const double mu = contact.friction_coefficient;
  ContactResponse response = contact.response;
  if (response.branch == ContactBranch::kSlip) {
    const double slip_speed = response.slip_direction.dot(velocity);
    // The law says |f_T| >= -mu f_N of a slipping node; rounding must not make 1 + c negative.
    response.tangential_force =
        std::max(response.tangential_force + (mass - contact.weight) * slip_speed, -mu * response.normal_force);
  }
  return ImpulseForceJacobian(response, contact.candidate.normal, mu).transpose();
}

}  // namespace

AdjointSystem::AdjointSystem(const ClothModel& model, const std::vector<Contact>& contacts,
                             const Eigen::VectorXd& velocities, const Parameters& parameters,
                             const BlockMatrix& hessian)
    : hessian_(hessian) {
  for (const Contact& contact : contacts) {
    const int node = contact.candidate.node;
    const double mass = model.mass(parameters.material, node);
    nodes_.push_back({3 * model.free_index()[node], ImpulseTransposed(contact, velocities.segment<3>(3 * node), mass),
                      mass, contact.weight});
  }
}

Eigen::MatrixXd AdjointSystem::AddImpulseTransposed(const Eigen::MatrixXd& z) const {
  Eigen::MatrixXd y = z;
  for (Eigen::Index c = 0; c < z.cols(); ++c) {
    for (const Node& node : nodes_) {
      y.col(c).segment<3>(node.row) += node.impulse_transposed * z.col(c).segment<3>(node.row);
    }
  }
  return y;
}

Eigen::MatrixXd AdjointSystem::Multiply(const Eigen::MatrixXd& z) const {
  if (nodes_.empty()) return MultiplySymmetric(hessian_, z);
  const Eigen::MatrixXd y = AddImpulseTransposed(z);
  Eigen::MatrixXd product = MultiplySymmetric(hessian_, y);
  for (Eigen::Index c = 0; c < z.cols(); ++c) {
    for (const Node& node : nodes_) {
      product.col(c).segment<3>(node.row) -=
          node.mass * (y.col(c).segment<3>(node.row) - z.col(c).segment<3>(node.row));
    }
  }
  return product;
}

void AdjointSystem::Finish(Eigen::MatrixXd* z, Eigen::MatrixXd* y) const {
  *y = AddImpulseTransposed(*z);
  for (Eigen::Index c = 0; c < z->cols(); ++c) {
    for (const Node& node : nodes_) {
      const Eigen::Vector3d end = y->col(c).segment<3>(node.row);
      z->col(c).segment<3>(node.row) = end - node.mass / node.weight * (end - z->col(c).segment<3>(node.row));
    }
  }
}

IterationResult IterateFixedPoint(const LinearMap& multiply, const LinearMap& precondition,
                                  const Eigen::MatrixXd& right, double tolerance, int max_iterations,
                                  Eigen::MatrixXd* solution) {
  const Eigen::RowVectorXd scale = right.colwise().norm();
  Eigen::MatrixXd residual = right;
  *solution = Eigen::MatrixXd::Zero(right.rows(), right.cols());
  const auto all_below = [&](double bound) {
    return (residual.colwise().norm().array() <= bound * scale.array()).all();
  };
  IterationResult result;
  result.converged = all_below(tolerance);
  while (!result.converged && result.iterations < max_iterations) {
    *solution += precondition(residual);
    residual = right - multiply(*solution);
    ++result.iterations;
    result.converged = all_below(tolerance);
    if (!all_below(kDiverged)) break;
  }
  return result;
}

}  // namespace clothid
