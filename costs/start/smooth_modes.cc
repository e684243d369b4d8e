#include "costs/start/smooth_modes.h"

#include <Spectra/SymEigsShiftSolver.h>

#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>
#include <algorithm>
#include <stdexcept>

#include "sim/matrix/dense.h"
#include "sim/shell/triangle_element.h"

namespace clothid {
namespace {

// Up to so many unknowns the whole spectrum is cheap.
constexpr Eigen::Index kSmallProblem = 200;
// Below the spectrum, in units of its smallest positive values: L is singular where nothing is fixed.
constexpr double kRelativeShift = -0.1;

// M^-1/2 L M^-1/2 over the nodes of `moving`.
Eigen::SparseMatrix<double> ScaledLaplacian(const ClothModel& model, const std::vector<int>& moving) {
  std::vector<int> index(static_cast<std::size_t>(model.num_nodes()), -1);
  for (std::size_t i = 0; i < moving.size(); ++i) index[moving[i]] = static_cast<int>(i);
  const Eigen::SparseMatrix<double> all = LaplacianMatrix(model.triangles(), model.num_nodes());
  std::vector<Eigen::Triplet<double>> entries;
  for (const int node : moving) {
    for (Eigen::SparseMatrix<double>::InnerIterator it(all, node); it; ++it) {
      const auto row = static_cast<int>(it.row());
      if (index[row] < 0) continue;
      const double scale = 1.0 / std::sqrt(model.node_areas()[row] * model.node_areas()[node]);
      entries.emplace_back(index[row], index[node], scale * it.value());
    }
  }
  const auto size = static_cast<Eigen::Index>(moving.size());
  Eigen::SparseMatrix<double> scaled(size, size);
  scaled.setFromTriplets(entries.begin(), entries.end());
  return scaled;
}

// (A - shift I)^-1 of a symmetric A with a shift below its spectrum, as Spectra asks for it.
class ShiftedInverse {
 public:
  using Scalar = double;

  explicit ShiftedInverse(const Eigen::SparseMatrix<double>& matrix) : matrix_(matrix) {}

  Eigen::Index rows() const { return matrix_.rows(); }
  Eigen::Index cols() const { return matrix_.cols(); }
  void set_shift(double shift) {
    factor_.setShift(-shift);
    factor_.compute(matrix_);
    if (factor_.info() != Eigen::Success) throw std::runtime_error("the Laplacian of the cloth is not definite");
  }
  void perform_op(const double* x, double* y) const {
    Eigen::Map<Eigen::VectorXd>(y, rows()) = factor_.solve(Eigen::Map<const Eigen::VectorXd>(x, rows()));
  }

 private:
  const Eigen::SparseMatrix<double>& matrix_;
  Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> factor_;
};

// The lowest eigenvectors, in ascending order.
Eigen::MatrixXd LowestVectors(const Eigen::SparseMatrix<double>& matrix, double area, Eigen::Index count) {
  if (matrix.rows() <= std::max(kSmallProblem, 3 * count)) {
    return SymmetricSpectrum(Eigen::MatrixXd(matrix)).vectors.leftCols(count);
  }
  ShiftedInverse shifted(matrix);
  // The lowest positive eigenvalues of a sheet are about pi^2/area.
  Spectra::SymEigsShiftSolver<ShiftedInverse> solver(shifted, count, std::min(matrix.rows(), 2 * count + 20),
                                                     kRelativeShift / area);
  solver.init();
  solver.compute(Spectra::SortRule::LargestMagn);
  if (solver.info() != Spectra::CompInfo::Successful) throw std::runtime_error("the modes of the cloth were not found");
  return solver.eigenvectors().rowwise().reverse();
}

}  // namespace

Eigen::MatrixXd SmoothModes(const ClothModel& model, const std::vector<int>& fixed, int count) {
  std::vector<bool> is_fixed(static_cast<std::size_t>(model.num_nodes()), false);
  for (const int node : fixed) is_fixed[node] = true;
  std::vector<int> moving;
  for (int node = 0; node < model.num_nodes(); ++node) {
    if (!is_fixed[node]) moving.push_back(node);
  }
  const double area = model.node_areas().sum();
  const Eigen::Index num_modes = std::min<Eigen::Index>(count, static_cast<Eigen::Index>(moving.size()));
  const Eigen::MatrixXd vectors = LowestVectors(ScaledLaplacian(model, moving), area, num_modes);
  Eigen::MatrixXd modes = Eigen::MatrixXd::Zero(model.num_nodes(), num_modes);
  for (std::size_t i = 0; i < moving.size(); ++i) {
    modes.row(moving[i]) = std::sqrt(area / model.node_areas()[moving[i]]) * vectors.row(static_cast<Eigen::Index>(i));
  }
  return modes;
}

Eigen::MatrixXd AlongAxes(const Eigen::MatrixXd& modes) {
  Eigen::MatrixXd columns = Eigen::MatrixXd::Zero(3 * modes.rows(), 3 * modes.cols());
  for (Eigen::Index m = 0; m < modes.cols(); ++m) {
    for (int axis = 0; axis < 3; ++axis) {
      for (Eigen::Index node = 0; node < modes.rows(); ++node) columns(3 * node + axis, 3 * m + axis) = modes(node, m);
    }
  }
  return columns;
}

}  // namespace clothid
