#include "sim/contact/contact_elimination.h"

#include <Eigen/Geometry>
#include <algorithm>

namespace clothid {
namespace {

// 1 + c of a slipping node is held above this, which bounds kappa by d times its inverse as u_T -> 0.
constexpr double kSmallestSlip = 1e-12;

// v <- map(item, v, others ..) for the block v of every item in every column, and the same block of other vectors. By
// columns, so that blocks have a fixed size.
template <typename Item, typename Map, typename... Others>
void MapBlocks(const std::vector<Item>& items, Eigen::MatrixXd* vectors, const Map& map, const Others&... others) {
  for (Eigen::Index c = 0; c < vectors->cols(); ++c) {
    for (const Item& item : items) {
      const Eigen::Index row = 3 * static_cast<Eigen::Index>(item.block);
      Eigen::Map<Eigen::Vector3d> v(vectors->col(c).data() + row);
      v = map(item, Eigen::Vector3d(v), Eigen::Vector3d(others.col(c).template segment<3>(row))...);
    }
  }
}

}  // namespace

void ToLocal(const std::vector<LocalFrame>& frames, Eigen::MatrixXd* vectors) {
  MapBlocks(frames, vectors, [](const LocalFrame& frame, const Eigen::Vector3d& v) -> Eigen::Vector3d {
    return frame.axes.transpose() * v;
  });
}

void ToWorld(const std::vector<LocalFrame>& frames, Eigen::MatrixXd* vectors) {
  MapBlocks(frames, vectors,
            [](const LocalFrame& frame, const Eigen::Vector3d& v) -> Eigen::Vector3d { return frame.axes * v; });
}

void ContactElimination::SetContacts(const std::vector<Contact>& contacts, const std::vector<int>& free_index) {
  nodes_.clear();
  nodes_.reserve(contacts.size());
  has_coupling_ = false;
  for (const Contact& contact : contacts) {
    Node node;
    node.block = free_index[contact.candidate.node];
    node.branch = contact.response.branch;
    node.friction_coefficient = contact.friction_coefficient;
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

Eigen::Matrix3d ContactElimination::Node::projection() const {
  if (branch == ContactBranch::kStick) return Eigen::Matrix3d::Zero();
  return Eigen::Matrix3d::Identity() - frame.col(0) * frame.col(0).transpose();
}

HeldBlocks ContactElimination::Held() const {
  HeldBlocks held;
  for (const Node& node : nodes_) {
    if (node.branch == ContactBranch::kSlip) {
      held.slipping.push_back({node.block, node.frame});
    } else {
      held.sticking.push_back(node.block);
    }
  }
  return held;
}

std::vector<int> ContactElimination::Places(int num_blocks) const {
  std::vector<int> places(num_blocks, -1);
  for (std::size_t i = 0; i < nodes_.size(); ++i) places[nodes_[i].block] = static_cast<int>(i);
  return places;
}

// A normal that has turned while its node slips counts as the same.
std::vector<FreedBlock> ContactElimination::FreedSince(const HeldBlocks& before, int num_blocks) const {
  const std::vector<int> places = Places(num_blocks);
  std::vector<FreedBlock> freed;
  for (const int block : before.sticking) {
    if (places[block] < 0) {
      freed.push_back({block, Eigen::Matrix3d::Identity()});
    } else if (nodes_[places[block]].branch == ContactBranch::kSlip) {
      freed.push_back({block, nodes_[places[block]].projection()});
    }
  }
  for (const LocalFrame& frame : before.slipping) {
    const Eigen::Vector3d n = frame.axes.col(0);
    if (places[frame.block] < 0) freed.push_back({frame.block, n * n.transpose()});
  }
  return freed;
}

Eigen::SparseMatrix<double> ContactElimination::ReducedColumns(const BlockMatrix& matrix,
                                                               const std::vector<int>& blocks) const {
  const BlockPattern& pattern = matrix.pattern();
  const std::vector<int> places = Places(pattern.num_blocks());
  const auto projection = [&](int block) -> Eigen::Matrix3d {
    return places[block] < 0 ? Eigen::Matrix3d::Identity() : nodes_[places[block]].projection();
  };
  Eigen::SparseMatrix<double> columns(pattern.size(), 3 * static_cast<Eigen::Index>(blocks.size()));
  Eigen::VectorXi sizes(columns.cols());
  for (std::size_t j = 0; j < blocks.size(); ++j) {
    sizes.segment<3>(3 * static_cast<Eigen::Index>(j)).setConstant(3 * pattern.num_rows(blocks[j]));
  }
  columns.reserve(sizes);
  for (std::size_t j = 0; j < blocks.size(); ++j) {
    const int block = blocks[j];
    const Eigen::Matrix3d right = projection(block);
    for (int k = 0; k < pattern.num_rows(block); ++k) {
      const int row = pattern.rows_begin(block)[k];
      Eigen::Matrix3d reduced = projection(row) * matrix.block(pattern.Position(block, k)) * right;
      if (row == block && places[block] >= 0) {
        const Node& node = nodes_[places[block]];
        const Eigen::Vector3d b = node.frame.col(2);
        reduced += node.weight * (Eigen::Matrix3d::Identity() - right) + node.slip_stiffness * b * b.transpose();
      }
      for (int c = 0; c < 3; ++c) {
        for (int r = 0; r < 3; ++r) columns.insert(3 * row + r, 3 * static_cast<Eigen::Index>(j) + c) = reduced(r, c);
      }
    }
  }
  columns.makeCompressed();
  return columns;
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
      BlockMatrix::Block row_block = at(pattern.Find(node.block, row));
      if (node.branch == ContactBranch::kStick) {
        column_block.setZero();
        row_block.setZero();
        continue;
      }
      column_block = (column_block * node.frame).eval();
      column_block.leftCols(eliminated).setZero();
      row_block = (node.frame.transpose() * row_block).eval();
      row_block.topRows(eliminated).setZero();
    }
    BlockMatrix::Block diagonal = at(pattern.Diagonal(node.block));
    diagonal.diagonal().head(eliminated).setConstant(node.weight);
    if (node.branch == ContactBranch::kSlip) diagonal(2, 2) += node.slip_stiffness;
  }
}

void ContactElimination::Project(Eigen::MatrixXd* vectors) const {
  MapBlocks(nodes_, vectors, [](const Node& node, const Eigen::Vector3d& v) -> Eigen::Vector3d {
    if (node.branch == ContactBranch::kStick) return Eigen::Vector3d::Zero();
    const auto n = node.frame.col(0);
    return v - n.dot(v) * n;
  });
}

void ContactElimination::AddFriction(Eigen::MatrixXd* vectors) const {
  MapBlocks(nodes_, vectors, [](const Node& node, const Eigen::Vector3d& v) -> Eigen::Vector3d {
    if (node.branch != ContactBranch::kSlip) return v;
    return v + node.friction_coefficient * node.frame.col(0).dot(v) * node.frame.col(1);
  });
}

void ContactElimination::AddFrictionTransposed(Eigen::MatrixXd* vectors) const {
  MapBlocks(nodes_, vectors, [](const Node& node, const Eigen::Vector3d& v) -> Eigen::Vector3d {
    if (node.branch != ContactBranch::kSlip) return v;
    return v + node.friction_coefficient * node.frame.col(1).dot(v) * node.frame.col(0);
  });
}

void ContactElimination::AddSlipStiffness(const Eigen::MatrixXd& vectors, Eigen::MatrixXd* result) const {
  const auto add = [](const Node& node, const Eigen::Vector3d& sum, const Eigen::Vector3d& v) -> Eigen::Vector3d {
    const auto b = node.frame.col(2);
    return sum + node.slip_stiffness * b.dot(v) * b;
  };
  MapBlocks(nodes_, result, add, vectors);
}

// Stick: d dv = right. Slip: d n . dv = n . right.
Eigen::MatrixXd ContactElimination::KnownPart(const Eigen::MatrixXd& right) const {
  Eigen::MatrixXd known = Eigen::MatrixXd::Zero(right.rows(), right.cols());
  const auto set = [](const Node& node, const Eigen::Vector3d&, const Eigen::Vector3d& r) -> Eigen::Vector3d {
    if (node.branch == ContactBranch::kStick) return r / node.weight;
    const auto n = node.frame.col(0);
    return n.dot(r) / node.weight * n;
  };
  MapBlocks(nodes_, &known, set, right);
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
  const auto set = [](const Node& node, const Eigen::Vector3d& r, const Eigen::Vector3d& v) -> Eigen::Vector3d {
    if (node.branch == ContactBranch::kStick) return Eigen::Vector3d::Zero();
    const auto n = node.frame.col(0), t = node.frame.col(1), b = node.frame.col(2);
    return (t.dot(r) + node.friction_coefficient * node.weight * n.dot(v)) * t + node.slip_compliance * b.dot(r) * b;
  };
  MapBlocks(nodes_, &direct, set, known);
  return reduced + direct;
}

// Stick: z = (right - K y)/d. Slip: t . z = t . q, b . z = b . q/(1 + c), n . z = n . (right - K y)/d + mu t . q.
Eigen::MatrixXd ContactElimination::RecoverAdjoint(const Eigen::MatrixXd& right, const Eigen::MatrixXd& q,
                                                   const Eigen::MatrixXd& matrix_y) const {
  Eigen::MatrixXd z = q;
  const auto set = [](const Node& node, const Eigen::Vector3d& v, const Eigen::Vector3d& r,
                      const Eigen::Vector3d& m) -> Eigen::Vector3d {
    const Eigen::Vector3d rest = (r - m) / node.weight;
    if (node.branch == ContactBranch::kStick) return rest;
    const auto n = node.frame.col(0), t = node.frame.col(1), b = node.frame.col(2);
    return t.dot(v) * t + node.slip_compliance * b.dot(v) * b +
           (n.dot(rest) + node.friction_coefficient * t.dot(v)) * n;
  };
  MapBlocks(nodes_, &z, set, right, matrix_y);
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
  MapBlocks(nodes_, vectors, [](const Node& node, const Eigen::Vector3d& v) -> Eigen::Vector3d {
    return v + node.impulse.transpose() * v;
  });
}

void ContactElimination::AddImpulse(Eigen::MatrixXd* vectors) const {
  MapBlocks(nodes_, vectors,
            [](const Node& node, const Eigen::Vector3d& v) -> Eigen::Vector3d { return v + node.impulse * v; });
}

}  // namespace clothid
