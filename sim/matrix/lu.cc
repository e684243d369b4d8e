#include "sim/matrix/lu.h"

#include <umfpack.h>

#include <stdexcept>
#include <string>
#include <utility>

#include "sim/matrix/blas_guard.h"

namespace clothid {
namespace {

// Throws where `status` is an error: out of memory above all. Warnings, which are positive, tell of singular matrices.
void RequireSuccess(const char* routine, int status) {
  if (status >= UMFPACK_OK) return;
  throw std::runtime_error(
      std::string(routine) + ": " +
      (status == UMFPACK_ERROR_out_of_memory ? "out of memory" : "status " + std::to_string(status)));
}

}  // namespace

struct LuFactor::State {
  ~State() {
    umfpack_di_free_symbolic(&symbolic);
    umfpack_di_free_numeric(&numeric);
  }
  void Solve(int system, const Eigen::MatrixXd& right, Eigen::MatrixXd* solution) const {
    const BlasGuard guard;
    solution->resize(right.rows(), right.cols());
    for (Eigen::Index i = 0; i < right.cols(); ++i) {
      RequireSuccess("umfpack_di_solve",
                     umfpack_di_solve(system, pattern->outer().data(), pattern->inner().data(), values.data(),
                                      solution->col(i).data(), right.col(i).data(), numeric, control, nullptr));
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
  const BlasGuard guard;
  const BlockPattern& pattern = *state_->pattern;
  state_->values = values;
  if (state_->symbolic == nullptr) {
    const int status =
        umfpack_di_symbolic(pattern.size(), pattern.size(), pattern.outer().data(), pattern.inner().data(),
                            values.data(), &state_->symbolic, state_->control, nullptr);
    RequireSuccess("umfpack_di_symbolic", status);
    if (status != UMFPACK_OK) return false;
  }
  umfpack_di_free_numeric(&state_->numeric);
  const int status = umfpack_di_numeric(pattern.outer().data(), pattern.inner().data(), values.data(), state_->symbolic,
                                        &state_->numeric, state_->control, nullptr);
  RequireSuccess("umfpack_di_numeric", status);
  return status == UMFPACK_OK;
}

void LuFactor::Solve(const Eigen::MatrixXd& right, Eigen::MatrixXd* solution) const {
  state_->Solve(UMFPACK_A, right, solution);
}

void LuFactor::SolveTransposed(const Eigen::MatrixXd& right, Eigen::MatrixXd* solution) const {
  state_->Solve(UMFPACK_At, right, solution);
}

}  // namespace clothid
