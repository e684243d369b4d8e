#include "costs/rows/evaluation_journal.h"

#include <algorithm>
#include <cstring>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include "sim/base/error.h"

namespace clothid {
namespace {

struct RecordTooShort {};

// The archives have the same face, so that each structure below lists its fields once for all of them.
class Counter {
 public:
  void Bytes(const void* /*bytes*/, std::size_t count) { count_ += count; }
  Eigen::Index Size(Eigen::Index size, std::size_t /*item_bytes*/) {
    count_ += sizeof(size);
    return size;
  }
  std::size_t count() const { return count_; }

 private:
  std::size_t count_ = 0;
};

class Writer {
 public:
  explicit Writer(std::size_t count) { text_.reserve(count); }
  void Bytes(const void* bytes, std::size_t count) { text_.append(static_cast<const char*>(bytes), count); }
  Eigen::Index Size(Eigen::Index size, std::size_t /*item_bytes*/) {
    Bytes(&size, sizeof(size));
    return size;
  }
  std::string Take() { return std::move(text_); }

 private:
  std::string text_;
};

class Reader {
 public:
  explicit Reader(std::string_view text) : text_(text) {}
  void Bytes(void* bytes, std::size_t count) {
    if (count > text_.size()) throw RecordTooShort();
    if (count > 0) std::memcpy(bytes, text_.data(), count);
    text_.remove_prefix(count);
  }
  // A size of which as many items, of `item_bytes` each, may follow.
  Eigen::Index Size(Eigen::Index /*size*/, std::size_t item_bytes) {
    Eigen::Index size = 0;
    Bytes(&size, sizeof(size));
    const std::size_t most = text_.size() / std::max<std::size_t>(item_bytes, 1);
    if (size < 0 || static_cast<std::size_t>(size) > most) throw RecordTooShort();
    return size;
  }

