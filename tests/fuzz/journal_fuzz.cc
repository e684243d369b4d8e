// Files of records, and the evaluations in a journal. The first byte chooses between a file as it is, behind its
// header, and records whose checksums are right: each of them two bytes of length, then that many bytes.
#include <algorithm>
#include <fstream>

#include "costs/rows/evaluation_journal.h"
#include "tests/fuzz/fuzz_target.h"
#include "tests/fuzz/record_bytes.h"

int clothid::FuzzJournal(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  static const MemoryFile file;
  const std::string fingerprint(64, '0');
  file.Write("clothid journal 4\n" + fingerprint + "\n" + RecordBytes(data[0], AsText(data + 1, size - 1)));
  Accepts(
      [&] {
        EvaluationJournal journal(file.path(), fingerprint);
        while (journal.Replay(EvaluationKey())) continue;
        EvaluationOutcome outcome;
        journal.Append(EvaluationKey(), &outcome);
      },
      file.path());
  return 0;
}
