#include "sim/matrix/fill_reducing_order.h"

#include <mutex>

#include "sim/matrix/blas_guard.h"
#include "sim/matrix/block_matrix.h"
#include "sim/matrix/cholmod_analysis.h"

namespace clothid {
namespace {

std::vector<int> Order(int method, const std::vector<std::vector<int>>& neighbours) {
  const BlockPattern pattern(neighbours);
  const int n = pattern.num_blocks();
  if (n == 0) return {};
  const BlasGuard guard;
  CholmodAnalysis analysis(method);
  analysis.common().postorder = 1;
  const auto* const order = static_cast<const int*>(analysis.Analyze(pattern).Perm);
  return {order, order + n};
}

}  // namespace

std::vector<int> FillReducingOrder(const std::vector<std::vector<int>>& neighbours) {
  // METIS draws from the C library's rand, one sequence for all threads: two orderings at once would share it.
  static std::mutex metis_mutex;
  const std::lock_guard<std::mutex> lock(metis_mutex);
  return Order(CHOLMOD_METIS, neighbours);
}

std::vector<int> Postorder(const std::vector<std::vector<int>>& neighbours) {
  return Order(CHOLMOD_NATURAL, neighbours);
}

}  // namespace clothid
