#include "sim/matrix/fill_reducing_order.h"

#include <cholmod.h>

#include <mutex>

#include "sim/matrix/blas_guard.h"
#include "sim/matrix/block_matrix.h"
#include "sim/matrix/cholmod_calls.h"

namespace clothid {
namespace {

// CHOLMOD for one ordering.
class OrderingSession {
 public:
  OrderingSession() {
    cholmod_start(&common_);
    common_.print = 0;
    common_.nmethods = 1;
    common_.method[0].ordering = CHOLMOD_METIS;
    common_.postorder = 1;
  }
  ~OrderingSession() {
    cholmod_free_factor(&factor_, &common_);
    cholmod_finish(&common_);
  }
  OrderingSession(const OrderingSession&) = delete;
  OrderingSession& operator=(const OrderingSession&) = delete;

  // The session keeps the factor.
  const cholmod_factor* Analyze(cholmod_sparse* matrix) { return factor_ = clothid::Analyze(matrix, &common_); }

 private:
  cholmod_common common_;
  cholmod_factor* factor_ = nullptr;
};

}  // namespace

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

  // METIS draws from the C library's rand, one sequence for all threads: two orderings at once would share it.
  static std::mutex metis_mutex;
  const std::lock_guard<std::mutex> lock(metis_mutex);
  const BlasGuard guard;
  OrderingSession session;
  const cholmod_factor* factor = session.Analyze(&graph);
  return {static_cast<int*>(factor->Perm), static_cast<int*>(factor->Perm) + n};
}

}  // namespace clothid
