// The expensive evaluations of one recording's cost, kept on disk while a fit runs. A fit that was killed is run again
// from its start; what it had computed is replayed from here, so that it ends in the same bytes.
//
// Records are small but for predictions and first Jacobians, which are as large as the recording, or larger. Once these
// have taken up their room, records are kept without them: whoever replays one makes the prediction again, by one
// rollout. Derivatives, which take most of the time, are never made again.
//
// The file: see datasets/files/record_file.h. Numbers stand as in memory, bit by bit: a journal is read by the program
// that wrote it.
#ifndef CLOTHID_COSTS_ROWS_EVALUATION_JOURNAL_H_
#define CLOTHID_COSTS_ROWS_EVALUATION_JOURNAL_H_

#include <cstdint>
#include <optional>
#include <string>

#include "costs/prediction/rollout_cost_options.h"
#include "costs/rows/rollout_evaluation.h"
#include "datasets/files/record_file.h"

namespace clothid {

class EvaluationJournal {
 public:
  // Throws what `RecordFile` throws. `fingerprint`: of everything that determines the evaluations. `room`: bytes that
  // predictions and first Jacobians may take, less than kMaxRecordBytes.
  EvaluationJournal(const std::string& path, const std::string& fingerprint, std::uint64_t room = kJournalRoom);

  // The outcome of the next record; nothing when there are none left. A record that was torn by the end of its
  // process, or damaged, is cut off with all that follow. Throws `Error`: kBadData where the record answers another
  // question than `key` (compared bit by bit), kIo.
  std::optional<EvaluationOutcome> Replay(const EvaluationKey& key);

  // Whether there is room for so many numbers of a prediction and a first Jacobian.
  bool HasRoomFor(std::uint64_t num_numbers) const { return room_ / sizeof(double) >= num_numbers; }
  // Adds a record. Only when there is nothing left to replay. `outcome` is as it was afterwards. Throws `Error` (kIo).
  void Append(EvaluationKey key, EvaluationOutcome* outcome);

  int num_records() const { return num_records_; }  // replayed or added so far

 private:
  void TakeRoom(const EvaluationOutcome& outcome);

  RecordFile file_;
  std::uint64_t room_;  // that is left
  int num_records_ = 0;
};

}  // namespace clothid

#endif  // CLOTHID_COSTS_ROWS_EVALUATION_JOURNAL_H_
