// A = (I + S) K - S D, the matrix of Eq. (29) of the DiffCloth paper (P - dP - dR there), at one point: factor, solve.
// Where the cloth touches itself, that in (v, r) of sim/contact/pair_elimination.h. Contacts of both kinds are
// eliminated, so that the pattern is always that of K.
//
// A factor outlives the point at which it was made: at a point near by it still is a preconditioner, for a fraction of
// the cost of a new one.
#ifndef CLOTHID_SIM_STEP_STEP_JACOBIAN_H_
#define CLOTHID_SIM_STEP_STEP_JACOBIAN_H_

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "sim/base/phase_seconds.h"
#include "sim/base/thread_team.h"
#include "sim/cloth/cloth_model.h"
#include "sim/contact/contact_elimination.h"
#include "sim/contact/contact_set.h"
#include "sim/contact/pair_elimination.h"
#include "sim/matrix/cholesky.h"
#include "sim/matrix/krylov.h"
#include "sim/matrix/lu.h"
#include "sim/step/freed_nodes.h"

namespace clothid {

// The Cholesky factor of the matrix that contacts with obstacles leave of K, in the local frames that slipping nodes
// had. Shared, never changed.
struct ReducedFactor {
  std::shared_ptr<const CholeskyFactor> cholesky;
  HeldBlocks held;

  std::size_t bytes() const { return cholesky->bytes() + held.bytes(); }
};

// Columns over the unknowns (v, r) or the equations of a step.
struct StepColumns {
  Eigen::MatrixXd velocities;     // [3 Nf x s]
  Eigen::MatrixXd impulses = {};  // of the pairs of the cloth with itself [3 c x s]; may be empty where there are none

  StepColumns& operator+=(const StepColumns& other) {
    velocities += other.velocities;
    impulses += other.impulses;
    return *this;
  }
  StepColumns& operator-=(const StepColumns& other) {
    velocities -= other.velocities;
    impulses -= other.impulses;
    return *this;
  }
};

class StepJacobian {
 public:
  enum class Method {
    kReduced,  // contacts eliminated, Cholesky of the symmetric rest, friction coupling by GMRES
    kLu,       // sparse LU of A
  };

  explicit StepJacobian(const ClothModel& model);

  // That share the work of large factors, their solves and products, 1 at first. The numbers do not depend on them.
  void SetNumThreads(int num_threads);
  int num_threads() const { return num_threads_; }
  bool has_team() const { return team_ != nullptr; }  // whether there are others than the caller's
  ThreadTeam* team() { return team_.get(); }          // null: the caller alone

  // A at a point: `hessian` is K and must outlive the solves.
  void SetPoint(const BlockMatrix& hessian, const ContactSet& contacts);

  // Factors A at the point. False where the reduced matrix is not positive definite or A is singular, and for kLu where
  // pairs are in contact.
  bool Factor(Method method);

  // Both at once.
  bool Factor(Method method, const BlockMatrix& hessian, const ContactSet& contacts);

  // Where pairs are in contact, K itself may be indefinite, although what they leave of it is not. Factors `positive`,
  // which is near K, to precondition A at the point.
  bool FactorInstead(const BlockMatrix& positive);

  // The factor of the reduced matrix that solves use: of the last Factor(kReduced), whatever the point was, or the one
  // given here. Null: none.
  const std::shared_ptr<const ReducedFactor>& factor() const { return factor_; }
  void SetFactor(std::shared_ptr<const ReducedFactor> factor);

  // A (dv, dr) = right to a relative residual of `tolerance` wherever the solution is iterative: with a factor of
  // another point, with friction, or with pairs in contact. False: it was not reached, or, for one right-hand side with
  // a factor of another point, a direction of negative curvature was met.
  bool Solve(const StepColumns& right, double tolerance, StepColumns* solution);

  // A^T (z, rho) = right and y = (I + S)^T z.
  bool SolveTransposed(const StepColumns& right, double tolerance, StepColumns* z, Eigen::MatrixXd* y);