 private:
  std::string_view text_;
};

template <typename Archive, typename Number, typename = std::enable_if_t<!std::is_class_v<Number>>>
void Field(Archive* archive, Number* number) {
  archive->Bytes(number, sizeof(Number));
}

// Any byte, for no other than 0 and 1 may stand in a bool.
template <typename Archive>
void Field(Archive* archive, bool* flag) {
  char byte = *flag ? 1 : 0;
  archive->Bytes(&byte, sizeof(byte));
  *flag = byte != 0;
}

template <typename Archive>
void Field(Archive* archive, std::string* text) {
  text->resize(archive->Size(text->size(), 1));
  archive->Bytes(text->data(), text->size());
}

template <typename Archive>
void Field(Archive* archive, std::vector<int>* numbers) {
  numbers->resize(archive->Size(numbers->size(), sizeof(int)));
  archive->Bytes(numbers->data(), numbers->size() * sizeof(int));
}

template <typename Archive>
void Field(Archive* archive, Eigen::VectorXd* vector) {
  vector->resize(archive->Size(vector->size(), sizeof(double)));
  archive->Bytes(vector->data(), vector->size() * sizeof(double));
}

template <typename Archive>
void Field(Archive* archive, Eigen::MatrixXd* matrix) {
  const Eigen::Index rows = archive->Size(matrix->rows(), 1);
  matrix->resize(rows, archive->Size(matrix->cols(), static_cast<std::size_t>(rows) * sizeof(double)));
  archive->Bytes(matrix->data(), matrix->size() * sizeof(double));
}

template <typename Archive, typename... Values>
void Fields(Archive* archive, Values*... values) {
  (Field(archive, values), ...);
}

// A structured binding names every field, so none can be added without its place here. Combinations are large: a digest
// stands for them.
template <typename Archive>
void Field(Archive* archive, EvaluationKey* key) {
  auto& [coordinates, precision, need, active, combinations] = *key;
  std::string digest = DigestOf(combinations);
  Fields(archive, &coordinates, &precision, &need, &active, &digest);
}

template <typename Archive>
void Field(Archive* archive, RolloutCounts* value) {
  auto& [steps, newton, factorizations, linear, fallbacks, substeps, failed, contacts, joined, left, branches,
         obstacles, pairs, pair_changes, second_solves] = *value;
  Fields(archive, &steps, &newton, &factorizations, &linear, &fallbacks, &substeps, &failed, &contacts, &joined, &left,
         &branches, &obstacles, &pairs, &pair_changes, &second_solves);
}

template <typename Archive>
void Field(Archive* archive, CostStatistics* value) {
  auto& [rollouts, sweeps, counts, rollout_seconds, derivative_seconds] = *value;
  Fields(archive, &rollouts, &sweeps, &counts, &rollout_seconds, &derivative_seconds);
}

template <typename Archive>
void Field(Archive* archive, ResidualRows* value) {
  auto& [active, along, residuals, jacobian, frame_scores] = *value;
  Fields(archive, &active, &along, &residuals, &jacobian, &frame_scores);
}

// Without the residuals, which the prediction gives again.
template <typename Archive>
void Field(Archive* archive, RolloutEvaluation* value) {
  auto& [coordinates, precision, failure, predicted, forces, residuals, counts, cost, loss_row, has_rows, rows,
         has_gradient, gradient, has_exact_rows, exact_rows, product] = *value;
  Fields(archive, &coordinates, &precision, &failure, &predicted, &forces, &counts, &cost, &loss_row, &has_rows, &rows,
         &has_gradient, &gradient, &has_exact_rows, &exact_rows, &product);
}

template <typename Archive>
void Field(Archive* archive, EvaluationOutcome* value) {
  auto& [evaluation, statistics, rollout_coordinates, first_jacobian] = *value;
  Fields(archive, &evaluation, &statistics, &rollout_coordinates, &first_jacobian);
}

// In memory of just that size: predictions are large.
template <typename... Values>
std::string BytesOf(Values*... values) {
  Counter counter;
  Fields(&counter, values...);
  Writer writer(counter.count());
  Fields(&writer, values...);
  return writer.Take();
}

RecordFile::Kind JournalKind() {
  return {"clothid journal 7", "a journal of evaluations, version 7",
          "is the journal of a fit with other recordings, flags or program; remove it, or use another --output"};
}

}  // namespace

EvaluationJournal::EvaluationJournal(const std::string& path, const std::string& fingerprint, std::uint64_t room)
    : file_(path, JournalKind(), fingerprint), room_(room) {}

void EvaluationJournal::TakeRoom(const EvaluationOutcome& outcome) {
  const auto bytes =
      static_cast<std::uint64_t>(outcome.evaluation.predicted.size() + outcome.first_jacobian.size()) * sizeof(double);
  room_ -= std::min(room_, bytes);
}

std::optional<EvaluationOutcome> EvaluationJournal::Replay(const EvaluationKey& key) {
  std::string payload;
  if (file_.Read(&payload) != RecordFile::Next::kRecord) {
    file_.Truncate();
    return std::nullopt;
  }
  ++num_records_;
  EvaluationKey asked = key;
  const std::string wanted = BytesOf(&asked);
  EvaluationOutcome outcome;
  try {
    if (std::string_view(payload).substr(0, wanted.size()) != wanted) throw RecordTooShort();
    Reader reader(std::string_view(payload).substr(wanted.size()));
    Field(&reader, &outcome);
  } catch (const RecordTooShort&) {
    throw Error(ErrorKind::kBadData, file_.path() + ": record " + std::to_string(num_records_) +
                                         " is not of the evaluation that this fit needs; remove the journal");
  }
  TakeRoom(outcome);
  return outcome;
}

void EvaluationJournal::Append(EvaluationKey key, EvaluationOutcome* outcome) {
  file_.Append(BytesOf(&key, outcome));
  ++num_records_;
  TakeRoom(*outcome);
}

}  // namespace clothid
