#include "sim/contact/contact_elimination.h"

#include <Eigen/Geometry>
#include <algorithm>

namespace clothid {
namespace {

// 1 + c of a slipping node is held above this, which bounds kappa by d times its inverse as u_T -> 0.
constexpr double kSmallestSlip = 1e-12;

}  // namespace

void ToLocal(const std::vector<LocalFrame>& frames, Eigen::MatrixXd* vectors) {
  for (const LocalFrame& frame : frames) {
    auto rows = vectors->middleRows<3>(3 * frame.block);
    rows = (frame.axes.transpose() * rows).eval();
  }
}

void ToWorld(const std::vector<LocalFrame>& frames, Eigen::MatrixXd* vectors) {
  for (const LocalFrame& frame : frames) {
    auto rows = vectors->middleRows<3>(3 * frame.block);
    rows = (frame.axes * rows).eval();
  }
}

void ContactElimination::SetContacts(const std::vector<Contact>& contacts, const std::vector<int>& free_index,
                                     const std::vector<double>& friction_coefficients) {
  nodes_.clear();
  has_coupling_ = false;
  for (const Contact& contact : contacts) {
    Node node;
    node.block = free_index[contact.candidate.node];
    node.branch = contact.response.branch;
    node.friction_coefficient = friction_coefficients[contact.candidate.obstacle];
    node.weight = contact.weight;
    const Eigen::Vector3d& n = contact.candidate.normal;
    node.impulse = ImpulseForceJacobian(contact.response, n, node.friction_coefficient);
    node.frame.setIdentity();
    node.slip_stiffness = 0.0;
    node.slip_compliance = 1.0;
    if (node.branch == ContactBranch::kSlip) {
      const Eigen::Vector3d& t = contact.response.slip_direction;
      node.frame << n, t, n.cross(t);
      const double ratio = SlipRatio(contact.response, node.friction_coefficient);
      node.slip_compliance = 1.0 / std::max(1.0 + ratio, kSmallestSlip);
      node.slip_stiffness = -ratio * contact.weight * node.slip_compliance;
      has_coupling_ = has_coupling_ || node.friction_coefficient > 0.0;
    }
    nodes_.push_back(node);
  }
}

std::vector<LocalFrame> ContactElimination::SlipFrames() const {
  std::vector<LocalFrame> frames;
  for (const Node& node : nodes_) {
    if (node.branch == ContactBranch::kSlip) frames.push_back({node.block, node.frame});
  }
  return frames;
}

void ContactElimination::Reduce(const BlockMatrix& matrix, Eigen::VectorXd* values) const {
  *values = matrix.values;
  const BlockPattern& pattern = matrix.pattern();
  const auto at = [values](BlockPosition position) {
    return BlockMatrix::Block(values->data() + position.start, Eigen::OuterStride<>(position.stride));
  };
  for (const Node& node : nodes_) {
    const int eliminated = node.branch == ContactBranch::kStick ? 3 : 1;
    for (int k = 0; k < pattern.num_rows(node.block); ++k) {
      const int row = pattern.rows_begin(node.block)[k];
      BlockMatrix::Block column_block = at(pattern.Position(node.block, k));
      column_block = (column_block * node.frame).eval();
      column_block.leftCols(eliminated).setZero();
      BlockMatrix::Block row_block = at(pattern.Find(node.block, row));
      row_block = (node.frame.transpose() * row_block).eval();
      row_block.topRows(eliminated).setZero();
    }
    BlockMatrix::Block diagonal = at(pattern.Diagonal(node.block));
    diagonal.diagonal().head(eliminated).setConstant(node.weight);
    if (node.branch == ContactBranch::kSlip) diagonal(2, 2) += node.slip_stiffness;
  }
}

void ContactElimination::Project(Eigen::MatrixXd* vectors) const {
  for (const Node& node : nodes_) {
    auto rows = vectors->middleRows<3>(3 * node.block);
    if (node.branch == ContactBranch::kStick) {
      rows.setZero();
    } else {
      rows -= (node.frame.col(0) * (node.frame.col(0).transpose() * rows)).eval();
    }
  }
}

void ContactElimination::AddFriction(Eigen::MatrixXd* vectors) const {
  for (const Node& node : nodes_) {
    if (node.branch != ContactBranch::kSlip) continue;
    auto rows = vectors->middleRows<3>(3 * node.block);
    rows += (node.friction_coefficient * node.frame.col(1) * (node.frame.col(0).transpose() * rows)).eval();
  }
}

void ContactElimination::AddFrictionTransposed(Eigen::MatrixXd* vectors) const {
  for (const Node& node : nodes_) {
    if (node.branch != ContactBranch::kSlip) continue;
    auto rows = vectors->middleRows<3>(3 * node.block);
    rows += (node.friction_coefficient * node.frame.col(0) * (node.frame.col(1).transpose() * rows)).eval();
  }
}

void ContactElimination::AddSlipStiffness(const Eigen::MatrixXd& vectors, Eigen::MatrixXd* result) const {
  for (const Node& node : nodes_) {
    if (node.slip_stiffness == 0.0) continue;
    const auto b = node.frame.col(2);
    result->middleRows<3>(3 * node.block) +=
        node.slip_stiffness * b * (b.transpose() * vectors.middleRows<3>(3 * node.block));
  }
}

// Stick: d dv = right. Slip: d n . dv = n . right.
Eigen::MatrixXd ContactElimination::KnownPart(const Eigen::MatrixXd& right) const {
  Eigen::MatrixXd known = Eigen::MatrixXd::Zero(right.rows(), right.cols());
  for (const Node& node : nodes_) {
    const auto rows = right.middleRows<3>(3 * node.block);
    auto result = known.middleRows<3>(3 * node.block);
    if (node.branch == ContactBranch::kStick) {
      result = rows / node.weight;
    } else {
      const auto n = node.frame.col(0);
      result = n * (n.transpose() * rows) / node.weight;
    }
  }
  return known;
}

// With s = -K known. Free: right + s. Slip: t . right + mu d n . known + (t + mu n) . s  and  b . right/(1 + c) + b .
// s.
Eigen::MatrixXd ContactElimination::ReducedRight(const Eigen::MatrixXd& right, const Eigen::MatrixXd& known,
                                                 const Eigen::MatrixXd& matrix_known) const {
  Eigen::MatrixXd reduced = -matrix_known;
  AddFriction(&reduced);
  Project(&reduced);
  Eigen::MatrixXd direct = right;
  for (const Node& node : nodes_) {
    auto rows = direct.middleRows<3>(3 * node.block);
    if (node.branch == ContactBranch::kStick) {
      rows.setZero();
      continue;
    }
    const auto n = node.frame.col(0), t = node.frame.col(1), b = node.frame.col(2);
    const auto known_rows = known.middleRows<3>(3 * node.block);
    rows = (t * (t.transpose() * rows + node.friction_coefficient * node.weight * (n.transpose() * known_rows)) +
            node.slip_compliance * b * (b.transpose() * rows))
               .eval();
  }
  return reduced + direct;
}

// Stick: z = (right - K y)/d. Slip: t . z = t . q, b . z = b . q/(1 + c), n . z = n . (right - K y)/d + mu t . q.
Eigen::MatrixXd ContactElimination::RecoverAdjoint(const Eigen::MatrixXd& right, const Eigen::MatrixXd& q,
                                                   const Eigen::MatrixXd& matrix_y) const {
  Eigen::MatrixXd z = q;
  for (const Node& node : nodes_) {
    auto rows = z.middleRows<3>(3 * node.block);
    const Eigen::Matrix<double, 3, Eigen::Dynamic> rest =
        (right.middleRows<3>(3 * node.block) - matrix_y.middleRows<3>(3 * node.block)) / node.weight;
    if (node.branch == ContactBranch::kStick) {
      rows = rest;
      continue;
    }
    const auto n = node.frame.col(0), t = node.frame.col(1), b = node.frame.col(2);
    rows = (t * (t.transpose() * rows) + node.slip_compliance * b * (b.transpose() * rows) +
            n * (n.transpose() * rest + node.friction_coefficient * (t.transpose() * rows)))
               .eval();
  }
  return z;
}

void ContactElimination::FullJacobian(const BlockMatrix& matrix, Eigen::VectorXd* values) const {
  *values = matrix.values;
  const BlockPattern& pattern = matrix.pattern();
  const auto at = [values](BlockPosition position) {
    return BlockMatrix::Block(values->data() + position.start, Eigen::OuterStride<>(position.stride));
  };
  for (const Node& node : nodes_) {
    for (int k = 0; k < pattern.num_rows(node.block); ++k) {
      BlockMatrix::Block block = at(pattern.Find(node.block, pattern.rows_begin(node.block)[k]));
      block += (node.impulse * block).eval();
    }
    at(pattern.Diagonal(node.block)) -= node.weight * node.impulse;
  }
}

void ContactElimination::AddImpulseTransposed(Eigen::MatrixXd* vectors) const {
  for (const Node& node : nodes_) {
    auto rows = vectors->middleRows<3>(3 * node.block);
    rows += (node.impulse.transpose() * rows).eval();
  }
}

void ContactElimination::AddImpulse(Eigen::MatrixXd* vectors) const {
  for (const Node& node : nodes_) {
    auto rows = vectors->middleRows<3>(3 * node.block);
    rows += (node.impulse * rows).eval();
  }
}

}  // namespace clothid
