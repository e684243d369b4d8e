// A = (I + S) K - S D, the matrix of Eq. (29) of the DiffCloth paper (P - dP - dR there), at one point: factor, solve.
#ifndef CLOTHID_SIM_STEP_JACOBIAN_H_
#define CLOTHID_SIM_STEP_JACOBIAN_H_

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "sim/cloth_model.h"
#include "sim/contact.h"
#include "sim/contact_elimination.h"
#include "sim/linear_solver.h"
#include "sim/phase_seconds.h"

namespace clothid {

class StepJacobian {
 public:
  enum class Method {
    kReduced,  // contacts eliminated, Cholesky of the symmetric rest, friction coupling by GMRES
    kLu,       // sparse LU of A
  };

  explicit StepJacobian(const ClothModel& model);

  // `hessian` is K and must outlive the solves. False where the reduced matrix is not positive definite or A is
  // singular.
  bool Factor(Method method, const BlockMatrix& hessian, const std::vector<Contact>& contacts,
              const std::vector<double>& friction_coefficients);

  // A dv = right, [3 Nf x s], to a relative residual of `tolerance` in the friction coupling. False: it was not
  // reached.
  bool Solve(const Eigen::MatrixXd& right, double tolerance, Eigen::MatrixXd* dv);

  // A^T z = right and y = (I + S)^T z.
  bool SolveTransposed(const Eigen::MatrixXd& right, double tolerance, Eigen::MatrixXd* z, Eigen::MatrixXd* y);

  // v <- (I + S) v, with the contacts of the last Factor.
  void AddImpulse(Eigen::MatrixXd* vectors) const;

  // Where the time went so far. Whoever assembles and evaluates for this object adds to it, too.
  PhaseSeconds& seconds() { return seconds_; }

 private:
  enum class Direction { kForward, kTransposed };
  bool SolveReduced(Direction direction, const Eigen::MatrixXd& right, double tolerance, Eigen::MatrixXd* q);
  Eigen::MatrixXd ApplyReduced(Direction direction, const Eigen::MatrixXd& q) const;
  Eigen::MatrixXd ApplyFactor(const Eigen::MatrixXd& vectors);

  const ClothModel& model_;
  Method method_ = Method::kReduced;
  const BlockMatrix* hessian_ = nullptr;
  CholeskyFactor cholesky_;
  std::unique_ptr<LuFactor> lu_;                     // made when first asked for
  std::unique_ptr<ContactElimination> elimination_;  // null in a scene without obstacles
  bool in_contact_ = false;                          // of the last Factor
  Eigen::VectorXd values_;                           // of the factored matrix, where it is not K itself
  PhaseSeconds seconds_;
};

}  // namespace clothid

#endif  // CLOTHID_SIM_STEP_JACOBIAN_H_