  // Floating-point operations of a factorisation over the entries of L: what one costs in solves grows with that.
  double factor_flops_per_entry() const { return cholesky_.num_flops() / cholesky_.num_entries(); }

  int iterations() const { return iterations_; }  // of the last solve; 0: direct

  // v <- (I + S) v, with the contacts of the point.
  void AddImpulse(Eigen::MatrixXd* vectors) const;

  // Where the time went so far. Whoever assembles and evaluates for this object adds to it, too.
  PhaseSeconds& seconds() { return seconds_; }

 private:
  enum class Direction { kForward, kTransposed };
  // Right side and solution of the reduced system, above those of loose pairs.
  bool SolveReduced(Direction direction, const Eigen::MatrixXd& right, double tolerance, Eigen::MatrixXd* q);
  bool SolveByConjugateGradients(const Eigen::MatrixXd& right, double tolerance, Eigen::MatrixXd* q);
  Eigen::MatrixXd TimesStiffness(const Eigen::MatrixXd& velocities) const;  // K v, or K~ v
  Eigen::MatrixXd ApplyReduced(Direction direction, const Eigen::MatrixXd& q) const;
  // What is left of the right sides of momentum and pairs where contacts give `known` velocities.
  Eigen::MatrixXd ReducedRight(const Eigen::MatrixXd& momentum, const Eigen::MatrixXd& rows,
                               Eigen::MatrixXd* known) const;
  // The velocities that a solution of the reduced system stands for.
  Eigen::MatrixXd VelocitiesOf(Direction direction, Eigen::MatrixXd q) const;
  void SolveWithFactor(const Eigen::MatrixXd& vectors, Eigen::MatrixXd* result);
  Eigen::MatrixXd ApplyHeldFactor(const Eigen::MatrixXd& vectors);  // of what was held where it was made
  Eigen::MatrixXd ApplyFactor(const Eigen::MatrixXd& vectors);
  void FindFreedNodes();
  Eigen::MatrixXd Precondition(Direction direction, const Eigen::MatrixXd& q);
  bool FactorReduced(const BlockMatrix& matrix);
  const Eigen::VectorXd& ReducedValues(const BlockMatrix& matrix);  // of what a factor is made of
  int MostIterations() const;
  bool has_coupling() const;
  bool may_have_pairs() const { return pairs_ != nullptr && pairs_->num_pairs() > 0; }  // at the point
  bool has_pairs() const { return pairs_ != nullptr && pairs_->in_contact(); }          // in contact, likewise
  Eigen::Index num_loose_rows() const { return has_pairs() ? pairs_->num_loose_rows() : 0; }

  const ClothModel& model_;
  Method method_ = Method::kReduced;
  const BlockMatrix* hessian_ = nullptr;
  CholeskySolver cholesky_;
  std::shared_ptr<const ReducedFactor> factor_;
  SinglePrecisionFactor preconditioner_;  // the factor, where it is large and of another point
  bool factor_is_of_point_ = false;
  bool is_factored_instead_ = false;                 // the point has no factor of its own
  std::unique_ptr<LuFactor> lu_;                     // made when first asked for
  std::unique_ptr<ContactElimination> elimination_;  // null in a scene without obstacles
  bool in_contact_ = false;                          // with obstacles, at the point
  std::unique_ptr<FreedNodes> freed_;                // since the factor; null without obstacles or where it is small
  bool freed_are_known_ = false;                     // of this point and this factor
  std::unique_ptr<PairElimination> pairs_;           // null in a scene without self-contact
  Eigen::VectorXd values_;                           // of the factored matrix, where it is not K itself
  int iterations_ = 0;
  int num_threads_ = 1;
  std::unique_ptr<ThreadTeam> team_;  // null: the caller alone
  PhaseSeconds seconds_;
};

}  // namespace clothid

#endif  // CLOTHID_SIM_STEP_STEP_JACOBIAN_H_
