#include "sim/matrix/dense.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/QR>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <limits>

namespace clothid {
namespace {

// What of singular values is the rounding of zero.
double RoundingOf(const Eigen::VectorXd& values, Eigen::Index num_rows) {
  return static_cast<double>(num_rows) * std::numeric_limits<double>::epsilon() * values.maxCoeff();
}

bool AreRegular(const Eigen::VectorXd& values, Eigen::Index num_rows) {
  return values.size() == 0 || values.minCoeff() > RoundingOf(values, num_rows);
}

}  // namespace

Spectrum SymmetricSpectrum(const Eigen::MatrixXd& a) {
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(a);
  return {solver.eigenvalues(), solver.eigenvectors()};
}

Eigen::VectorXd SymmetricEigenvalues(const Eigen::MatrixXd& a) {
  return Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(a, Eigen::EigenvaluesOnly).eigenvalues();
}

Spectrum3 SymmetricSpectrum(const Eigen::Matrix3d& a) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(a);
  return {solver.eigenvalues(), solver.eigenvectors()};
}

// By Cayley and Hamilton: A^1/2 = (A + d I) / sqrt(tr A + 2 d), d = sqrt(det A).
Eigen::Matrix2d InverseSquareRoot(const Eigen::Matrix2d& a) {
  const double root = std::sqrt(a(0, 0) * a(1, 1) - a(0, 1) * a(1, 0));
  const double scale = root * std::sqrt(a(0, 0) + a(1, 1) + 2.0 * root);
  return Eigen::Matrix2d{{(a(1, 1) + root) / scale, -a(0, 1) / scale}, {-a(1, 0) / scale, (a(0, 0) + root) / scale}};
}

struct SymmetricFactor::Factor {
  Eigen::LDLT<Eigen::MatrixXd> ldlt;
};

SymmetricFactor::SymmetricFactor(const Eigen::MatrixXd& a) : factor_(new Factor{Eigen::LDLT<Eigen::MatrixXd>(a)}) {}
SymmetricFactor::~SymmetricFactor() = default;

Eigen::VectorXd SymmetricFactor::SolveOne(const Eigen::VectorXd& right) const { return factor_->ldlt.solve(right); }
Eigen::MatrixXd SymmetricFactor::Solve(const Eigen::MatrixXd& right) const { return factor_->ldlt.solve(right); }
Eigen::MatrixXd SymmetricFactor::Inverse() const {
  return Solve(Eigen::MatrixXd::Identity(factor_->ldlt.rows(), factor_->ldlt.cols()));
}

Eigen::MatrixXd TransposedRoot(const Eigen::MatrixXd& a) {
  const Spectrum spectrum = SymmetricSpectrum(a);
  return spectrum.values.cwiseMax(0.0).cwiseSqrt().asDiagonal() * spectrum.vectors.transpose();
}

Eigen::MatrixXd UpperFactor(const Eigen::MatrixXd& a) {
  const Eigen::HouseholderQR<Eigen::MatrixXd> qr(a);
  return qr.matrixQR().topRows(a.cols()).triangularView<Eigen::Upper>();
}

RightSingular RightSingularVectors(const Eigen::MatrixXd& a) {
  const Eigen::JacobiSVD<Eigen::MatrixXd> svd(a, Eigen::ComputeThinV);
  return {svd.singularValues(), svd.matrixV()};
}

// From R of A = Q R, or, where that is singular, from its singular values.
Eigen::MatrixXd GramPseudoInverse(const Eigen::MatrixXd& a) {
  Eigen::MatrixXd padded = Eigen::MatrixXd::Zero(std::max(a.rows(), a.cols()), a.cols());
  padded.topRows(a.rows()) = a;
  const Eigen::MatrixXd factor = UpperFactor(padded);
  Eigen::MatrixXd root = Eigen::MatrixXd::Identity(a.cols(), a.cols());
  if (AreRegular(factor.diagonal().cwiseAbs(), padded.rows())) {
    factor.triangularView<Eigen::Upper>().solveInPlace(root);
  } else {
    const RightSingular svd = RightSingularVectors(factor);
    const double least = RoundingOf(svd.values, padded.rows());
    const Eigen::ArrayXd inverses = (svd.values.array() > least).select(svd.values.array().inverse(), 0.0);
    root = svd.vectors * inverses.matrix().asDiagonal();
  }
  return root * root.transpose();
}

std::optional<Eigen::VectorXd> LeastSquaresResiduals(const Eigen::MatrixXd& a, const Eigen::VectorXd& values) {
  if (a.rows() < a.cols()) return std::nullopt;
  const RightSingular svd = RightSingularVectors(a);
  if (!AreRegular(svd.values, a.rows())) return std::nullopt;
  const Eigen::MatrixXd basis = a * svd.vectors * svd.values.cwiseInverse().asDiagonal();  // U
  return values - basis * (basis.transpose() * values);
}

Eigen::MatrixXd LeastSquaresSolution(const Eigen::MatrixXd& a, const Eigen::MatrixXd& right) {
  if (a.size() == 0) return Eigen::MatrixXd::Zero(a.cols(), right.cols());  // Eigen expects an entry
  const Eigen::JacobiSVD<Eigen::MatrixXd> svd(a, Eigen::ComputeThinU | Eigen::ComputeThinV);
  const Eigen::VectorXd& values = svd.singularValues();
  const double least = RoundingOf(values, std::max(a.rows(), a.cols()));
  const Eigen::VectorXd inverses = (values.array() > least).select(values.array().inverse(), 0.0);
  return svd.matrixV() * (inverses.asDiagonal() * (svd.matrixU().transpose() * right));
}

// The quaternion (1 + cos, from x to) / sqrt(2 (1 + cos)) of unit vectors.
Eigen::Matrix3d ShortestTurn(const Eigen::Vector3d& from, const Eigen::Vector3d& to) {
  const Eigen::Vector3d a = from.normalized(), b = to.normalized();
  const double cosine = a.dot(b);
  constexpr double kOpposite = -1.0 + 1e-12;
  if (cosine < kOpposite) {
    const Eigen::Vector3d axis = a.unitOrthogonal();
    return 2.0 * axis * axis.transpose() - Eigen::Matrix3d::Identity();
  }
  const double root = std::sqrt((1.0 + cosine) * 2.0);
  Eigen::Quaterniond turn;
  turn.vec() = a.cross(b) * (1.0 / root);
  turn.w() = root * 0.5;
  return turn.toRotationMatrix();
}

Eigen::Matrix3d NearestRotation(const Eigen::Matrix3d& matrix) {
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(matrix, Eigen::ComputeFullU | Eigen::ComputeFullV);
  return svd.matrixU() * svd.matrixV().transpose();
}

Eigen::Isometry3d RigidMotion(const Eigen::Matrix3Xd& from, const Eigen::Matrix3Xd& to) {
  return Eigen::Isometry3d(Eigen::umeyama(from, to, false));
}

bool IsCollinear(const Eigen::Matrix3Xd& points, double tolerance) {
  const Eigen::Matrix3Xd centered = points.colwise() - points.rowwise().mean();
  const Eigen::Vector3d squares = SymmetricSpectrum(Eigen::Matrix3d(centered * centered.transpose())).values;
  const Eigen::Vector3d extents = squares.cwiseMax(0.0).cwiseSqrt();
  return !(extents[1] > tolerance * extents[2]);
}

}  // namespace clothid
