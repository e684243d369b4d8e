#include "sim/matrix/cholmod_analysis.h"

#include <signal.h>

#include <stdexcept>
#include <string>
#include <vector>

namespace clothid {
namespace {

std::string Describe(int status) {
  switch (status) {
    case CHOLMOD_OUT_OF_MEMORY:
      return "out of memory";
    case CHOLMOD_TOO_LARGE:
      return "the matrix is too large for its integers";
    default:
      return "status " + std::to_string(status);
  }
}

// METIS takes SIGTERM and SIGABRT for its own while it orders a matrix, and a SIGTERM of anybody else is lost. Held
// back in this thread, it arrives when METIS is done.
cholmod_factor* AnalyzeWithoutSignals(cholmod_sparse* matrix, cholmod_common* common) {
  sigset_t held, before;
  sigemptyset(&held);
  sigaddset(&held, SIGTERM);
  pthread_sigmask(SIG_BLOCK, &held, &before);
  cholmod_factor* factor = cholmod_analyze(matrix, common);
  pthread_sigmask(SIG_SETMASK, &before, nullptr);
  // Errors are negative, warnings positive.
  if (common->status < CHOLMOD_OK) throw std::runtime_error("cholmod_analyze: " + Describe(common->status));
  if (factor == nullptr) throw std::runtime_error("cholmod_analyze: no factor");
  return factor;
}

}  // namespace

CholmodAnalysis::CholmodAnalysis(int ordering) {
  cholmod_start(&common_);
  common_.print = 0;
  common_.nmethods = 1;
  common_.method[0].ordering = ordering;
}

CholmodAnalysis::~CholmodAnalysis() {
  cholmod_free_factor(&factor_, &common_);
  cholmod_finish(&common_);
}

const cholmod_factor& CholmodAnalysis::Analyze(const BlockPattern& pattern) {
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
  return *(factor_ = AnalyzeWithoutSignals(&graph, &common_));
}

}  // namespace clothid
