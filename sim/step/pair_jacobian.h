// The matrix of a step whose cloth touches itself, in (v, r): factor and solve, forwards and transposed.
//
// With J of the pairs in contact, S and D of the obstacles' contacts (step_jacobian.h) and P = dPi/da of each pair
// (sim/contact/self_contact.h), diagonal in its axes n, t, b but for friction: P = n n^T + q t n^T + beta b b^T,
// q = -mu, 0 <= beta < 1 for a pair that slips, the identity for one that sticks, zero for one that leaves,
//   (I + S)(K dv - J^T dr) - S D dv = f
//   d P J dv + (I - P) dr           = s
// What the second row gives at once is taken out: dr of a pair that leaves, and of one that slips all but
// lambda = n . dr. Left are kappa = d beta/(1 - beta) in the stiffness K~ = K + sum kappa J^T b b^T J and
//   [ K~   -E^T ] [dv    ]      C, E: rows of J at sticking pairs, n . J and (n + q t) . J at slipping ones
//   [ C      0  ] [lambda]
// It is solved by GMRES, with the augmented Lagrangian of a pair without friction as a preconditioner (Benzi and
// Olshanskii 2006): one Cholesky factor of
//   M = Z^T (K~ + gamma C^T d C) Z
// in the frames of the obstacles' contacts (contact_elimination.h). Rows of C that depend on each other do no harm to
// M.
#ifndef CLOTHID_SIM_STEP_PAIR_JACOBIAN_H_
#define CLOTHID_SIM_STEP_PAIR_JACOBIAN_H_

#include <Eigen/Core>
#include <Eigen/SparseCore>
#include <array>
#include <memory>
#include <utility>
#include <vector>

#include "sim/cloth/cloth_model.h"
#include "sim/contact/contact_elimination.h"
#include "sim/contact/self_contact.h"
#include "sim/matrix/block_matrix.h"
#include "sim/step/step_jacobian.h"
#include "sim/step/wide_pattern.h"

namespace clothid {

class PairJacobian {
 public:
  // With the threads and the timers of `shared`, which must outlive the object.
  PairJacobian(const ClothModel& model, StepJacobian* shared);

  // The pairs that the next points and factors may have.
  void SetCandidates(const std::vector<PairCandidate>& candidates);
  // Forgets pattern and factor, which numbers depend on in their last digits.
  void Reset();

  // The matrix at a point: `hessian` is K and must outlive the solves; `pairs` are among the candidates, in their
  // order.
  void SetPoint(const BlockMatrix& hessian, const std::vector<Contact>& contacts,
                const std::vector<double>& friction_coefficients, const std::vector<PairContact>& pairs,
                double self_friction);

  // Makes the factor of the point, in the order of the factor at hand or before, or, where that lacks a pair in contact,
  // in a new one that covers all candidates. False where M is not positive definite.
  bool Factor();
  // The factor that solves use, which has a pattern of its own: of the last Factor, whatever the point was, or the last
  // one given. Null: none.
  const std::shared_ptr<const ReducedFactor>& factor() const { return factor_; }
  // Solves with `factor`, which was made by another object of the model, in its place. False where there is none, or
  // one of a point too far from this one for that to pay: its pattern then serves the next Factor.
  bool UseFactor(std::shared_ptr<const ReducedFactor> factor);
  const std::shared_ptr<const WidePattern>& pattern() const { return pattern_; }  // of the last factor; null: none yet
  // Contacts that are in another branch than at the point of the factor at hand, which serves the better the fewer they
  // are; more than there can be without a factor.
  int num_changes() const;

  // Columns: dv, f [3 Nf x s], dr, s [3 c x s]. To a relative residual of `tolerance`, with the factor at hand; false:
  // it was not reached, or, with a factor of another point, the step would go up (see step_jacobian.h).
  bool Solve(const Eigen::MatrixXd& f, const Eigen::MatrixXd& s, double tolerance, Eigen::MatrixXd* dv,
             Eigen::MatrixXd* dr);

