#include "sim/cloth/system_matrix.h"

#include <Eigen/CholmodSupport>
#include <stdexcept>
#include <vector>

#include "sim/shell/triangle_element.h"

namespace clothid {
namespace {

class TripletAssembly {
 public:
  explicit TripletAssembly(const ClothModel& model) : free_index_(model.free_index()) {}

  void Add(int node, int other_node, double value) {
    const int row = free_index_[node], column = free_index_[other_node];
    if (row >= 0 && column >= 0) triplets_.emplace_back(row, column, value);
  }

  Eigen::SparseMatrix<double> Matrix(int size) const {
    Eigen::SparseMatrix<double> matrix(size, size);
    matrix.setFromTriplets(triplets_.begin(), triplets_.end());
    return matrix;
  }

 private:
  const std::vector<int>& free_index_;
  std::vector<Eigen::Triplet<double>> triplets_;
};

void AddMatrix(double factor, const Eigen::SparseMatrix<double>& matrix, TripletAssembly* assembly) {
  for (int column = 0; column < matrix.outerSize(); ++column) {
    for (Eigen::SparseMatrix<double>::InnerIterator it(matrix, column); it; ++it) {
      assembly->Add(static_cast<int>(it.row()), column, factor * it.value());
    }
  }
}

}  // namespace

Eigen::SparseMatrix<double> AssembleSystemMatrix(const ClothModel& model, const Material& material, double time_step) {
  TripletAssembly assembly(model);
  const NodeForces& nodes = model.nodes();
  const double areal_mass = nodes.ArealSlope(material, time_step);
  for (const int node : model.free_nodes()) {
    const double further = nodes.has_density_field() ? nodes.FurtherSlope(material, time_step, node) : 0.0;
    assembly.Add(node, node, areal_mass * nodes.areas()[node] + further);
  }
  AddMatrix(model.forces().LaplacianWeight(material, time_step), LaplacianMatrix(model.triangles(), model.num_nodes()),
            &assembly);
  for (const auto& term : model.forces().terms()) {
    if (const auto part = term->SystemPart(material, time_step)) AddMatrix(part->weight, *part->matrix, &assembly);
  }
  return assembly.Matrix(model.num_free());
}

// d_j = P_jj of P = M + h c_d diag(a) + h^2 (k L + k_b Q + Q_s) + h eta L.
double SystemDiagonal(const ClothModel& model, const Material& material, double time_step, int node) {
  double diagonal = model.nodes().ArealSlope(material, time_step) * model.node_areas()[node];
  for (const auto& term : model.forces().terms()) {
    diagonal += term->LaplacianWeight(material, time_step) * model.laplacian_diagonal()[node];
  }
  for (const auto& term : model.forces().terms()) {
    const auto part = term->SystemPart(material, time_step);
    if (part) diagonal += part->weight * (*part->diagonal)[node];
  }
  return diagonal;
}

// Simplicial: without BLAS, which threads would have to take turns in, and for a matrix this small as fast.
struct SystemMatrixFactor::State {
  Eigen::CholmodSimplicialLLT<Eigen::SparseMatrix<double>> cholesky;
};

SystemMatrixFactor::SystemMatrixFactor(const ClothModel& model, const Material& material, double time_step)
    : time_step_(time_step), state_(std::make_unique<State>()) {
  state_->cholesky.compute(AssembleSystemMatrix(model, material, time_step));
  if (state_->cholesky.info() != Eigen::Success) throw std::runtime_error("CHOLMOD could not factor the system matrix");
}

SystemMatrixFactor::~SystemMatrixFactor() = default;

// The axes of all columns are right-hand sides of the scalar matrix, side by side.
Eigen::MatrixXd SystemMatrixFactor::Solve(const Eigen::MatrixXd& right) const {
  if (right.size() == 0) return right;  // for CHOLMOD an invalid argument
  const Eigen::Index num_free = right.rows() / 3;
  Eigen::MatrixXd axes(num_free, 3 * right.cols());
  for (Eigen::Index c = 0; c < right.cols(); ++c) {
    axes.middleCols<3>(3 * c) = right.col(c).reshaped(3, num_free).transpose();
  }
  const Eigen::MatrixXd solved = state_->cholesky.solve(axes);
  if (state_->cholesky.info() != Eigen::Success) throw std::runtime_error("CHOLMOD could not solve with P");
  Eigen::MatrixXd solution(right.rows(), right.cols());
  for (Eigen::Index c = 0; c < right.cols(); ++c) {
    solution.col(c).reshaped(3, num_free) = solved.middleCols<3>(3 * c).transpose();
  }
  return solution;
}

}  // namespace clothid
