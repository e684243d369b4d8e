// CHOLMOD for one analysis of a pattern.
#ifndef CLOTHID_SIM_MATRIX_CHOLMOD_ANALYSIS_H_
#define CLOTHID_SIM_MATRIX_CHOLMOD_ANALYSIS_H_

#include <cholmod.h>

#include "sim/matrix/block_matrix.h"

namespace clothid {

class CholmodAnalysis {
 public:
  // One method, `ordering`, such as CHOLMOD_METIS.
  explicit CholmodAnalysis(int ordering);
  ~CholmodAnalysis();
  CholmodAnalysis(const CholmodAnalysis&) = delete;
  CholmodAnalysis& operator=(const CholmodAnalysis&) = delete;

  // What else it is to do.
  cholmod_common& common() { return common_; }

  // Of the pattern by blocks, not empty; once. The object keeps the factor, and a SIGTERM meanwhile is not lost. Throws
  // `std::runtime_error`, which names the reason, where CHOLMOD fails: out of memory above all.
  const cholmod_factor& Analyze(const BlockPattern& pattern);

 private:
  cholmod_common common_;
  cholmod_factor* factor_ = nullptr;
};

}  // namespace clothid

#endif  // CLOTHID_SIM_MATRIX_CHOLMOD_ANALYSIS_H_
