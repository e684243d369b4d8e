#include "sim/matrix/fill_reducing_order.h"

#include <cholmod.h>

#include <stdexcept>

#include "sim/matrix/blas_guard.h"
#include "sim/matrix/block_matrix.h"
#include "sim/matrix/cholmod_calls.h"

namespace clothid {

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

  const BlasGuard guard;
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

}  // namespace clothid
