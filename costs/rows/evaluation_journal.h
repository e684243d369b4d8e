// The expensive evaluations of one recording's cost, kept on disk while a fit runs. A fit that was killed is run again
// from its start; what it had computed is replayed from here, so that it ends in the same bytes.
//
// The file: see datasets/files/record_file.h. Numbers stand as in memory, bit by bit: a journal is read by the program
// that wrote it.
#ifndef CLOTHID_COSTS_ROWS_EVALUATION_JOURNAL_H_
#define CLOTHID_COSTS_ROWS_EVALUATION_JOURNAL_H_

#include <optional>
#include <string>

#include "costs/rows/rollout_evaluation.h"
#include "datasets/files/record_file.h"

namespace clothid {

class EvaluationJournal {
 public:
  // Throws what `RecordFile` throws. `fingerprint`: of everything that determines the evaluations.
  EvaluationJournal(const std::string& path, const std::string& fingerprint);

  // The outcome of the next record; nothing when there are none left. A record that was torn by the end of its
  // process, or damaged, is cut off with all that follow. Throws `Error`: kBadData where the record answers another
  // question than `key` (compared bit by bit), kIo.
  std::optional<EvaluationOutcome> Replay(const EvaluationKey& key);

  // Adds a record with one write(), which the end of the process cannot undo. Only when there is nothing left to
  // replay. Throws `Error` (kIo).
  void Append(EvaluationKey key, EvaluationOutcome outcome);

  int num_records() const { return num_records_; }  // replayed or added so far

 private:
  RecordFile file_;
  int num_records_ = 0;
};

}  // namespace clothid

#endif  // CLOTHID_COSTS_ROWS_EVALUATION_JOURNAL_H_
