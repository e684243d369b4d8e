#include "sim/contact/pair_elimination.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <utility>

#include "sim/contact/pair_slaves.h"

namespace clothid {
namespace {

// 1 - beta of a slipping pair is held above this, which bounds kappa as u_T -> 0.
constexpr double kSmallestPairSlip = 1e-12;
// Rows of loose pairs may depend on each other: this share of their diagonal is added to it.
constexpr double kLooseShare = 1e-6;

double* ColumnOf(Eigen::MatrixXd* columns, Eigen::Index c) { return columns->data() + c * columns->rows(); }
const double* ColumnOf(const Eigen::MatrixXd& columns, Eigen::Index c) { return columns.data() + c * columns.rows(); }
Eigen::Map<Eigen::Vector3d> At(double* column, int block) { return Eigen::Map<Eigen::Vector3d>(column + 3 * block); }

}  // namespace

Eigen::Matrix3Xd PairElimination::Pair::constraints(bool transposed) const {
  if (sticks()) return Eigen::Matrix3d::Identity();
  Eigen::Matrix3Xd directions = frame.leftCols(num_rows());
  if (transposed) directions.colwise() += coupling * frame.col(1);
  return directions;
}

Eigen::Vector3d PairElimination::Pair::Relative(const double* velocities) const {
  Eigen::Vector3d relative = Eigen::Vector3d::Zero();
  for (int i = 0; i < 4; ++i) {
    if (blocks[i] >= 0) relative += weights[i] * Eigen::Map<const Eigen::Vector3d>(velocities + 3 * blocks[i]);
  }
  return relative;
}

void PairElimination::Pair::Add(const Eigen::Vector3d& impulse, double* momentum) const {
  for (int i = 0; i < 4; ++i) {
    if (blocks[i] >= 0) At(momentum, blocks[i]) += weights[i] * impulse;
  }
}

// n n^T u of a pair that slips, transposed n (n + q t)^T u.
Eigen::Vector3d PairElimination::Pair::Forbidden(bool transposed, const Eigen::Vector3d& relative) const {
  if (sticks()) return relative;
  const double along = frame.col(0).dot(relative) + (transposed ? coupling * frame.col(1).dot(relative) : 0.0);
  return along * frame.col(0);
}

// (n + q t) lambda of a pair that slips, transposed n lambda, with lambda = n . g/w of its slave.
Eigen::Vector3d PairElimination::Pair::Load(bool transposed, const Eigen::Vector3d& momentum) const {
  if (sticks()) return momentum / weights[slave];
  const Eigen::Vector3d n = frame.col(0), t = frame.col(1);
  const double lambda = n.dot(momentum) / weights[slave];
  return lambda * n + (transposed ? 0.0 : coupling * lambda) * t;
}

PairElimination::Pair PairElimination::MakePair(const PairContact& contact, Eigen::Index row) {
  const PairCandidate& candidate = contact.candidate;
  Pair pair{contact.response.branch,
            candidate.blocks,
            candidate.geometry.weights,
            Eigen::Matrix3d::Identity(),
            candidate.weight,
            0.0,
            1.0,
            0.0,
            row};
  if (pair.branch != ContactBranch::kSlip) return pair;
  const Eigen::Vector3d &n = candidate.geometry.normal, &t = contact.response.slip_direction;
  pair.frame << n, t, n.cross(t);
  pair.coupling = -contact.friction_coefficient;
  const double beta = -SlipRatio(contact.response, contact.friction_coefficient);
  pair.compliance = 1.0 / std::max(1.0 - beta, kSmallestPairSlip);
  pair.stiffness = pair.weight * beta * pair.compliance;
  return pair;
}

void PairElimination::SetContacts(const std::vector<PairContact>& contacts, const std::vector<int>& held,
                                  const BlockMatrix& hessian) {
  pairs_.clear();
  size_ = hessian.pattern().size();
  num_rows_ = 0;
  for (const PairContact& contact : contacts) {
    pairs_.push_back(MakePair(contact, num_rows_));
    num_rows_ += pairs_.back().num_rows();
  }
  order_.clear();
  if (in_contact()) {
    PairSlaves slaves = ChooseSlaves(contacts, held, hessian.pattern().num_blocks());
    order_ = std::move(slaves.order);
    for (std::size_t c = 0; c < pairs_.size(); ++c) pairs_[c].slave = slaves.places[c];
  }
  NumberRows(hessian);
}

void PairElimination::NumberRows(const BlockMatrix& hessian) {
  loose_.clear();
  num_loose_rows_ = num_sides_ = 0;
  has_friction_ = false;
  for (std::size_t c = 0; c < pairs_.size(); ++c) {
    Pair& pair = pairs_[c];
    has_friction_ = has_friction_ || pair.coupling != 0.0;
    if (pair.num_rows() > 0 && pair.slave < 0) {
      loose_.push_back(static_cast<int>(c));
      pair.loose_row = num_loose_rows_;
      num_loose_rows_ += pair.num_rows();
    } else if (pair.stiffness > pair.weight) {
      const Eigen::Vector3d b = pair.frame.col(2);
      const double weight = pair.weights[pair.slave];
      const double own = b.dot(hessian.block(hessian.pattern().Diagonal(pair.blocks[pair.slave])) * b);
      pair.side_compliance = 1.0 / (pair.stiffness + own / (weight * weight));
      pair.side = num_sides_++;
    }
  }
  if (!loose_.empty()) FactorLooseRows(hessian);
}

void PairElimination::FactorLooseRows(const BlockMatrix& hessian) {
  loose_compliances_.assign(loose_.size(), Eigen::Vector4d::Zero());
  Eigen::MatrixXd matrix = Eigen::MatrixXd::Zero(num_loose_rows_, num_loose_rows_);
  for (std::size_t k = 0; k < loose_.size(); ++k) {
    const Pair& pair = pairs_[loose_[k]];
    for (int i = 0; i < 4; ++i) {
      if (pair.blocks[i] < 0) continue;
      const double trace = hessian.block(hessian.pattern().Diagonal(pair.blocks[i])).diagonal().sum();
      loose_compliances_[k][i] = trace > 0.0 ? 3.0 / trace : 0.0;
    }
    for (const int other_pair : loose_) {
      const Pair& other = pairs_[other_pair];
      double compliance = 0.0;
      for (int i = 0; i < 4; ++i) {
        const auto* const found = std::find(other.blocks.begin(), other.blocks.end(), pair.blocks[i]);
        if (pair.blocks[i] < 0 || found == other.blocks.end()) continue;
        compliance += loose_compliances_[k][i] * pair.weights[i] * other.weights[found - other.blocks.begin()];
      }
      if (compliance == 0.0) continue;
      matrix.block(pair.loose_row, other.loose_row, pair.num_rows(), other.num_rows()) =
          compliance * pair.constraints(false).transpose() * other.constraints(false);
    }
  }
  matrix.diagonal() *= 1.0 + kLooseShare;
  loose_factor_.compute(matrix);
}

void PairElimination::AddStiffness(const Eigen::MatrixXd& velocities, Eigen::MatrixXd* product) const {
  for (const Pair& pair : pairs_) {
    if (pair.stiffness == 0.0) continue;
    const Eigen::Vector3d b = pair.frame.col(2);
    for (Eigen::Index c = 0; c < velocities.cols(); ++c) {
      pair.Add(pair.stiffness * b.dot(pair.Relative(ColumnOf(velocities, c))) * b, ColumnOf(product, c));
    }
  }
}

void PairElimination::Follow(bool transposed, Eigen::MatrixXd* velocities) const {
  for (Eigen::Index c = 0; c < velocities->cols(); ++c) {
    double* const v = ColumnOf(velocities, c);
    for (const int p : order_) {
      const Pair& pair = pairs_[p];
      At(v, pair.blocks[pair.slave]) -= pair.Forbidden(transposed, pair.Relative(v)) / pair.weights[pair.slave];
    }
  }
}

void PairElimination::Unload(bool transposed, Eigen::MatrixXd* momentum) const {
  for (Eigen::Index c = 0; c < momentum->cols(); ++c) {
    double* const g = ColumnOf(momentum, c);
    for (std::size_t k = order_.size(); k-- > 0;) {
      const Pair& pair = pairs_[order_[k]];
      pair.Add(-pair.Load(transposed, At(g, pair.blocks[pair.slave])), g);
    }
  }
}

void PairElimination::FollowTo(bool transposed, const Eigen::MatrixXd& rows, Eigen::MatrixXd* velocities) const {
  for (Eigen::Index c = 0; c < velocities->cols(); ++c) {
    double* const v = ColumnOf(velocities, c);
    for (const int p : order_) {
      const Pair& pair = pairs_[p];
      const double* const row = ColumnOf(rows, c) + pair.row;
      Eigen::Vector3d change = -pair.Forbidden(transposed, pair.Relative(v));
      if (pair.sticks()) {
        change += Eigen::Map<const Eigen::Vector3d>(row) / pair.weight;
      } else {
        change += *row / pair.weight * pair.frame.col(0);
      }
      At(v, pair.blocks[pair.slave]) += change / pair.weights[pair.slave];
    }
  }
}

Eigen::MatrixXd PairElimination::TimesLooseRows(bool transposed, const Eigen::MatrixXd& velocities) const {
  Eigen::MatrixXd product(num_loose_rows_, velocities.cols());
  for (const int p : loose_) {
    const Pair& pair = pairs_[p];
    const Eigen::Matrix3Xd constraints = pair.weight * pair.constraints(transposed);
    for (Eigen::Index c = 0; c < velocities.cols(); ++c) {
      product.col(c).segment(pair.loose_row, pair.num_rows()) =
          constraints.transpose() * pair.Relative(ColumnOf(velocities, c));
    }
  }
  return product;
}

Eigen::MatrixXd PairElimination::LooseRest(bool transposed, const Eigen::MatrixXd& rows,
                                           const Eigen::MatrixXd& velocities) const {
  Eigen::MatrixXd rest = -TimesLooseRows(transposed, velocities);
  for (const int p : loose_) {
    const Pair& pair = pairs_[p];
    rest.middleRows(pair.loose_row, pair.num_rows()) += rows.middleRows(pair.row, pair.num_rows());
  }
  return rest;
}

void PairElimination::SubtractLooseForces(bool transposed, const Eigen::MatrixXd& lambda,
                                          Eigen::MatrixXd* momentum) const {
  for (const int p : loose_) {
    const Pair& pair = pairs_[p];
    const Eigen::Matrix3Xd forces = pair.forces(transposed);
    for (Eigen::Index c = 0; c < momentum->cols(); ++c) {
      pair.Add(-(forces * lambda.col(c).segment(pair.loose_row, pair.num_rows())), ColumnOf(momentum, c));
    }
  }
}

// Z^T is Q of the other matrix.
Eigen::MatrixXd PairElimination::Split(bool transposed, Eigen::MatrixXd* momentum) const {
  Eigen::MatrixXd sides(num_sides_, momentum->cols());
  for (Eigen::Index c = 0; c < momentum->cols(); ++c) {
    double* const g = ColumnOf(momentum, c);
    for (std::size_t k = order_.size(); k-- > 0;) {
      const Pair& pair = pairs_[order_[k]];
      const Eigen::Vector3d own = At(g, pair.blocks[pair.slave]);
      Eigen::Vector3d load = pair.Load(!transposed, own);
      if (pair.side >= 0) {
        const double along = pair.frame.col(2).dot(own) / pair.weights[pair.slave];
        sides(pair.side, c) = pair.side_compliance * along;
        load += along * pair.frame.col(2);
      }
      pair.Add(-load, g);
    }
  }
  return sides;
}

void PairElimination::Join(bool transposed, const Eigen::MatrixXd& sides, Eigen::MatrixXd* velocities) const {
  for (Eigen::Index c = 0; c < velocities->cols(); ++c) {
    double* const v = ColumnOf(velocities, c);
    for (const int p : order_) {
      const Pair& pair = pairs_[p];
      const Eigen::Vector3d relative = pair.Relative(v);
      Eigen::Vector3d change = pair.Forbidden(transposed, relative);
      if (pair.side >= 0) change += (pair.frame.col(2).dot(relative) - sides(pair.side, c)) * pair.frame.col(2);
      At(v, pair.blocks[pair.slave]) -= change / pair.weights[pair.slave];
    }
  }
}

Eigen::MatrixXd PairElimination::JoinLoose(bool transposed, const Eigen::MatrixXd& rows,
                                           Eigen::MatrixXd* velocities) const {
  Eigen::MatrixXd lambda = rows - TimesLooseRows(transposed, *velocities);
  for (const int p : loose_) {
    const Pair& pair = pairs_[p];
    lambda.middleRows(pair.loose_row, pair.num_rows()) /= pair.weight;
  }
  lambda = loose_factor_.solve(lambda).eval();
  for (std::size_t k = 0; k < loose_.size(); ++k) {
    const Pair& pair = pairs_[loose_[k]];
    const Eigen::MatrixXd impulse = pair.constraints(false) * lambda.middleRows(pair.loose_row, pair.num_rows());
    for (int i = 0; i < 4; ++i) {
      if (pair.blocks[i] < 0) continue;
      velocities->middleRows<3>(3 * pair.blocks[i]) += loose_compliances_[k][i] * pair.weights[i] * impulse;
    }
  }
  return lambda;
}

Eigen::MatrixXd PairElimination::Multipliers(bool transposed, const Eigen::MatrixXd& loose,
                                             Eigen::MatrixXd* balance) const {
  Eigen::MatrixXd lambda(num_rows_, balance->cols());
  for (const int p : loose_) {
    const Pair& pair = pairs_[p];
    lambda.middleRows(pair.row, pair.num_rows()) = loose.middleRows(pair.loose_row, pair.num_rows());
  }
  SubtractLooseForces(transposed, loose, balance);
  for (Eigen::Index c = 0; c < balance->cols(); ++c) {
    double* const g = ColumnOf(balance, c);
    for (std::size_t k = order_.size(); k-- > 0;) {
      const Pair& pair = pairs_[order_[k]];
      const Eigen::Vector3d own = At(g, pair.blocks[pair.slave]) / pair.weights[pair.slave];
      if (pair.sticks()) {
        lambda.col(c).segment<3>(pair.row) = own;
      } else {
        lambda(pair.row, c) = pair.frame.col(0).dot(own);
      }
      pair.Add(-pair.Load(transposed, At(g, pair.blocks[pair.slave])), g);
    }
  }
  return lambda;
}

Eigen::MatrixXd PairElimination::Relative(const Eigen::MatrixXd& velocities) const {
  Eigen::MatrixXd relative(3 * num_pairs(), velocities.cols());
  for (Eigen::Index c = 0; c < velocities.cols(); ++c) {
    double* to = ColumnOf(&relative, c);
    for (const Pair& pair : pairs_) {
      Eigen::Map<Eigen::Vector3d>{to} = pair.Relative(ColumnOf(velocities, c));
      to += 3;
    }
  }
  return relative;
}

Eigen::MatrixXd PairElimination::Spread(const Eigen::MatrixXd& impulses) const {
  Eigen::MatrixXd spread = Eigen::MatrixXd::Zero(size_, impulses.cols());
  for (Eigen::Index c = 0; c < impulses.cols(); ++c) {
    const double* from = ColumnOf(impulses, c);
    for (const Pair& pair : pairs_) {
      pair.Add(Eigen::Map<const Eigen::Vector3d>(from), ColumnOf(&spread, c));
      from += 3;
    }
  }
  return spread;
}

Eigen::MatrixXd PairElimination::Pair::Impulse(const Eigen::MatrixXd& lambda, const Eigen::MatrixXd& right,
                                               const Eigen::MatrixXd& velocities) const {
  if (branch == ContactBranch::kTakeOff) return right;
  if (branch == ContactBranch::kStick) return lambda;
  const Eigen::Vector3d n = frame.col(0), t = frame.col(1), b = frame.col(2);
  return forces(false) * lambda + t * ((t - coupling * n).transpose() * right) +
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
  Eigen::MatrixXd rows(num_rows_, s.cols());
  for (std::size_t c = 0; c < pairs_.size(); ++c) {
    rows.middleRows(pairs_[c].row, pairs_[c].num_rows()) =
        pairs_[c].constraints(false).transpose() * s.middleRows<3>(3 * static_cast<Eigen::Index>(c));
  }
  return rows;
}

Eigen::MatrixXd PairElimination::Impulses(const Eigen::MatrixXd& lambda, const Eigen::MatrixXd& s,
                                          const Eigen::MatrixXd& dv) const {
  const Eigen::MatrixXd velocities = Relative(dv);
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
  Eigen::MatrixXd rows(num_rows_, s.cols());
  for (std::size_t c = 0; c < pairs_.size(); ++c) {
    const Pair& pair = pairs_[c];
    rows.middleRows(pair.row, pair.num_rows()) =
        -pair.weight * (pair.constraints(true).transpose() * s.middleRows<3>(3 * static_cast<Eigen::Index>(c)));
  }
  return rows;
}

Eigen::MatrixXd PairElimination::AdjointImpulses(const Eigen::MatrixXd& lambda, const Eigen::MatrixXd& s,
                                                 const Eigen::MatrixXd& y) const {
  const Eigen::MatrixXd sums = s + Relative(y);
  Eigen::MatrixXd impulses(s.rows(), s.cols());
  for (std::size_t c = 0; c < pairs_.size(); ++c) {
    const Eigen::Index row = 3 * static_cast<Eigen::Index>(c);
    impulses.middleRows<3>(row) =
        pairs_[c].AdjointImpulse(lambda.middleRows(pairs_[c].row, pairs_[c].num_rows()), sums.middleRows<3>(row));
  }
  return impulses;
}

}  // namespace clothid
