#include "sim/matrix/linear_solver.h"

#include <cholmod.h>
#include <dlfcn.h>
#include <omp.h>
#include <signal.h>
#include <umfpack.h>

#include <Eigen/Jacobi>
#include <algorithm>
#include <cmath>
#include <mutex>
#include <new>
#include <stdexcept>
#include <vector>

namespace clothid {
namespace {

// Whether BLAS is OpenBLAS without threads. Debian builds it without USE_LOCKING: calls from two threads at once share
// work buffers and give wrong numbers.
bool BlasNeedsLock() {
  using GetParallel = int (*)();
  const auto get_parallel = reinterpret_cast<GetParallel>(dlsym(RTLD_DEFAULT, "openblas_get_parallel"));
  return get_parallel != nullptr && get_parallel() == 0;
}

// METIS takes SIGTERM and SIGABRT for its own while it orders a matrix, and a SIGTERM of anybody else is lost. Held
// back in this thread, it arrives when METIS is done.
cholmod_factor* Analyze(cholmod_sparse* matrix, cholmod_common* common) {
  sigset_t held, before;
  sigemptyset(&held);
  sigaddset(&held, SIGTERM);
  pthread_sigmask(SIG_BLOCK, &held, &before);
  cholmod_factor* factor = cholmod_analyze(matrix, common);
  pthread_sigmask(SIG_SETMASK, &before, nullptr);
  return factor;
}

// Around every call that ends in BLAS.
//
// Rollouts run side by side in threads, so nothing within one of them may be parallel: OpenMP regions of the calling
// thread stay on that thread (Debian's CHOLMOD asks for four threads whatever the machine has). And where BLAS itself
// must not be called by two threads at once, they take turns.
class FactorizationScope {
 public:
  FactorizationScope() : openmp_levels_(omp_get_max_active_levels()) {
    static const bool needs_lock = BlasNeedsLock();
    static std::mutex blas_mutex;
    if (needs_lock) lock_ = std::unique_lock<std::mutex>(blas_mutex);
    omp_set_max_active_levels(0);
  }
  ~FactorizationScope() { omp_set_max_active_levels(openmp_levels_); }
  FactorizationScope(const FactorizationScope&) = delete;
  FactorizationScope& operator=(const FactorizationScope&) = delete;

 private:
  int openmp_levels_;
  std::unique_lock<std::mutex> lock_;
};

}  // namespace

struct CholeskySolver::State {
  explicit State(std::shared_ptr<const BlockPattern> p) : pattern(std::move(p)) { cholmod_start(&common); }
  ~State() {
    for (cholmod_factor* factor : unused) cholmod_free_factor(&factor, &common);
    cholmod_free_factor(&symbolic, &common);
    cholmod_free_dense(&work_y, &common);
    cholmod_free_dense(&work_e, &common);
    cholmod_finish(&common);
  }

  // A view of the pattern with `values` (null: the pattern alone); only the lower triangle is read.
  cholmod_sparse View(const double* values) const {
    cholmod_sparse matrix = {};
    matrix.nrow = matrix.ncol = pattern->size();
    matrix.nzmax = pattern->num_values();
    matrix.p = const_cast<int*>(pattern->outer().data());
    matrix.i = const_cast<int*>(pattern->inner().data());
    matrix.x = const_cast<double*>(values);
    matrix.stype = -1;
    matrix.itype = CHOLMOD_INT;
    matrix.xtype = values == nullptr ? CHOLMOD_PATTERN : CHOLMOD_REAL;
    matrix.dtype = CHOLMOD_DOUBLE;
    matrix.sorted = 1;
    matrix.packed = 1;
    return matrix;
  }

