#include "sim/matrix/cholesky.h"

#include <cholmod.h>

#include <cstddef>
#include <mutex>
#include <utility>
#include <vector>

#include "sim/matrix/blas_guard.h"
#include "sim/matrix/cholmod_calls.h"

namespace clothid {
namespace {

// Numeric factors that nobody uses. A factor may end in any thread, while another one takes the next from here.
class UnusedFactors {
 public:
  // Null: there is none. Whoever then makes one calls `Announce`.
  cholmod_factor* Take() {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (factors_.empty()) return nullptr;
    cholmod_factor* factor = factors_.back();
    factors_.pop_back();
    return factor;
  }

  // Makes room for one more, so that to put it back cannot fail.
  void Announce() {
    const std::lock_guard<std::mutex> lock(mutex_);
    factors_.reserve(++num_factors_);
  }

  void Put(cholmod_factor* factor) noexcept {
    const std::lock_guard<std::mutex> lock(mutex_);
    factors_.push_back(factor);
  }

 private:
  std::mutex mutex_;
  std::vector<cholmod_factor*> factors_;
  std::size_t num_factors_ = 0;  // used or not
};

}  // namespace

struct CholeskySolver::State {
  explicit State(std::shared_ptr<const BlockPattern> p) : pattern(std::move(p)) { cholmod_start(&common); }
  ~State() {
    while (cholmod_factor* factor = unused.Take()) cholmod_free_factor(&factor, &common);
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
  UnusedFactors unused;
  cholmod_dense* work_y = nullptr;  // CHOLMOD's work space of solves
  cholmod_dense* work_e = nullptr;
};

struct CholeskyFactor::Numeric {
  Numeric(std::shared_ptr<CholeskySolver::State> s, cholmod_factor* f) : state(std::move(s)), factor(f) {}
  ~Numeric() { state->unused.Put(factor); }
  std::shared_ptr<CholeskySolver::State> state;
  cholmod_factor* factor;
};

CholeskyFactor::CholeskyFactor(std::unique_ptr<Numeric> numeric) : numeric_(std::move(numeric)) {}
CholeskyFactor::~CholeskyFactor() = default;

void CholeskyFactor::Solve(const Eigen::MatrixXd& right, Eigen::MatrixXd* solution) const {
  solution->resize(right.rows(), right.cols());
  if (right.size() == 0) return;  // for CHOLMOD an invalid argument
  const BlasGuard guard;
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
  RequireSuccess("cholmod_solve2", state.common);
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
  const BlasGuard guard;
  cholmod_sparse matrix = state_->View(nullptr);
  state_->symbolic = Analyze(&matrix, &common);
}

CholeskySolver::~CholeskySolver() = default;

double CholeskySolver::num_flops() const { return state_->common.fl; }
double CholeskySolver::num_entries() const { return state_->common.lnz; }

std::shared_ptr<const CholeskyFactor> CholeskySolver::Factor(const Eigen::VectorXd& values) {
  // CHOLMOD does not look for NaN, and a comparison with one would pass as positive definite.
  if (!values.allFinite()) return nullptr;
  const BlasGuard guard;
  cholmod_factor* factor = state_->unused.Take();
  if (factor == nullptr) {
    state_->unused.Announce();
    factor = cholmod_copy_factor(state_->symbolic, &state_->common);
    RequireSuccess("cholmod_copy_factor", state_->common);
  }
  auto numeric = std::make_unique<CholeskyFactor::Numeric>(state_, factor);
  cholmod_sparse matrix = state_->View(values.data());
  cholmod_factorize(&matrix, factor, &state_->common);
  RequireSuccess("cholmod_factorize", state_->common);
  if (state_->common.status != CHOLMOD_OK) return nullptr;  // a warning: not positive definite
  return std::shared_ptr<const CholeskyFactor>(new CholeskyFactor(std::move(numeric)));
}

}  // namespace clothid
