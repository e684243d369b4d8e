#include "sim/step/pair_jacobian.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <iterator>
#include <limits>
#include <utility>

#include "sim/matrix/block_product.h"
#include "sim/matrix/krylov.h"

namespace clothid {
namespace {

// gamma, over d: the larger, the fewer iterations and the more digits of K are lost in M.
constexpr double kPenalty = 1e3;
constexpr int kMaxPairIterations = 120;
constexpr int kMaxLaggedPairIterations = 15;  // with the factor of another point
constexpr int kMaxKeptPairIterations = 24;    // with one that was kept for a derivative, to all its digits
constexpr int kMostKeptChanges = 2;  // of contacts since a factor that was kept, which then serves a derivative
// 1 - beta of a slipping pair is held above this, which bounds kappa as u_T -> 0.
constexpr double kSmallestSlip = 1e-12;

std::vector<std::array<int, 4>> Cliques(const std::vector<PairCandidate>& candidates) {
  std::vector<std::array<int, 4>> cliques;
  cliques.reserve(candidates.size());
  for (const PairCandidate& candidate : candidates) cliques.push_back(candidate.blocks);
  return cliques;
}

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

// Of two ascending lists: entries that are in one of them alone.
template <class Entry>
int NumDifferences(const std::vector<Entry>& first, const std::vector<Entry>& second) {
  std::vector<Entry> differences;
  std::set_symmetric_difference(first.begin(), first.end(), second.begin(), second.end(),
                                std::back_inserter(differences));
  return static_cast<int>(differences.size());
}

}  // namespace

Eigen::Matrix3Xd PairJacobian::Pair::constraints() const {
  if (branch == ContactBranch::kStick) return Eigen::Matrix3d::Identity();
  return frame.leftCols(num_rows());
}

Eigen::Matrix3Xd PairJacobian::Pair::forces() const {
  if (branch == ContactBranch::kStick) return Eigen::Matrix3d::Identity();
  return (frame.col(0) + coupling * frame.col(1)).rowwise().replicate(num_rows());
}

PairJacobian::PairJacobian(const ClothModel& model, StepJacobian* shared) : model_(model), shared_(*shared) {}

void PairJacobian::SetCandidates(const std::vector<PairCandidate>& candidates) { cliques_ = Cliques(candidates); }

void PairJacobian::Reset() {
  pattern_.reset();
  factor_.reset();
}

bool PairJacobian::UseFactor(std::shared_ptr<const ReducedFactor> factor) {
  if (factor == nullptr || factor->pattern == nullptr) return false;
  pattern_ = factor->pattern;
  factor_ = factor->cholesky == nullptr ? nullptr : std::move(factor);
  factor_is_of_point_ = false;
  factor_was_given_ = true;
  return num_changes() <= kMostKeptChanges;
}

void PairJacobian::SetPoint(const BlockMatrix& hessian, const std::vector<Contact>& contacts,
                            const std::vector<double>& friction_coefficients, const std::vector<PairContact>& pairs,
                            double self_friction) {
  const ScopedTimer timer(&shared_.seconds().contact);
  hessian_ = &hessian;
  factor_is_of_point_ = false;
  touches_obstacles_ = !contacts.empty();
  if (touches_obstacles_) elimination_.SetContacts(contacts, model_.free_index(), friction_coefficients);
  pairs_.clear();
  int num_rows = 0;
  for (const PairContact& contact : pairs) {
    Pair pair{contact.response.branch, Eigen::Matrix3d::Identity(), contact.candidate.weight, 0.0, 1.0, 0.0, num_rows};
    if (pair.branch == ContactBranch::kSlip) {
      const Eigen::Vector3d& n = contact.candidate.geometry.normal;
      const Eigen::Vector3d& t = contact.response.slip_direction;
      const double friction = contact.candidate.FrictionOf(self_friction);
      pair.frame << n, t, n.cross(t);
      pair.coupling = -friction;
      const double beta = -SlipRatio(contact.response, friction);
      pair.compliance = 1.0 / std::max(1.0 - beta, kSmallestSlip);
      pair.stiffness = pair.weight * beta * pair.compliance;
    }
    num_rows += pair.num_rows();
    pairs_.push_back(pair);
  }
  SetClosed(contacts, pairs);
  SetRows(pairs);
}

void PairJacobian::SetClosed(const std::vector<Contact>& contacts, const std::vector<PairContact>& pairs) {
  closed_ = {};
  for (const Contact& contact : contacts) closed_.nodes.emplace_back(contact.candidate.node, contact.response.branch);
  for (const PairContact& contact : pairs) {
    if (contact.response.branch == ContactBranch::kTakeOff) continue;
    closed_.pairs.emplace_back(contact.candidate.features, contact.response.branch);
  }
}

int PairJacobian::num_changes() const {
  if (factor_ == nullptr) return std::numeric_limits<int>::max();
  return NumDifferences(closed_.nodes, factor_->contacts.nodes) +
         NumDifferences(closed_.pairs, factor_->contacts.pairs);
}

void PairJacobian::SetRows(const std::vector<PairContact>& contacts) {
  const Eigen::Index size = 3 * model_.num_free(), num_pairs = static_cast<Eigen::Index>(pairs_.size());
  Triplets velocity, constraint, force, side;
  std::vector<double> row_weights, side_stiffness;
  blocks_.clear();
  weights_.clear();
  for (Eigen::Index c = 0; c < num_pairs; ++c) {
    const Pair& pair = pairs_[c];
    blocks_.push_back(contacts[c].candidate.blocks);
    weights_.push_back(contacts[c].candidate.geometry.weights);
    AddRows(contacts[c].candidate, Eigen::Matrix3d::Identity(), 3 * c, &velocity);
    AddRows(contacts[c].candidate, pair.constraints(), pair.row, &constraint);
    AddRows(contacts[c].candidate, pair.forces(), pair.row, &force);
    row_weights.insert(row_weights.end(), pair.num_rows(), pair.weight);
    if (pair.stiffness == 0.0) continue;
    AddRows(contacts[c].candidate, pair.frame.col(2), static_cast<Eigen::Index>(side_stiffness.size()), &side);
    side_stiffness.push_back(pair.stiffness);
  }
  const auto set = [size](const Triplets& triplets, Eigen::Index num_rows, Rows* rows) {
    rows->resize(num_rows, size);
    rows->setFromTriplets(triplets.begin(), triplets.end());
  };
  row_weights_ = Eigen::Map<Eigen::VectorXd>(row_weights.data(), static_cast<Eigen::Index>(row_weights.size()));
  side_stiffness_ =
      Eigen::Map<Eigen::VectorXd>(side_stiffness.data(), static_cast<Eigen::Index>(side_stiffness.size()));
  set(velocity, 3 * num_pairs, &velocity_rows_);
  set(constraint, row_weights_.size(), &constraint_rows_);
  set(force, row_weights_.size(), &force_rows_);
  set(side, side_stiffness_.size(), &side_rows_);
}

BlockMatrix PairJacobian::AugmentedMatrix() const {
  BlockMatrix wide = pattern_->Widened(*hessian_);
  for (std::size_t c = 0; c < pairs_.size(); ++c) {
    const Pair& pair = pairs_[c];
    if (pair.branch == ContactBranch::kTakeOff) continue;
    const Eigen::Matrix3Xd constraints = pair.constraints();
    const Eigen::Vector3d b = pair.frame.col(2);
    const Eigen::Matrix3d stiffness =
        kPenalty * pair.weight * constraints * constraints.transpose() + pair.stiffness * b * b.transpose();
    for (int i = 0; i < 4; ++i) {
      for (int j = 0; j < 4; ++j) {
        if (blocks_[c][i] < 0 || blocks_[c][j] < 0) continue;
        wide.block(wide.pattern().Find(blocks_[c][i], blocks_[c][j])) += weights_[c][i] * weights_[c][j] * stiffness;
      }
    }
  }
  return wide;
}

bool PairJacobian::Factor() {
  factor_.reset();  // first, so that its memory can be used again
  std::vector<std::array<int, 4>> closed;
  for (std::size_t c = 0; c < pairs_.size(); ++c) {
    if (pairs_[c].branch != ContactBranch::kTakeOff) closed.push_back(blocks_[c]);
  }
  if (pattern_ == nullptr || !pattern_->Covers(closed)) {
    const ScopedTimer timer(&shared_.seconds().factorization);
    pattern_ = std::make_shared<const WidePattern>(*model_.pattern(), cliques_);
  }
  Eigen::VectorXd values;
  {
    const ScopedTimer timer(&shared_.seconds().contact);
    BlockMatrix wide = AugmentedMatrix();
    if (touches_obstacles_) {
      elimination_.Reduce(wide, &values);
    } else {
      values.swap(wide.values);
    }
  }
  const ScopedTimer timer(&shared_.seconds().factorization);
  ReducedFactor factor{pattern_->Factor(values, shared_.team()), {}, pattern_, closed_};
  if (factor.cholesky == nullptr) return false;
  if (touches_obstacles_) factor.frames = elimination_.SlipFrames();
  factor_ = std::make_shared<const ReducedFactor>(std::move(factor));
  factor_is_of_point_ = true;
  factor_was_given_ = false;
  return true;
}

Eigen::MatrixXd PairJacobian::Spread(const Eigen::MatrixXd& impulses) const {
  return velocity_rows_.transpose() * impulses;
}

Eigen::MatrixXd PairJacobian::RelativeVelocities(const Eigen::MatrixXd& velocities) const {
  return velocity_rows_ * velocities;
}

void PairJacobian::AddImpulse(Eigen::MatrixXd* vectors) const {
  if (touches_obstacles_) elimination_.AddImpulse(vectors);
}

Eigen::MatrixXd PairJacobian::TimesStiffness(const Eigen::MatrixXd& velocities) const {
  Eigen::MatrixXd product = MultiplySymmetric(*hessian_, velocities, shared_.team());
  if (side_stiffness_.size() == 0) return product;
  const Eigen::MatrixXd sides = side_stiffness_.asDiagonal() * (side_rows_ * velocities);
  product += side_rows_.transpose() * sides;
  return product;
}

// Of (q, lambda), the multipliers of the transposed matrix negated: both then have the signs of the forward one.
Eigen::MatrixXd PairJacobian::Multiply(Direction direction, const Eigen::MatrixXd& stacked) const {
  const bool forward = direction == Direction::kForward;
  const Eigen::Index size = 3 * model_.num_free(), num_rows = row_weights_.size();
  const Eigen::MatrixXd q = stacked.topRows(size), lambda = stacked.bottomRows(num_rows);
  Eigen::MatrixXd v = q;
  if (touches_obstacles_ && !forward) elimination_.AddFrictionTransposed(&v);
  Eigen::MatrixXd momentum = TimesStiffness(v);
  momentum -= (forward ? force_rows_ : constraint_rows_).transpose() * lambda;
  if (touches_obstacles_) {
    if (forward) elimination_.AddFriction(&momentum);
    elimination_.Project(&momentum);
    elimination_.AddSlipStiffness(q, &momentum);
  }
  const Eigen::MatrixXd velocities = (forward ? constraint_rows_ : force_rows_) * v;
  Eigen::MatrixXd result(stacked.rows(), stacked.cols());
  result << momentum, row_weights_.asDiagonal() * velocities;
  return result;
}

// v = M^-1 (f + gamma C^T e), lambda = gamma (e - d C v): what is left of the second row is lambda/gamma.
Eigen::MatrixXd PairJacobian::Precondition(const Eigen::MatrixXd& stacked) const {
  const Eigen::Index size = 3 * model_.num_free(), num_rows = row_weights_.size();
  const Eigen::MatrixXd e = stacked.bottomRows(num_rows);
  Eigen::MatrixXd v = stacked.topRows(size);
  v += kPenalty * (constraint_rows_.transpose() * e);
  if (touches_obstacles_) elimination_.Project(&v);
  ToLocal(factor_->frames, &v);
  v = factor_->pattern->Solve(*factor_->cholesky, v, shared_.team());
  ToWorld(factor_->frames, &v);
  if (touches_obstacles_) elimination_.Project(&v);
  const Eigen::MatrixXd velocities = constraint_rows_ * v;
  Eigen::MatrixXd result(stacked.rows(), stacked.cols());
  result << v, kPenalty * (e - row_weights_.asDiagonal() * velocities);
  return result;
}

bool PairJacobian::SolveStacked(Direction direction, const Eigen::MatrixXd& right, double tolerance,
                                Eigen::MatrixXd* solution) {
  const GmresResult result = Gmres([&](const Eigen::MatrixXd& v) { return Multiply(direction, v); },
                                   [&](const Eigen::MatrixXd& v) { return Precondition(v); }, right, tolerance,
                                   factor_is_of_point_ ? kMaxPairIterations
                                   : factor_was_given_ ? kMaxKeptPairIterations
                                                       : kMaxLaggedPairIterations,
                                   solution);
  iterations_ = result.iterations;
  return result.converged && solution->allFinite();
}

Eigen::MatrixXd PairJacobian::Impulse(const Pair& pair, const Eigen::MatrixXd& lambda, const Eigen::MatrixXd& right,
                                      const Eigen::MatrixXd& velocities) const {
  if (pair.branch == ContactBranch::kTakeOff) return right;
  if (pair.branch == ContactBranch::kStick) return lambda;
  const Eigen::Vector3d n = pair.frame.col(0), t = pair.frame.col(1), b = pair.frame.col(2);
  return pair.forces() * lambda + t * ((t - pair.coupling * n).transpose() * right) +
         b * (b.transpose() * (pair.compliance * right - pair.stiffness * velocities));
}

Eigen::MatrixXd PairJacobian::KnownImpulse(const Eigen::MatrixXd& right) const {
  Eigen::MatrixXd known = Eigen::MatrixXd::Zero(right.rows(), right.cols());
  const Eigen::MatrixXd at_rest = Eigen::MatrixXd::Zero(3, right.cols());
  for (std::size_t c = 0; c < pairs_.size(); ++c) {
    const Pair& pair = pairs_[c];
    if (pair.branch == ContactBranch::kStick) continue;
    const Eigen::Index row = 3 * static_cast<Eigen::Index>(c);
    known.middleRows<3>(row) =
        Impulse(pair, Eigen::MatrixXd::Zero(pair.num_rows(), right.cols()), right.middleRows<3>(row), at_rest);
  }
  return Spread(known);
}

bool PairJacobian::Solve(const Eigen::MatrixXd& f, const Eigen::MatrixXd& s, double tolerance, Eigen::MatrixXd* dv,
                         Eigen::MatrixXd* dr) {
  const ScopedTimer timer(&shared_.seconds().solution);
  const Eigen::Index size = 3 * model_.num_free();
  Eigen::MatrixXd right = KnownImpulse(s), known, constraints(row_weights_.size(), f.cols());
  AddImpulse(&right);
  right += f;
  for (std::size_t c = 0; c < pairs_.size(); ++c) {
    constraints.middleRows(pairs_[c].row, pairs_[c].num_rows()) =
        pairs_[c].constraints().transpose() * s.middleRows<3>(3 * static_cast<Eigen::Index>(c));
  }
  if (touches_obstacles_) {
    known = elimination_.KnownPart(right);
    right = elimination_.ReducedRight(right, known, TimesStiffness(known));
    const Eigen::MatrixXd velocities = constraint_rows_ * known;
    constraints -= row_weights_.asDiagonal() * velocities;
  }
  Eigen::MatrixXd stacked(size + constraints.rows(), f.cols()), solution;
  stacked << right, constraints;
  if (!SolveStacked(Direction::kForward, stacked, tolerance, &solution)) return false;
  *dv = solution.topRows(size);
  if (!factor_is_of_point_ && f.cols() == 1 && dv->col(0).dot(TimesStiffness(*dv).col(0)) < 0.0) return false;
  if (touches_obstacles_) *dv += known;
  const Eigen::MatrixXd velocities = RelativeVelocities(*dv);
  dr->resize(s.rows(), s.cols());
  for (std::size_t c = 0; c < pairs_.size(); ++c) {
    const Eigen::Index row = 3 * static_cast<Eigen::Index>(c);
    dr->middleRows<3>(row) = Impulse(pairs_[c], solution.middleRows(size + pairs_[c].row, pairs_[c].num_rows()),
                                     s.middleRows<3>(row), velocities.middleRows<3>(row));
  }
  return true;
}

Eigen::MatrixXd PairJacobian::AdjointImpulse(const Pair& pair, const Eigen::MatrixXd& lambda,
                                             const Eigen::MatrixXd& sum) const {
  if (pair.branch == ContactBranch::kTakeOff) return sum;
  if (pair.branch == ContactBranch::kStick) return lambda / pair.weight;
  const Eigen::Vector3d n = pair.frame.col(0), t = pair.frame.col(1), b = pair.frame.col(2);
  const Eigen::RowVectorXd along = t.transpose() * sum;
  return n * (lambda / pair.weight - pair.coupling * along) + t * along + (pair.compliance * b) * (b.transpose() * sum);
}

// With y = (I + S)^T z: a pair that leaves has rho = s + J y; one that sticks J y = -s and d rho = lambda; one that
// slips (n + q t) . J y = -(n + q t) . s, rho_t = t . (s + J y), rho_b = b . (s + J y)/(1 - beta) and
// d (rho_n + q rho_t) = lambda.
bool PairJacobian::SolveTransposed(const Eigen::MatrixXd& w, const Eigen::MatrixXd& s, double tolerance,
                                   Eigen::MatrixXd* z, Eigen::MatrixXd* y, Eigen::MatrixXd* rho) {
  const ScopedTimer timer(&shared_.seconds().solution);
  const Eigen::Index size = 3 * model_.num_free();
  Eigen::MatrixXd sides = Eigen::MatrixXd::Zero(s.rows(), s.cols()), constraints(row_weights_.size(), w.cols());
  for (std::size_t c = 0; c < pairs_.size(); ++c) {
    const Pair& pair = pairs_[c];
    const Eigen::Index row = 3 * static_cast<Eigen::Index>(c);
    const Eigen::Vector3d b = pair.frame.col(2);
    sides.middleRows<3>(row) = pair.stiffness * b * (b.transpose() * s.middleRows<3>(row));
    constraints.middleRows(pair.row, pair.num_rows()) =
        -pair.weight * (pair.forces().transpose() * s.middleRows<3>(row));
  }
  const Eigen::MatrixXd right = w - Spread(sides);
  Eigen::MatrixXd projected = right, stacked(size + constraints.rows(), w.cols()), solution;
  if (touches_obstacles_) elimination_.Project(&projected);
  stacked << projected, constraints;
  if (!SolveStacked(Direction::kTransposed, stacked, tolerance, &solution)) return false;
  const Eigen::MatrixXd q = solution.topRows(size), lambda = -solution.bottomRows(constraints.rows());
  *y = *z = q;
  if (touches_obstacles_) {
    elimination_.AddFrictionTransposed(y);
    Eigen::MatrixXd balance = TimesStiffness(*y);
    balance += constraint_rows_.transpose() * lambda;
    *z = elimination_.RecoverAdjoint(right, q, balance);
  }
  const Eigen::MatrixXd sums = s + RelativeVelocities(*y);
  rho->resize(s.rows(), s.cols());
  for (std::size_t c = 0; c < pairs_.size(); ++c) {
    const Eigen::Index row = 3 * static_cast<Eigen::Index>(c);
    rho->middleRows<3>(row) =
        AdjointImpulse(pairs_[c], lambda.middleRows(pairs_[c].row, pairs_[c].num_rows()), sums.middleRows<3>(row));
  }
  return true;
}

}  // namespace clothid