  std::shared_ptr<const BlockPattern> pattern;
  cholmod_common common;
  cholmod_factor* symbolic = nullptr;
  std::vector<cholmod_factor*> unused;  // numeric ones, of factors that are gone
  cholmod_dense* work_y = nullptr;      // CHOLMOD's work space of solves
  cholmod_dense* work_e = nullptr;
};

struct CholeskyFactor::Numeric {
  Numeric(std::shared_ptr<CholeskySolver::State> s, cholmod_factor* f) : state(std::move(s)), factor(f) {}
  ~Numeric() { state->unused.push_back(factor); }
  std::shared_ptr<CholeskySolver::State> state;
  cholmod_factor* factor;
};

CholeskyFactor::CholeskyFactor(std::unique_ptr<Numeric> numeric) : numeric_(std::move(numeric)) {}
CholeskyFactor::~CholeskyFactor() = default;

void CholeskyFactor::Solve(const Eigen::MatrixXd& right, Eigen::MatrixXd* solution) const {
  const FactorizationScope scope;
  solution->resize(right.rows(), right.cols());
  const auto view = [](const Eigen::MatrixXd& columns) {
    cholmod_dense dense = {};
    dense.nrow = dense.d = columns.rows();
    dense.ncol = columns.cols();
    dense.nzmax = columns.size();
    dense.x = const_cast<double*>(columns.data());
    dense.xtype = CHOLMOD_REAL;
    dense.dtype = CHOLMOD_DOUBLE;
    return dense;
  };
  CholeskySolver::State& state = *numeric_->state;
  cholmod_dense b = view(right), x = view(*solution);
  cholmod_dense* result = &x;  // large enough, so CHOLMOD writes to it in place
  cholmod_solve2(CHOLMOD_A, numeric_->factor, &b, nullptr, &result, nullptr, &state.work_y, &state.work_e,
                 &state.common);
}

std::size_t CholeskyFactor::bytes() const {
  const cholmod_factor& factor = *numeric_->factor;
  return sizeof(double) * (factor.is_super ? factor.xsize : factor.nzmax);
}

CholeskySolver::CholeskySolver(std::shared_ptr<const BlockPattern> pattern)
    : state_(std::make_shared<State>(std::move(pattern))) {
  cholmod_common& common = state_->common;
  common.print = 0;
  common.quick_return_if_not_posdef = 1;
  common.nmethods = 1;
  common.method[0].ordering = CHOLMOD_NATURAL;
  common.postorder = 0;
  common.supernodal = CHOLMOD_AUTO;
  common.final_ll = 1;
  const FactorizationScope scope;
  cholmod_sparse matrix = state_->View(nullptr);
  state_->symbolic = Analyze(&matrix, &common);
  if (state_->symbolic == nullptr) throw std::runtime_error("CHOLMOD could not analyse the pattern of the Hessian");
}

CholeskySolver::~CholeskySolver() = default;

double CholeskySolver::num_flops() const { return state_->common.fl; }
double CholeskySolver::num_entries() const { return state_->common.lnz; }

std::shared_ptr<const CholeskyFactor> CholeskySolver::Factor(const Eigen::VectorXd& values) {
  // CHOLMOD does not look for NaN, and a comparison with one would pass as positive definite.
  if (!values.allFinite()) return nullptr;
  const FactorizationScope scope;
  cholmod_factor* factor = nullptr;
  if (state_->unused.empty()) {
    factor = cholmod_copy_factor(state_->symbolic, &state_->common);
    if (factor == nullptr) throw std::bad_alloc();
  } else {
    factor = state_->unused.back();
    state_->unused.pop_back();
  }
  auto numeric = std::make_unique<CholeskyFactor::Numeric>(state_, factor);
  cholmod_sparse matrix = state_->View(values.data());
  cholmod_factorize(&matrix, factor, &state_->common);
  if (state_->common.status != CHOLMOD_OK) return nullptr;
  return std::shared_ptr<const CholeskyFactor>(new CholeskyFactor(std::move(numeric)));
}

std::vector<int> FillReducingOrder(const std::vector<std::vector<int>>& neighbours) {
  const BlockPattern pattern(neighbours);
  const int n = pattern.num_blocks();
  if (n == 0) return {};
  // The graph itself, by compressed columns.
  std::vector<int> starts = {0}, rows;
  for (int column = 0; column < n; ++column) {
    rows.insert(rows.end(), pattern.rows_begin(column), pattern.rows_begin(column) + pattern.num_rows(column));
    starts.push_back(static_cast<int>(rows.size()));
  }
  cholmod_sparse graph = {};
  graph.nrow = graph.ncol = n;
  graph.nzmax = rows.size();
  graph.p = starts.data();
  graph.i = rows.data();
  graph.stype = -1;
  graph.itype = CHOLMOD_INT;
  graph.xtype = CHOLMOD_PATTERN;
  graph.dtype = CHOLMOD_DOUBLE;
  graph.sorted = graph.packed = 1;

  const FactorizationScope scope;
  cholmod_common common;
  cholmod_start(&common);
  common.print = 0;
  common.nmethods = 1;
  common.method[0].ordering = CHOLMOD_METIS;
  common.postorder = 1;
  cholmod_factor* factor = Analyze(&graph, &common);
  std::vector<int> order;
  if (factor != nullptr) order.assign(static_cast<int*>(factor->Perm), static_cast<int*>(factor->Perm) + n);
  cholmod_free_factor(&factor, &common);
  cholmod_finish(&common);
  if (order.empty()) throw std::runtime_error("CHOLMOD could not order the nodes of the mesh");
  return order;
}

struct LuFactor::State {
  ~State() {
    umfpack_di_free_symbolic(&symbolic);
    umfpack_di_free_numeric(&numeric);
  }
  void Solve(int system, const Eigen::MatrixXd& right, Eigen::MatrixXd* solution) const {
    const FactorizationScope scope;
    solution->resize(right.rows(), right.cols());
    for (Eigen::Index i = 0; i < right.cols(); ++i) {
      umfpack_di_solve(system, pattern->outer().data(), pattern->inner().data(), values.data(), solution->col(i).data(),
                       right.col(i).data(), numeric, control, nullptr);
    }
  }

