// Decompositions of dense matrices. Each of Eigen's takes seconds to compile wherever it is used, so all of them are
// compiled here, once.
#ifndef CLOTHID_SIM_MATRIX_DENSE_H_
#define CLOTHID_SIM_MATRIX_DENSE_H_

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <memory>
#include <optional>

namespace clothid {

// A = V diag(values) V^T of a symmetric A [n x n], of which the lower triangle is read. Eigenvalues ascend.
struct Spectrum {
  Eigen::VectorXd values;   // [n]
  Eigen::MatrixXd vectors;  // [n x n], a column each
};
Spectrum SymmetricSpectrum(const Eigen::MatrixXd& a);
Eigen::VectorXd SymmetricEigenvalues(const Eigen::MatrixXd& a);

struct Spectrum3 {
  Eigen::Vector3d values;
  Eigen::Matrix3d vectors;
};
Spectrum3 SymmetricSpectrum(const Eigen::Matrix3d& a);

// A^-1/2 of a symmetric positive definite A.
Eigen::Matrix2d InverseSquareRoot(const Eigen::Matrix2d& a);

// P^T L D L^T P of a symmetric A [n x n], positive or negative semidefinite. Where it is singular or not finite, so are
// the solutions.
class SymmetricFactor {
 public:
  explicit SymmetricFactor(const Eigen::MatrixXd& a);
  ~SymmetricFactor();
  SymmetricFactor(const SymmetricFactor&) = delete;
  SymmetricFactor& operator=(const SymmetricFactor&) = delete;

  Eigen::VectorXd SolveOne(const Eigen::VectorXd& right) const;  // A^-1 right [n]
  Eigen::MatrixXd Solve(const Eigen::MatrixXd& right) const;     // A^-1 right [n x s]
  Eigen::MatrixXd Inverse() const;                               // [n x n]

 private:
  struct Factor;
  std::unique_ptr<Factor> factor_;
};

// C^T with C C^T = A of a symmetric, positive semidefinite A [n x n]; negative eigenvalues are taken for the rounding
// of zero.
Eigen::MatrixXd TransposedRoot(const Eigen::MatrixXd& a);

// R of A = Q R, A [m x n], m >= n: upper triangular [n x n].
Eigen::MatrixXd UpperFactor(const Eigen::MatrixXd& a);

// Of A = U diag(values) V^T [m x n], m >= n: singular values, descending, and V [n x n].
struct RightSingular {
  Eigen::VectorXd values;
  Eigen::MatrixXd vectors;
};
RightSingular RightSingularVectors(const Eigen::MatrixXd& a);

// (A^T A)^+ [n x n] of any A [m x n].
Eigen::MatrixXd GramPseudoInverse(const Eigen::MatrixXd& a);

// `values` - A x of least squares [m]; nothing where the columns of A [m x n] are dependent.
std::optional<Eigen::VectorXd> LeastSquaresResiduals(const Eigen::MatrixXd& a, const Eigen::VectorXd& values);

// x [n x s] of least squares, A x = `right`, for any A [m x n]: of all that are equally good the shortest, by columns.
Eigen::MatrixXd LeastSquaresSolution(const Eigen::MatrixXd& a, const Eigen::MatrixXd& right);

// The smallest rotation that takes the direction of `from` to that of `to`; where they are opposite, a half turn about
// an axis across them. Neither is zero.
Eigen::Matrix3d ShortestTurn(const Eigen::Vector3d& from, const Eigen::Vector3d& to);

// The rotation that is nearest to a matrix that is nearly one.
Eigen::Matrix3d NearestRotation(const Eigen::Matrix3d& matrix);

// The rigid motion that takes the points `from` [3 x P] nearest to `to` in the sense of least squares, P >= 1 (Umeyama,
// IEEE PAMI 1991, without scale).
Eigen::Isometry3d RigidMotion(const Eigen::Matrix3Xd& from, const Eigen::Matrix3Xd& to);

// Whether points [3 x P] lie on a line, but for `tolerance` of its length.
bool IsCollinear(const Eigen::Matrix3Xd& points, double tolerance);

}  // namespace clothid

#endif  // CLOTHID_SIM_MATRIX_DENSE_H_
