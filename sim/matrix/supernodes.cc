#include "sim/matrix/supernodes.h"

#include <cholmod.h>

#include <algorithm>

#include "sim/matrix/blas_guard.h"
#include "sim/matrix/cholmod_calls.h"

namespace clothid {
namespace {

// CHOLMOD for one analysis.
class AnalysisSession {
 public:
  AnalysisSession() {
    cholmod_start(&common_);
    common_.print = 0;
    common_.nmethods = 1;
    common_.method[0].ordering = CHOLMOD_NATURAL;
    common_.postorder = 0;
    common_.supernodal = CHOLMOD_SUPERNODAL;
    for (int i = 0; i < 3; ++i) {
      common_.nrelax[i] = kRelaxedColumns[i];
      common_.zrelax[i] = kRelaxedZeros[i];
    }
  }
  ~AnalysisSession() {
    cholmod_free_factor(&factor_, &common_);
    cholmod_finish(&common_);
  }
  AnalysisSession(const AnalysisSession&) = delete;
  AnalysisSession& operator=(const AnalysisSession&) = delete;

  // Of the pattern by blocks. The session keeps the factor.
  const cholmod_factor& Analyze(const BlockPattern& pattern) {
    const int n = pattern.num_blocks();
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
    return *(factor_ = clothid::Analyze(&graph, &common_));
  }

 private:
  // A supernode and its parent become one where both together have fewer columns than the first, or fewer than the
  // second and a smaller share of zeros than the first, and so on.
  static constexpr std::size_t kRelaxedColumns[3] = {2, 6, 16};
  static constexpr double kRelaxedZeros[3] = {0.8, 0.1, 0.05};

  cholmod_common common_;
  cholmod_factor* factor_ = nullptr;
};

}  // namespace

Supernodes::Supernodes(const BlockPattern& pattern) {
  const int n = pattern.num_blocks();
  columns = row_starts = update_starts = {0};
  value_starts = {0};
  if (n == 0) return;  // for CHOLMOD no matrix
  const BlasGuard guard;
  AnalysisSession session;
  const cholmod_factor& factor = session.Analyze(pattern);
  const auto* const super = static_cast<const int*>(factor.super);
  const auto* const starts = static_cast<const int*>(factor.pi);
  columns.assign(super, super + factor.nsuper + 1);
  row_starts.assign(starts, starts + factor.nsuper + 1);
  rows.assign(static_cast<const int*>(factor.s), static_cast<const int*>(factor.s) + row_starts.back());
  for (int s = 0; s < size(); ++s) {
    value_starts.push_back(value_starts.back() + 9 * static_cast<std::size_t>(num_rows(s)) * num_columns(s));
    max_rows = std::max(max_rows, num_rows(s));
  }
  for (int column = 0; column < n; ++column) {
    const double count = 3.0 * static_cast<const int*>(factor.ColCount)[column];
    for (const double entries : {count, count - 1.0, count - 2.0}) {
      num_entries += entries;
      num_flops += entries * entries;
    }
  }
  ListUpdates(n);
}

void Supernodes::ListUpdates(int num_blocks) {
  std::vector<int> supernode_of(num_blocks);
  for (int s = 0; s < size(); ++s) std::fill_n(supernode_of.begin() + columns[s], num_columns(s), s);
  std::vector<std::vector<Update>> of(size());
  for (int s = 0; s < size(); ++s) {
    const int* const own = rows.data() + row_starts[s];
    for (int first = num_columns(s), last; first < num_rows(s); first = last) {
      const int target = supernode_of[own[first]];
      for (last = first + 1; last < num_rows(s) && supernode_of[own[last]] == target;) ++last;
      of[target].push_back({s, first, last});
    }
  }
  for (const std::vector<Update>& list : of) {
    updates.insert(updates.end(), list.begin(), list.end());
    update_starts.push_back(static_cast<int>(updates.size()));
  }
}

}  // namespace clothid
