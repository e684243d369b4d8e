// Contacts of a cloth with itself taken out of the linear system of a step, whose impulses r are unknowns beside v.
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
// Then, as at an obstacle, what is known of a node leaves the unknowns. A pair has a slave, a node that follows the
// others of the pair: the row of C gives its velocity, along n or as a whole, and its momentum balance gives lambda. No
// node is the slave of two pairs, and none follows itself, directly or through others. So one pass over the pairs,
// masters before slaves, makes velocities fit C dv = 0 (Z), and one in the other direction frees the momentum balance
// of lambda (Q). Left is Q K~ Z, where Q = Z^T without friction, in the pattern of K, whichever pairs there are: a
// factor B of K or of what obstacles leave of it, of this point or another, gives the preconditioner Z B Z^T.
//
// Two kinds of pairs are more than that. One that hardly slips has kappa > d: there the preconditioner lets the slave
// follow along b as well, and has b . u as an unknown with a diagonal of its own. One that finds no slave, as all its
// nodes are slaves already, would follow themselves or touch obstacles, is loose: its lambda stay unknowns.
#ifndef CLOTHID_SIM_CONTACT_PAIR_ELIMINATION_H_
#define CLOTHID_SIM_CONTACT_PAIR_ELIMINATION_H_

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <array>
#include <vector>

#include "sim/contact/self_contact.h"
#include "sim/matrix/block_matrix.h"

namespace clothid {

class PairElimination {
 public:
  // Replaces what an earlier call has set; pairs that leave may be among `contacts`. `held`: blocks that touch
  // obstacles, which are no slaves. `hessian`: K, of which diagonal blocks are read.
  void SetContacts(const std::vector<PairContact>& contacts, const std::vector<int>& held, const BlockMatrix& hessian);

  Eigen::Index num_pairs() const { return static_cast<Eigen::Index>(pairs_.size()); }
  bool in_contact() const { return num_rows_ > 0; }  // false: every pair leaves
  Eigen::Index num_loose_rows() const { return num_loose_rows_; }
  bool has_friction() const { return has_friction_; }  // Q is not Z^T

  // Everything below is on columns: v and momenta [3 Nf x s], lambda and its rows [num_rows x s], those of loose pairs
  // [num_loose_rows x s], r and s [3 c x s]. `transposed`: C and E have changed places.

  // product += (K~ - K) v.
  void AddStiffness(const Eigen::MatrixXd& velocities, Eigen::MatrixXd* product) const;

  // v <- Z v, and momentum <- Q momentum.
  void Follow(bool transposed, Eigen::MatrixXd* velocities) const;
  void Unload(bool transposed, Eigen::MatrixXd* momentum) const;
  // The slaves' velocities become those with which d C v is `rows`, while the others stay.
  void FollowTo(bool transposed, const Eigen::MatrixXd& rows, Eigen::MatrixXd* velocities) const;

  // Of loose pairs: d C v; those of `rows` - d C v; momentum -= E^T lambda.
  Eigen::MatrixXd TimesLooseRows(bool transposed, const Eigen::MatrixXd& velocities) const;
  Eigen::MatrixXd LooseRest(bool transposed, const Eigen::MatrixXd& rows, const Eigen::MatrixXd& velocities) const;
  void SubtractLooseForces(bool transposed, const Eigen::MatrixXd& lambda, Eigen::MatrixXd* momentum) const;

  // Before and after B in the preconditioner: momentum <- Z^T momentum, by which b . u of pairs that hardly slip is
  // known, which is returned; v <- Z v + what they add.
  Eigen::MatrixXd Split(bool transposed, Eigen::MatrixXd* momentum) const;
  void Join(bool transposed, const Eigen::MatrixXd& sides, Eigen::MatrixXd* velocities) const;
  // Moves the nodes of loose pairs, as if they hung on nothing else, so that d C v becomes `rows`; returns the lambda.
  Eigen::MatrixXd JoinLoose(bool transposed, const Eigen::MatrixXd& rows, Eigen::MatrixXd* velocities) const;

  // All lambda, where `balance` is K~ v less its right side and `loose` those of loose pairs. Takes E^T lambda off
  // `balance`.
  Eigen::MatrixXd Multipliers(bool transposed, const Eigen::MatrixXd& loose, Eigen::MatrixXd* balance) const;

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
    std::array<int, 4> blocks;
    Eigen::Vector4d weights;  // w
    Eigen::Matrix3d frame;    // n, t, b of a slipping pair by columns
    double weight;            // d
    double coupling;          // q
    double compliance;        // 1/(1 - beta)
    double stiffness;         // kappa
    Eigen::Index row;         // of its first lambda
    int slave = -1;           // its place; -1: the pair leaves or is loose
    Eigen::Index loose_row = -1, side = -1;
    double side_compliance = 0.0;  // of b . u, where it is an unknown of the preconditioner

    bool sticks() const { return branch == ContactBranch::kStick; }
    Eigen::Index num_rows() const { return branch == ContactBranch::kTakeOff ? 0 : sticks() ? 3 : 1; }
    // By columns: the directions of its rows in C and in E [3 x num_rows].
    Eigen::Matrix3Xd constraints(bool transposed) const;
    Eigen::Matrix3Xd forces(bool transposed) const { return constraints(!transposed); }
    // u = J v; momentum += J^T r, of one column.
    Eigen::Vector3d Relative(const double* velocities) const;
    void Add(const Eigen::Vector3d& impulse, double* momentum) const;
    // The part of a change of u that its rows do not allow, as its slave takes it back; the impulse by which its slave
    // loses a momentum.
    Eigen::Vector3d Forbidden(bool transposed, const Eigen::Vector3d& relative) const;
    Eigen::Vector3d Load(bool transposed, const Eigen::Vector3d& momentum) const;
    // dr from its s and J dv; rho from its sum s + J y.
    Eigen::MatrixXd Impulse(const Eigen::MatrixXd& lambda, const Eigen::MatrixXd& right,
                            const Eigen::MatrixXd& velocities) const;
    Eigen::MatrixXd AdjointImpulse(const Eigen::MatrixXd& lambda, const Eigen::MatrixXd& sum) const;
  };

  static Pair MakePair(const PairContact& contact, Eigen::Index row);
  void NumberRows(const BlockMatrix& hessian);
  void FactorLooseRows(const BlockMatrix& hessian);
  Eigen::MatrixXd Relative(const Eigen::MatrixXd& velocities) const;  // J v
  Eigen::MatrixXd Spread(const Eigen::MatrixXd& impulses) const;      // J^T r

  std::vector<Pair> pairs_;
  std::vector<int> order_;  // of those with slaves, masters before slaves
  std::vector<int> loose_;
  Eigen::Index size_ = 0, num_rows_ = 0, num_loose_rows_ = 0, num_sides_ = 0;
  bool has_friction_ = false;
  std::vector<Eigen::Vector4d> loose_compliances_;  // 1/K_ii about, of the nodes of loose pairs
  Eigen::LLT<Eigen::MatrixXd> loose_factor_;        // of C 1/K C^T of their rows
};

}  // namespace clothid

#endif  // CLOTHID_SIM_CONTACT_PAIR_ELIMINATION_H_
