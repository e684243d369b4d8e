#include "sim/matrix/cholesky.h"

#include <algorithm>
#include <mutex>
#include <utility>
#include <vector>

#include "sim/matrix/supernodal_factor.h"
#include "sim/matrix/supernodal_solve.h"
#include "sim/matrix/supernodes.h"

namespace clothid {
namespace {

// Parts in which a factor is copied.
constexpr int kCopies = 8;

}  // namespace

// The memory of factors. Some threads take it while others put it back.
class FactorMemory {
 public:
  // [size]; what it holds is finite.
  std::vector<double> Take(std::size_t size) {
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      if (!unused_.empty()) {
        std::vector<double> values = std::move(unused_.back());
        unused_.pop_back();
        return values;
      }
      unused_.reserve(++num_taken_);  // so that to put it back cannot fail
    }
    return std::vector<double>(size);
  }

  void Put(std::vector<double> values) noexcept {
    const std::lock_guard<std::mutex> lock(mutex_);
    unused_.push_back(std::move(values));
  }

 private:
  std::mutex mutex_;
  std::vector<std::vector<double>> unused_;
  std::size_t num_taken_ = 0;  // for the first time
};

struct CholeskySolver::State {
  explicit State(std::shared_ptr<const BlockPattern> p) : pattern(std::move(p)), supernodes(*pattern) {}

  std::shared_ptr<const BlockPattern> pattern;
  Supernodes supernodes;
  FactorMemory memory;
};

struct CholeskyFactor::Numeric {
  explicit Numeric(std::shared_ptr<CholeskySolver::State> s)
      : state(std::move(s)), values(state->memory.Take(NumFactorValues(state->supernodes))) {}
  ~Numeric() { state->memory.Put(std::move(values)); }

  std::shared_ptr<CholeskySolver::State> state;
  std::vector<double> values;
};

CholeskyFactor::CholeskyFactor(std::unique_ptr<Numeric> numeric) : numeric_(std::move(numeric)) {}
CholeskyFactor::~CholeskyFactor() = default;

void CholeskyFactor::Solve(const Eigen::MatrixXd& right, Eigen::MatrixXd* solution, ThreadTeam* team) const {
  SolveSupernodes(numeric_->state->supernodes, numeric_->values.data(), right, solution, team);
}

std::size_t CholeskyFactor::bytes() const { return sizeof(double) * numeric_->values.size(); }

void SinglePrecisionFactor::Set(std::shared_ptr<const CholeskyFactor> factor, ThreadTeam* team) {
  if (factor != factor_ && factor != nullptr) {
    const std::vector<double>& values = factor->numeric_->values;
    values_.resize(values.size());
    RunTasks(team, kCopies, [&](int task) {
      const std::size_t first = values.size() * task / kCopies, last = values.size() * (task + 1) / kCopies;
      std::transform(values.begin() + first, values.begin() + last, values_.begin() + first,
                     [](double value) { return static_cast<float>(value); });
    });
  }
  factor_ = std::move(factor);
}

void SinglePrecisionFactor::Solve(const Eigen::MatrixXd& right, Eigen::MatrixXd* solution, ThreadTeam* team) const {
  SolveSupernodes(factor_->numeric_->state->supernodes, values_.data(), right, solution, team);
}

CholeskySolver::CholeskySolver(std::shared_ptr<const BlockPattern> pattern)
    : state_(std::make_shared<State>(std::move(pattern))) {}

CholeskySolver::~CholeskySolver() = default;

double CholeskySolver::num_flops() const { return state_->supernodes.num_flops; }
double CholeskySolver::num_entries() const { return state_->supernodes.num_entries; }
bool CholeskySolver::has_branches() const { return !state_->supernodes.branches.empty(); }

std::shared_ptr<const CholeskyFactor> CholeskySolver::Factor(const Eigen::VectorXd& values, ThreadTeam* team) {
  // A comparison with NaN or infinity might pass as positive definite.
  if (!values.allFinite()) return nullptr;
  auto numeric = std::make_unique<CholeskyFactor::Numeric>(state_);
  if (!FactorSupernodes(state_->supernodes, *state_->pattern, values.data(), numeric->values.data(), team)) {
    return nullptr;
  }
  return std::shared_ptr<const CholeskyFactor>(new CholeskyFactor(std::move(numeric)));
}

}  // namespace clothid
