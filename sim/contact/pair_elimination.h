// Contacts of a cloth with itself in the linear system of a step, whose impulses r are unknowns beside v.
//
// With J of the pairs in contact, S and D of the obstacles' contacts (contact_elimination.h) and P = dPi/da of each
// pair (self_contact.h), diagonal in its axes n, t, b but for friction: P = n n^T + q t n^T + beta b b^T, q = -mu,
// 0 <= beta < 1 for a pair that slips, the identity for one that sticks, zero for one that leaves,
//   (I + S)(K dv - J^T dr) - S D dv = f
//   d P J dv + (I - P) dr           = s
// What the second row gives at once is taken out: dr of a pair that leaves, and of one that slips all but
// lambda = n . dr. Left are kappa = d beta/(1 - beta) in the stiffness K~ = K + sum kappa J^T b b^T J and
//   [ K~   -E^T ] [dv    ]      C, E: rows of J at sticking pairs, n . J and (n + q t) . J at slipping ones
//   [ d C    0  ] [lambda]
// Its preconditioner is the augmented Lagrangian of pairs without friction (Benzi and Olshanskii 2006), in which one
// Cholesky factor of
//   M = K~ + gamma C^T d C
// gives v = M^-1 (f + gamma C^T e) and lambda = gamma (e - d C v). Rows of C that depend on each other do no harm to M.
#ifndef CLOTHID_SIM_CONTACT_PAIR_ELIMINATION_H_
#define CLOTHID_SIM_CONTACT_PAIR_ELIMINATION_H_

#include <Eigen/Core>
#include <Eigen/SparseCore>
#include <array>
#include <vector>

#include "sim/contact/self_contact.h"
#include "sim/matrix/block_matrix.h"

namespace clothid {

class PairElimination {
 public:
  // Replaces what an earlier call has set; pairs that leave may be among them. `size`: 3 Nf.
  void SetContacts(const std::vector<PairContact>& contacts, Eigen::Index size);

  Eigen::Index num_pairs() const { return static_cast<Eigen::Index>(pairs_.size()); }
  Eigen::Index num_rows() const { return row_weights_.size(); }              // of lambda; 0 where every pair leaves
  const std::vector<std::array<int, 4>>& blocks() const { return blocks_; }  // of the nodes of all pairs
  std::vector<std::array<int, 4>> ClosedBlocks() const;                      // of those that stay

  // Everything below is on columns: v [3 Nf x s], lambda and e [num_rows x s], r and s [3 c x s].
  Eigen::MatrixXd Spread(const Eigen::MatrixXd& impulses) const {
    return velocity_rows_.transpose() * impulses;
  }  // J^T
  // product += (K~ - K) v.
  void AddStiffness(const Eigen::MatrixXd& velocities, Eigen::MatrixXd* product) const;
  // momentum -= E^T lambda, or C^T lambda of the transposed matrix, and the rows d C v, or d E v.
  void SubtractForces(bool transposed, const Eigen::MatrixXd& lambda, Eigen::MatrixXd* momentum) const;
  Eigen::MatrixXd TimesRows(bool transposed, const Eigen::MatrixXd& velocities) const;

  // matrix += M - K, in a pattern that covers the pairs that stay.
  void AddAugmented(BlockMatrix* matrix) const;
  // v += gamma C^T e, and lambda = gamma (e - d C v).
  void AddPenalty(const Eigen::MatrixXd& e, Eigen::MatrixXd* velocities) const;
  Eigen::MatrixXd PenaltyImpulses(const Eigen::MatrixXd& e, const Eigen::MatrixXd& velocities) const;

  // Forwards, from s: the part of J^T dr that it gives at once, the right side of d C dv, and dr.
  Eigen::MatrixXd KnownMomentum(const Eigen::MatrixXd& s) const;
  Eigen::MatrixXd RightRows(const Eigen::MatrixXd& s) const;
  Eigen::MatrixXd Impulses(const Eigen::MatrixXd& lambda, const Eigen::MatrixXd& s, const Eigen::MatrixXd& dv) const;

  // Of the transposed matrix times (z, rho), which is (w, s), with y = (I + S)^T z: what w loses, the right side of
  // d E y, and rho. Its multipliers lambda have the sign that makes both systems look alike.
  Eigen::MatrixXd KnownMomentumTransposed(const Eigen::MatrixXd& s) const;
  Eigen::MatrixXd RightRowsTransposed(const Eigen::MatrixXd& s) const;
  Eigen::MatrixXd AdjointImpulses(const Eigen::MatrixXd& lambda, const Eigen::MatrixXd& s,
                                  const Eigen::MatrixXd& y) const;

 private:
  struct Pair {
    ContactBranch branch;
    Eigen::Matrix3d frame;  // n, t, b of a slipping pair by columns
    double weight;          // d
    double coupling;        // q
    double compliance;      // 1/(1 - beta)
    double stiffness;       // kappa
    Eigen::Index row;       // of its first lambda

    Eigen::Index num_rows() const {
      return branch == ContactBranch::kTakeOff ? 0 : branch == ContactBranch::kStick ? 3 : 1;
    }
    // By columns: the directions of its rows in C and in E [3 x num_rows].
    Eigen::Matrix3Xd constraints() const;
    Eigen::Matrix3Xd forces() const;
    // dr from its s and J dv; rho from its sum s + J y.
    Eigen::MatrixXd Impulse(const Eigen::MatrixXd& lambda, const Eigen::MatrixXd& right,
                            const Eigen::MatrixXd& velocities) const;
    Eigen::MatrixXd AdjointImpulse(const Eigen::MatrixXd& lambda, const Eigen::MatrixXd& sum) const;
  };
  using Rows = Eigen::SparseMatrix<double, Eigen::RowMajor>;

  static Pair MakePair(const PairContact& contact, Eigen::Index row);
  void SetRows(const std::vector<PairContact>& contacts, Eigen::Index size);

  std::vector<Pair> pairs_;
  std::vector<std::array<int, 4>> blocks_;
  std::vector<Eigen::Vector4d> weights_;  // w
  Rows velocity_rows_;                    // J [3c x 3 Nf]
  Rows constraint_rows_, force_rows_;     // C and E
  Rows side_rows_;                        // b . J of pairs that slip
  Eigen::VectorXd row_weights_;           // d of the rows of C
  Eigen::VectorXd side_stiffness_;        // kappa
};

}  // namespace clothid

#endif  // CLOTHID_SIM_CONTACT_PAIR_ELIMINATION_H_
