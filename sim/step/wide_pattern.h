// The pattern of a step's matrix, widened by couplings between nodes that are no neighbours, and its Cholesky factors,
// in an elimination order of its own.
#ifndef CLOTHID_SIM_STEP_WIDE_PATTERN_H_
#define CLOTHID_SIM_STEP_WIDE_PATTERN_H_

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <memory>
#include <vector>

#include "sim/base/thread_team.h"
#include "sim/matrix/block_matrix.h"
#include "sim/matrix/cholesky.h"

namespace clothid {

class WidePattern {
 public:
  // `cliques`: blocks that are coupled with each other; -1: none. `before` (may be null): of the same blocks with other
  // cliques, whose order of elimination is taken over for as long as a factor takes little more work in it.
  WidePattern(const BlockPattern& pattern, const std::vector<std::array<int, 4>>& cliques, const WidePattern* before);

  bool Covers(const std::vector<std::array<int, 4>>& cliques) const;

  // A matrix with the values of `matrix`, which has the pattern that this one was made of, and zeros.
  BlockMatrix Widened(const BlockMatrix& matrix) const;

  // A factor of a matrix of this pattern; null where it is not positive definite. Team as CholeskyFactor::Solve.
  std::shared_ptr<const CholeskyFactor> Factor(const Eigen::VectorXd& values, ThreadTeam* team = nullptr) const;
  // With a factor that was made here [3 n x s].
  Eigen::MatrixXd Solve(const CholeskyFactor& factor, const Eigen::MatrixXd& right, ThreadTeam* team = nullptr) const;

  double flops() const { return cholesky_->num_flops(); }  // as of CholeskySolver
  // That and its entries, the one over the other.
  double flops_per_entry() const { return cholesky_->num_flops() / cholesky_->num_entries(); }
  std::size_t bytes() const;  // of its indices, roughly

 private:
  // Sets places and solver, and returns the pattern in that order.
  std::shared_ptr<const BlockPattern> Analyze(const std::vector<std::vector<int>>& neighbours,
                                              const std::vector<int>& order);
  void MapValues(const BlockPattern& ordered);

  std::shared_ptr<const BlockPattern> pattern_;  // as its blocks are numbered
  std::vector<int> places_;                      // of blocks in the order of elimination
  double first_flops_ = 0.0;                     // of a factor where the order was made
  std::unique_ptr<CholeskySolver> cholesky_;
  Eigen::VectorXi ordered_;  // where a value is in the order of elimination
};

}  // namespace clothid

#endif  // CLOTHID_SIM_STEP_WIDE_PATTERN_H_