  // The transposed matrix times (z, rho) is (w, s); y = (I + S)^T z.
  bool SolveTransposed(const Eigen::MatrixXd& w, const Eigen::MatrixXd& s, double tolerance, Eigen::MatrixXd* z,
                       Eigen::MatrixXd* y, Eigen::MatrixXd* rho);

  // On columns: J^T r [3 Nf x s] of [3 c x s], J v, and v <- (I + S) v.
  Eigen::MatrixXd Spread(const Eigen::MatrixXd& impulses) const;
  Eigen::MatrixXd RelativeVelocities(const Eigen::MatrixXd& velocities) const;
  void AddImpulse(Eigen::MatrixXd* vectors) const;

  int iterations() const { return iterations_; }  // of the last solve

 private:
  struct Pair {
    ContactBranch branch;
    Eigen::Matrix3d frame;  // n, t, b of a slipping pair by columns
    double weight;          // d
    double coupling;        // q
    double compliance;      // 1/(1 - beta)
    double stiffness;       // kappa
    int row;                // of its first lambda

    int num_rows() const { return branch == ContactBranch::kTakeOff ? 0 : branch == ContactBranch::kStick ? 3 : 1; }
    // By columns: the directions of its rows in C and in E [3 x num_rows].
    Eigen::Matrix3Xd constraints() const;
    Eigen::Matrix3Xd forces() const;
  };
  using Rows = Eigen::SparseMatrix<double, Eigen::RowMajor>;
  enum class Direction { kForward, kTransposed };

  void SetClosed(const std::vector<Contact>& contacts, const std::vector<PairContact>& pairs);
  void SetRows(const std::vector<PairContact>& contacts);
  Eigen::MatrixXd TimesStiffness(const Eigen::MatrixXd& velocities) const;  // K~ v
  Eigen::MatrixXd Multiply(Direction direction, const Eigen::MatrixXd& stacked) const;
  Eigen::MatrixXd Precondition(const Eigen::MatrixXd& stacked) const;
  bool SolveStacked(Direction direction, const Eigen::MatrixXd& right, double tolerance, Eigen::MatrixXd* solution);
  BlockMatrix AugmentedMatrix() const;  // K~ + gamma C^T d C, in the pattern
  // dr of a pair: `right` is its s, `velocities` its J dv.
  Eigen::MatrixXd Impulse(const Pair& pair, const Eigen::MatrixXd& lambda, const Eigen::MatrixXd& right,
                          const Eigen::MatrixXd& velocities) const;
  // The part of J^T dr [3 Nf x s] that `right` gives at once.
  Eigen::MatrixXd KnownImpulse(const Eigen::MatrixXd& right) const;
  // rho of a pair; `sum` is its s + J y.
  Eigen::MatrixXd AdjointImpulse(const Pair& pair, const Eigen::MatrixXd& lambda, const Eigen::MatrixXd& sum) const;

  const ClothModel& model_;
  StepJacobian& shared_;
  std::vector<std::array<int, 4>> cliques_;     // of the candidates
  std::shared_ptr<const WidePattern> pattern_;  // of the last factor
  const BlockMatrix* hessian_ = nullptr;
  ContactElimination elimination_;
  bool touches_obstacles_ = false;
  std::vector<Pair> pairs_;
  std::vector<std::array<int, 4>> blocks_;  // of the nodes of pairs
  std::vector<Eigen::Vector4d> weights_;    // w
  Rows velocity_rows_;                      // J [3c x 3 Nf]
  Rows constraint_rows_, force_rows_;       // C and E
  Rows side_rows_;                          // b . J of pairs that slip
  Eigen::VectorXd row_weights_;             // d of the rows of C
  Eigen::VectorXd side_stiffness_;          // kappa
  std::shared_ptr<const ReducedFactor> factor_;
  ClosedContacts closed_;  // at the point
  bool factor_is_of_point_ = false;
  bool factor_was_given_ = false;
  int iterations_ = 0;
};

}  // namespace clothid

#endif  // CLOTHID_SIM_STEP_PAIR_JACOBIAN_H_