  std::shared_ptr<const BlockPattern> pattern;
  Eigen::VectorXd values;  // UMFPACK reads the matrix again for iterative refinement
  double control[UMFPACK_CONTROL];
  void* symbolic = nullptr;
  void* numeric = nullptr;
};

LuFactor::LuFactor(std::shared_ptr<const BlockPattern> pattern) : state_(std::make_unique<State>()) {
  state_->pattern = std::move(pattern);
  umfpack_di_defaults(state_->control);
  state_->control[UMFPACK_PRL] = 0;
}

LuFactor::~LuFactor() = default;

bool LuFactor::Factor(const Eigen::VectorXd& values) {
  const FactorizationScope scope;
  const BlockPattern& pattern = *state_->pattern;
  state_->values = values;
  if (state_->symbolic == nullptr &&
      umfpack_di_symbolic(pattern.size(), pattern.size(), pattern.outer().data(), pattern.inner().data(), values.data(),
                          &state_->symbolic, state_->control, nullptr) != UMFPACK_OK) {
    return false;
  }
  umfpack_di_free_numeric(&state_->numeric);
  return umfpack_di_numeric(pattern.outer().data(), pattern.inner().data(), values.data(), state_->symbolic,
                            &state_->numeric, state_->control, nullptr) == UMFPACK_OK;
}

void LuFactor::Solve(const Eigen::MatrixXd& right, Eigen::MatrixXd* solution) const {
  state_->Solve(UMFPACK_A, right, solution);
}

void LuFactor::SolveTransposed(const Eigen::MatrixXd& right, Eigen::MatrixXd* solution) const {
  state_->Solve(UMFPACK_At, right, solution);
}

namespace {

// The small least-squares problem of one column of GMRES: its Hessenberg matrix, made triangular on the way.
class ArnoldiColumn {
 public:
  ArnoldiColumn(double norm, double tolerance, int max_iterations)
      : triangle_(max_iterations + 1, max_iterations),
        projected_(Eigen::VectorXd::Zero(max_iterations + 1)),
        goal_(tolerance * norm),
        active_(norm > 0.0) {
    projected_[0] = norm;
  }

  bool active() const { return active_; }  // iterates on
  bool failed() const { return failed_; }

