#include "sim/contact/pair_elimination.h"

#include <Eigen/Geometry>
#include <algorithm>

namespace clothid {
namespace {

// gamma: the larger, the fewer iterations and the more digits of K are lost in M.
constexpr double kPenalty = 1e3;
// 1 - beta of a slipping pair is held above this, which bounds kappa as u_T -> 0.
constexpr double kSmallestPairSlip = 1e-12;

using Triplets = std::vector<Eigen::Triplet<double>>;

// `directions` . J of a pair, by columns [3 x k], as the rows from `row` on.
void AddRows(const PairCandidate& pair, const Eigen::Matrix3Xd& directions, Eigen::Index row, Triplets* rows) {
  for (int i = 0; i < 4; ++i) {
    for (int axis = 0; axis < 3 && pair.blocks[i] >= 0; ++axis) {
      for (Eigen::Index k = 0; k < directions.cols(); ++k) {
        const double value = pair.geometry.weights[i] * directions(axis, k);
        if (value != 0.0) rows->emplace_back(row + k, 3 * pair.blocks[i] + axis, value);
      }
    }
  }
}

Eigen::VectorXd AsVector(const std::vector<double>& values) {
  return Eigen::Map<const Eigen::VectorXd>(values.data(), static_cast<Eigen::Index>(values.size()));
}

}  // namespace

Eigen::Matrix3Xd PairElimination::Pair::constraints() const {
  if (branch == ContactBranch::kStick) return Eigen::Matrix3d::Identity();
  return frame.leftCols(num_rows());
}

Eigen::Matrix3Xd PairElimination::Pair::forces() const {
  if (branch == ContactBranch::kStick) return Eigen::Matrix3d::Identity();
  return (frame.col(0) + coupling * frame.col(1)).rowwise().replicate(num_rows());
}

PairElimination::Pair PairElimination::MakePair(const PairContact& contact, Eigen::Index row) {
  Pair pair{contact.response.branch, Eigen::Matrix3d::Identity(), contact.candidate.weight, 0.0, 1.0, 0.0, row};
  if (pair.branch != ContactBranch::kSlip) return pair;
  const Eigen::Vector3d &n = contact.candidate.geometry.normal, &t = contact.response.slip_direction;
  pair.frame << n, t, n.cross(t);
  pair.coupling = -contact.friction_coefficient;
  const double beta = -SlipRatio(contact.response, contact.friction_coefficient);
  pair.compliance = 1.0 / std::max(1.0 - beta, kSmallestPairSlip);
  pair.stiffness = pair.weight * beta * pair.compliance;
  return pair;
}

void PairElimination::SetContacts(const std::vector<PairContact>& contacts, Eigen::Index size) {
  pairs_.clear();
  Eigen::Index num_rows = 0;
  for (const PairContact& contact : contacts) {
    pairs_.push_back(MakePair(contact, num_rows));
    num_rows += pairs_.back().num_rows();
  }
  SetRows(contacts, size);
}

void PairElimination::SetRows(const std::vector<PairContact>& contacts, Eigen::Index size) {
  Triplets velocity, constraint, force, side;
  std::vector<double> row_weights, side_stiffness;
  blocks_.clear();
  weights_.clear();
  for (std::size_t c = 0; c < pairs_.size(); ++c) {
    const Pair& pair = pairs_[c];
    const PairCandidate& candidate = contacts[c].candidate;
    blocks_.push_back(candidate.blocks);
    weights_.push_back(candidate.geometry.weights);
    AddRows(candidate, Eigen::Matrix3d::Identity(), 3 * static_cast<Eigen::Index>(c), &velocity);
    AddRows(candidate, pair.constraints(), pair.row, &constraint);
    AddRows(candidate, pair.forces(), pair.row, &force);
    row_weights.insert(row_weights.end(), static_cast<std::size_t>(pair.num_rows()), pair.weight);
    if (pair.stiffness == 0.0) continue;
    AddRows(candidate, pair.frame.col(2), static_cast<Eigen::Index>(side_stiffness.size()), &side);
    side_stiffness.push_back(pair.stiffness);
  }
  const auto set = [size](const Triplets& triplets, Eigen::Index num_rows, Rows* rows) {
    rows->resize(num_rows, size);
    rows->setFromTriplets(triplets.begin(), triplets.end());
  };
  row_weights_ = AsVector(row_weights);
  side_stiffness_ = AsVector(side_stiffness);
  set(velocity, 3 * num_pairs(), &velocity_rows_);
  set(constraint, num_rows(), &constraint_rows_);
  set(force, num_rows(), &force_rows_);
  set(side, side_stiffness_.size(), &side_rows_);
}

std::vector<std::array<int, 4>> PairElimination::ClosedBlocks() const {
  std::vector<std::array<int, 4>> closed;
  for (std::size_t c = 0; c < pairs_.size(); ++c) {
    if (pairs_[c].num_rows() > 0) closed.push_back(blocks_[c]);
  }
  return closed;
}

void PairElimination::AddStiffness(const Eigen::MatrixXd& velocities, Eigen::MatrixXd* product) const {
  if (side_stiffness_.size() == 0) return;
  const Eigen::MatrixXd sides = side_stiffness_.asDiagonal() * (side_rows_ * velocities);
  *product += side_rows_.transpose() * sides;
}

void PairElimination::SubtractForces(bool transposed, const Eigen::MatrixXd& lambda, Eigen::MatrixXd* momentum) const {
  *momentum -= (transposed ? constraint_rows_ : force_rows_).transpose() * lambda;
}

Eigen::MatrixXd PairElimination::TimesRows(bool transposed, const Eigen::MatrixXd& velocities) const {
  const Eigen::MatrixXd product = (transposed ? force_rows_ : constraint_rows_) * velocities;
  return row_weights_.asDiagonal() * product;
}

void PairElimination::AddAugmented(BlockMatrix* matrix) const {
  for (std::size_t c = 0; c < pairs_.size(); ++c) {
    const Pair& pair = pairs_[c];
    if (pair.num_rows() == 0) continue;
    const Eigen::Matrix3Xd constraints = pair.constraints();
    const Eigen::Vector3d b = pair.frame.col(2);
    const Eigen::Matrix3d stiffness =
        kPenalty * pair.weight * constraints * constraints.transpose() + pair.stiffness * b * b.transpose();
    for (int i = 0; i < 4; ++i) {
      for (int j = 0; j < 4; ++j) {
        if (blocks_[c][i] < 0 || blocks_[c][j] < 0) continue;
        matrix->block(matrix->pattern().Find(blocks_[c][i], blocks_[c][j])) +=
            weights_[c][i] * weights_[c][j] * stiffness;
      }
    }
  }
}

void PairElimination::AddPenalty(const Eigen::MatrixXd& e, Eigen::MatrixXd* velocities) const {
  *velocities += kPenalty * (constraint_rows_.transpose() * e);
}

Eigen::MatrixXd PairElimination::PenaltyImpulses(const Eigen::MatrixXd& e, const Eigen::MatrixXd& velocities) const {
  return kPenalty * (e - TimesRows(false, velocities));
}

Eigen::MatrixXd PairElimination::Pair::Impulse(const Eigen::MatrixXd& lambda, const Eigen::MatrixXd& right,
                                               const Eigen::MatrixXd& velocities) const {
  if (branch == ContactBranch::kTakeOff) return right;
  if (branch == ContactBranch::kStick) return lambda;
  const Eigen::Vector3d n = frame.col(0), t = frame.col(1), b = frame.col(2);
  return forces() * lambda + t * ((t - coupling * n).transpose() * right) +
         b * (b.transpose() * (compliance * right - stiffness * velocities));
}

Eigen::MatrixXd PairElimination::KnownMomentum(const Eigen::MatrixXd& s) const {
  Eigen::MatrixXd known = Eigen::MatrixXd::Zero(s.rows(), s.cols());
  const Eigen::MatrixXd at_rest = Eigen::MatrixXd::Zero(3, s.cols());
  for (std::size_t c = 0; c < pairs_.size(); ++c) {
    const Pair& pair = pairs_[c];
    if (pair.branch == ContactBranch::kStick) continue;
    const Eigen::Index row = 3 * static_cast<Eigen::Index>(c);
    known.middleRows<3>(row) =
        pair.Impulse(Eigen::MatrixXd::Zero(pair.num_rows(), s.cols()), s.middleRows<3>(row), at_rest);
  }
  return Spread(known);
}

Eigen::MatrixXd PairElimination::RightRows(const Eigen::MatrixXd& s) const {
  Eigen::MatrixXd rows(num_rows(), s.cols());
  for (std::size_t c = 0; c < pairs_.size(); ++c) {
    rows.middleRows(pairs_[c].row, pairs_[c].num_rows()) =
        pairs_[c].constraints().transpose() * s.middleRows<3>(3 * static_cast<Eigen::Index>(c));
  }
  return rows;
}

Eigen::MatrixXd PairElimination::Impulses(const Eigen::MatrixXd& lambda, const Eigen::MatrixXd& s,
                                          const Eigen::MatrixXd& dv) const {
  const Eigen::MatrixXd velocities = velocity_rows_ * dv;
  Eigen::MatrixXd impulses(s.rows(), s.cols());
  for (std::size_t c = 0; c < pairs_.size(); ++c) {
    const Eigen::Index row = 3 * static_cast<Eigen::Index>(c);
    impulses.middleRows<3>(row) = pairs_[c].Impulse(lambda.middleRows(pairs_[c].row, pairs_[c].num_rows()),
                                                    s.middleRows<3>(row), velocities.middleRows<3>(row));
  }
  return impulses;
}

// With y = (I + S)^T z: a pair that leaves has rho = s + J y; one that sticks J y = -s and d rho = lambda; one that
// slips (n + q t) . J y = -(n + q t) . s, rho_t = t . (s + J y), rho_b = b . (s + J y)/(1 - beta) and
// d (rho_n + q rho_t) = lambda.
Eigen::MatrixXd PairElimination::Pair::AdjointImpulse(const Eigen::MatrixXd& lambda, const Eigen::MatrixXd& sum) const {
  if (branch == ContactBranch::kTakeOff) return sum;
  if (branch == ContactBranch::kStick) return lambda / weight;
  const Eigen::Vector3d n = frame.col(0), t = frame.col(1), b = frame.col(2);
  const Eigen::RowVectorXd along = t.transpose() * sum;
  return n * (lambda / weight - coupling * along) + t * along + (compliance * b) * (b.transpose() * sum);
}

Eigen::MatrixXd PairElimination::KnownMomentumTransposed(const Eigen::MatrixXd& s) const {
  Eigen::MatrixXd sides = Eigen::MatrixXd::Zero(s.rows(), s.cols());
  for (std::size_t c = 0; c < pairs_.size(); ++c) {
    const Eigen::Index row = 3 * static_cast<Eigen::Index>(c);
    const Eigen::Vector3d b = pairs_[c].frame.col(2);
    sides.middleRows<3>(row) = pairs_[c].stiffness * b * (b.transpose() * s.middleRows<3>(row));
  }
  return Spread(sides);
}

Eigen::MatrixXd PairElimination::RightRowsTransposed(const Eigen::MatrixXd& s) const {
  Eigen::MatrixXd rows(num_rows(), s.cols());
  for (std::size_t c = 0; c < pairs_.size(); ++c) {
    const Pair& pair = pairs_[c];
    rows.middleRows(pair.row, pair.num_rows()) =
        -pair.weight * (pair.forces().transpose() * s.middleRows<3>(3 * static_cast<Eigen::Index>(c)));
  }
  return rows;
}

Eigen::MatrixXd PairElimination::AdjointImpulses(const Eigen::MatrixXd& lambda, const Eigen::MatrixXd& s,
                                                 const Eigen::MatrixXd& y) const {
  const Eigen::MatrixXd sums = s + velocity_rows_ * y;
  Eigen::MatrixXd impulses(s.rows(), s.cols());
  for (std::size_t c = 0; c < pairs_.size(); ++c) {
    const Eigen::Index row = 3 * static_cast<Eigen::Index>(c);
    impulses.middleRows<3>(row) =
        pairs_[c].AdjointImpulse(lambda.middleRows(pairs_[c].row, pairs_[c].num_rows()), sums.middleRows<3>(row));
  }
  return impulses;
}

}  // namespace clothid
