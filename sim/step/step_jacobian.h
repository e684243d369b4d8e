// A = (I + S) K - S D, the matrix of Eq. (29) of the DiffCloth paper (P - dP - dR there), at one point: factor, solve.
// Where the cloth touches itself, that in (v, r) of sim/contact/pair_elimination.h.
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

namespace clothid {

class WidePattern;

// The Cholesky factor of a reduced matrix, in the local frames that its slipping nodes had. Shared, never changed.
struct ReducedFactor {
  std::shared_ptr<const CholeskyFactor> cholesky;  // null: there is but a pattern, for another factor
  std::vector<LocalFrame> frames;
  // Where the cloth may touch itself: its pattern, null for that of the model, and the contacts of its point.
  std::shared_ptr<const WidePattern> pattern = nullptr;
  ContactRecords contacts = {};

  std::size_t bytes() const;
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

  // Factors A at the point. Pairs in contact want a pattern of their own: that at hand, or, where it lacks one of them,
  // a new one that covers all pairs of the point, with a new order of elimination. False where the reduced matrix is
  // not positive definite or A is singular, and for kLu where pairs are in contact.
  bool Factor(Method method);

  // Both at once.
  bool Factor(Method method, const BlockMatrix& hessian, const ContactSet& contacts);

  // The factor of the reduced matrix that solves use: of the last Factor(kReduced), whatever the point was, or the one
  // given here, whose pattern then is at hand. Null: none.
  const std::shared_ptr<const ReducedFactor>& factor() const { return factor_; }
  void SetFactor(std::shared_ptr<const ReducedFactor> factor);
  // Whether there is a factor that may solve where `contacts` are: made where the cloth does not touch itself either,
  // or where at most `most` contacts were others or in other branches.
  bool HasFactorNear(const ContactSet& contacts, int most) const;
  const std::shared_ptr<const WidePattern>& pattern() const { return pattern_; }  // at hand; null: none
  void SetPattern(std::shared_ptr<const WidePattern> pattern) { pattern_ = std::move(pattern); }
  // Forgets factor and pattern.
  void Reset();

  // A (dv, dr) = right to a relative residual of `tolerance` wherever the solution is iterative: with a factor of
  // another point, with friction, or with pairs in contact. False: it was not reached, or, for one right-hand side with
  // a factor of another point, a direction of negative curvature was met.
  bool Solve(const StepColumns& right, double tolerance, StepColumns* solution);

  // A^T (z, rho) = right and y = (I + S)^T z.
  bool SolveTransposed(const StepColumns& right, double tolerance, StepColumns* z, Eigen::MatrixXd* y);

  // Floating-point operations of a factorisation over the entries of L, of the factor at hand where there is one: what
  // one costs in solves grows with that.
  double factor_flops_per_entry() const;

  int iterations() const { return iterations_; }  // of the last solve; 0: direct

  // v <- (I + S) v, with the contacts of the point.
  void AddImpulse(Eigen::MatrixXd* vectors) const;

  // Where the time went so far. Whoever assembles and evaluates for this object adds to it, too.
  PhaseSeconds& seconds() { return seconds_; }

 private:
  enum class Direction { kForward, kTransposed };
  // Where pairs are in contact, q and right are (q, lambda) and its right-hand side, one above the other.
  bool SolveReduced(Direction direction, const Eigen::MatrixXd& right, double tolerance, Eigen::MatrixXd* q);
  bool SolveByConjugateGradients(const Eigen::MatrixXd& right, double tolerance, Eigen::MatrixXd* q);
  Eigen::MatrixXd TimesStiffness(const Eigen::MatrixXd& velocities) const;  // K v, or K~ v
  Eigen::MatrixXd ApplyReduced(Direction direction, const Eigen::MatrixXd& q) const;
  void SolveWithFactor(const Eigen::MatrixXd& vectors, Eigen::MatrixXd* result);
  Eigen::MatrixXd ApplyFactor(const Eigen::MatrixXd& vectors);
  Eigen::MatrixXd Precondition(const Eigen::MatrixXd& q);
  const Eigen::VectorXd& ReducedValues(const BlockMatrix& matrix);  // of what a factor is made of
  std::shared_ptr<const CholeskyFactor> FactorWithPairs();
  int MostIterations() const;
  bool has_coupling() const { return in_contact_ && elimination_->has_coupling(); }
  bool may_have_pairs() const { return pairs_ != nullptr && pairs_->num_pairs() > 0; }  // at the point
  bool has_pairs() const { return pairs_ != nullptr && pairs_->num_rows() > 0; }        // in contact, likewise

  const ClothModel& model_;
  Method method_ = Method::kReduced;
  const BlockMatrix* hessian_ = nullptr;
  CholeskySolver cholesky_;
  std::shared_ptr<const ReducedFactor> factor_;
  SinglePrecisionFactor preconditioner_;  // the factor, where it is large and of another point
  bool factor_is_of_point_ = false;
  std::unique_ptr<LuFactor> lu_;                     // made when first asked for
  std::unique_ptr<ContactElimination> elimination_;  // null in a scene without obstacles
  bool in_contact_ = false;                          // with obstacles, at the point
  std::unique_ptr<PairElimination> pairs_;           // null in a scene without self-contact
  ContactRecords closed_;                            // at the point, likewise
  std::shared_ptr<const WidePattern> pattern_;       // the last one that was made or given; null: none
  Eigen::VectorXd values_;                           // of the factored matrix, where it is not K itself
  int iterations_ = 0;
  int num_threads_ = 1;
  std::unique_ptr<ThreadTeam> team_;  // null: the caller alone
  PhaseSeconds seconds_;
};

}  // namespace clothid

#endif  // CLOTHID_SIM_STEP_STEP_JACOBIAN_H_