  // Orthogonalises `next` against the column `c` of the k + 1 basis matrices and normalises it.
  void Extend(const std::vector<Eigen::MatrixXd>& basis, Eigen::Index c, Eigen::Ref<Eigen::VectorXd> next) {
    const int k = size_++;
    for (int i = 0; i <= k; ++i) {
      triangle_(i, k) = basis[i].col(c).dot(next);
      next -= triangle_(i, k) * basis[i].col(c);
    }
    const double norm = next.norm();
    triangle_(k + 1, k) = norm;
    for (int i = 0; i < k; ++i) triangle_.col(k).applyOnTheLeft(i, i + 1, rotations_[i].adjoint());
    rotations_.emplace_back();
    rotations_[k].makeGivens(triangle_(k, k), triangle_(k + 1, k));
    triangle_.col(k).applyOnTheLeft(k, k + 1, rotations_[k].adjoint());
    projected_.applyOnTheLeft(k, k + 1, rotations_[k].adjoint());
    failed_ = !std::isfinite(projected_[k + 1]);
    active_ = !failed_ && std::abs(projected_[k + 1]) > goal_ && norm > 0.0;
    if (active_) {
      next /= norm;
    } else {
      next.setZero();
    }
  }

  // Weights of the preconditioned basis.
  Eigen::VectorXd Weights() const {
    return triangle_.topLeftCorner(size_, size_).triangularView<Eigen::Upper>().solve(projected_.head(size_));
  }

 private:
  Eigen::MatrixXd triangle_;  // filled column by column, so most of it is never touched
  Eigen::VectorXd projected_;
  std::vector<Eigen::JacobiRotation<double>> rotations_;
  double goal_;
  int size_ = 0;
  bool active_, failed_ = false;
};

}  // namespace

GmresResult Gmres(const LinearMap& multiply, const LinearMap& precondition, const Eigen::MatrixXd& right,
                  double tolerance, int max_iterations, Eigen::MatrixXd* solution) {
  GmresResult result;
  std::vector<ArnoldiColumn> columns;
  std::vector<Eigen::MatrixXd> basis = {right}, preconditioned;
  for (Eigen::Index c = 0; c < right.cols(); ++c) {
    const double norm = right.col(c).norm();
    columns.emplace_back(norm, tolerance, max_iterations);
    if (norm > 0.0) basis[0].col(c) /= norm;
  }
  const auto any_active = [&columns] {
    return std::any_of(columns.begin(), columns.end(), [](const ArnoldiColumn& column) { return column.active(); });
  };
  while (any_active() && result.iterations < max_iterations) {
    preconditioned.push_back(precondition(basis[result.iterations]));
    basis.push_back(multiply(preconditioned.back()));
    for (Eigen::Index c = 0; c < right.cols(); ++c) {
      if (columns[c].active()) {
        columns[c].Extend(basis, c, basis.back().col(c));
      } else {
        basis.back().col(c).setZero();
      }
    }
    ++result.iterations;
  }
  *solution = Eigen::MatrixXd::Zero(right.rows(), right.cols());
  for (Eigen::Index c = 0; c < right.cols(); ++c) {
    const Eigen::VectorXd weights = columns[c].Weights();
    for (Eigen::Index i = 0; i < weights.size(); ++i) solution->col(c) += weights[i] * preconditioned[i].col(c);
  }
  const bool failed = std::any_of(columns.begin(), columns.end(), [](const auto& column) { return column.failed(); });
  result.converged = !any_active() && !failed && solution->allFinite();
  return result;
}

ConjugateGradientResult ConjugateGradients(const VectorMap& multiply, const VectorMap& precondition,
                                           const Eigen::VectorXd& right, double tolerance, int max_iterations,
                                           Eigen::VectorXd* solution) {
  ConjugateGradientResult result;
  const double goal = tolerance * right.norm();
  Eigen::VectorXd residual = right, direction;
  solution->setZero(right.size());
  double last_product = 0.0;
  result.converged = residual.norm() <= goal;
  while (!result.converged && result.iterations < max_iterations) {
    ++result.iterations;
    const Eigen::VectorXd preconditioned = precondition(residual);
    const double product = residual.dot(preconditioned);
    if (result.iterations == 1) {
      direction = preconditioned;
    } else {
      direction = preconditioned + product / last_product * direction;
    }
    last_product = product;
    const Eigen::VectorXd image = multiply(direction);
    const double curvature = direction.dot(image);
    if (!(curvature > 0.0)) {
      result.indefinite = true;
      return result;
    }
    *solution += product / curvature * direction;
    residual -= product / curvature * image;
    result.converged = residual.norm() <= goal;
  }
  return result;
}

}  // namespace clothid
