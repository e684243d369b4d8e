#include "sim/matrix/fill_reducing_order.h"

#include <mutex>

#include "sim/matrix/blas_guard.h"
#include "sim/matrix/block_matrix.h"
#include "sim/matrix/cholmod_analysis.h"

namespace clothid {

std::vector<int> FillReducingOrder(const std::vector<std::vector<int>>& neighbours) {
  const BlockPattern pattern(neighbours);
  const int n = pattern.num_blocks();
  if (n == 0) return {};
  // METIS draws from the C library's rand, one sequence for all threads: two orderings at once would share it.
  static std::mutex metis_mutex;
  const std::lock_guard<std::mutex> lock(metis_mutex);
  const BlasGuard guard;
  CholmodAnalysis analysis(CHOLMOD_METIS);
  analysis.common().postorder = 1;
  const auto* const order = static_cast<const int*>(analysis.Analyze(pattern).Perm);
  return {order, order + n};
}

}  // namespace clothid
