#include "costs/evaluation_journal.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <type_traits>
#include <utility>

#include "datasets/sha256.h"
#include "sim/error.h"

namespace clothid {
namespace {

constexpr std::string_view kMagic = "clothid journal 1\n";
constexpr std::uint64_t kDigestSize = 64;
constexpr std::uint64_t kHeaderSize = kMagic.size() + kDigestSize + 1;
constexpr std::uint64_t kFrameSize = sizeof(std::uint64_t) + kDigestSize;  // of a record, before its payload

struct RecordTooShort {};

// The two archives have the same face, so that each structure below lists its fields once for both.
class Writer {
 public:
  void Bytes(const void* bytes, std::size_t count) { text_.append(static_cast<const char*>(bytes), count); }
  Eigen::Index Size(Eigen::Index size) {
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
  Eigen::Index Size(Eigen::Index /*size*/) {
    Eigen::Index size = 0;
    Bytes(&size, sizeof(size));
    if (size < 0 || static_cast<std::size_t>(size) > text_.size()) throw RecordTooShort();
    return size;
  }

 private:
  std::string_view text_;
};

template <typename Archive, typename Number, typename = std::enable_if_t<!std::is_class_v<Number>>>
void Field(Archive* archive, Number* number) {
  archive->Bytes(number, sizeof(Number));
}

template <typename Archive>
void Field(Archive* archive, std::string* text) {
  text->resize(archive->Size(text->size()));
  archive->Bytes(text->data(), text->size());
}

template <typename Archive>
void Field(Archive* archive, std::vector<int>* numbers) {
  numbers->resize(archive->Size(numbers->size()));
  archive->Bytes(numbers->data(), numbers->size() * sizeof(int));
}

template <typename Archive>
void Field(Archive* archive, Eigen::VectorXd* vector) {
  vector->resize(archive->Size(vector->size()));
  archive->Bytes(vector->data(), vector->size() * sizeof(double));
}

template <typename Archive>
void Field(Archive* archive, Eigen::MatrixXd* matrix) {
  const Eigen::Index rows = archive->Size(matrix->rows());
  matrix->resize(rows, archive->Size(matrix->cols()));
  archive->Bytes(matrix->data(), matrix->size() * sizeof(double));
}

template <typename Archive, typename... Values>
void Fields(Archive* archive, Values*... values) {
  (Field(archive, values), ...);
}

// A structured binding names every field, so none can be added without its place here.
template <typename Archive>
void Field(Archive* archive, EvaluationKey* key) {
  auto& [coordinates, precision, need, active] = *key;
  Fields(archive, &coordinates, &precision, &need, &active);
}

template <typename Archive>
void Field(Archive* archive, RolloutCounts* value) {
  auto& [steps, newton, factorizations, linear, fallbacks, substeps, failed, contacts, joined, left, branches,
         obstacles] = *value;
  Fields(archive, &steps, &newton, &factorizations, &linear, &fallbacks, &substeps, &failed, &contacts, &joined, &left,
         &branches, &obstacles);
}

template <typename Archive>
void Field(Archive* archive, CostStatistics* value) {
  auto& [rollouts, sweeps, counts, rollout_seconds, derivative_seconds] = *value;
  Fields(archive, &rollouts, &sweeps, &counts, &rollout_seconds, &derivative_seconds);
}

template <typename Archive>
void Field(Archive* archive, ResidualRows* value) {
  auto& [active, residuals, jacobian] = *value;
  Fields(archive, &active, &residuals, &jacobian);
}

template <typename Archive>
void Field(Archive* archive, RolloutEvaluation* value) {
  auto& [coordinates, precision, failure, predicted, cost, loss_row, has_rows, rows, has_gradient, gradient,
         has_exact_rows, exact_rows] = *value;
  Fields(archive, &coordinates, &precision, &failure, &predicted, &cost, &loss_row, &has_rows, &rows, &has_gradient,
         &gradient, &has_exact_rows, &exact_rows);
}

template <typename Archive>
void Field(Archive* archive, EvaluationOutcome* value) {
  auto& [evaluation, statistics, rollout_coordinates, first_jacobian] = *value;
  Fields(archive, &evaluation, &statistics, &rollout_coordinates, &first_jacobian);
}

std::string KeyBytes(EvaluationKey key) {
  Writer writer;
  Field(&writer, &key);
  return writer.Take();
}

std::string_view AsBytes(const std::uint64_t& length) {
  return {reinterpret_cast<const char*>(&length), sizeof(length)};
}

}  // namespace

EvaluationJournal::EvaluationJournal(const std::string& path, const std::string& fingerprint) : path_(path) {
  descriptor_ = ::open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666);
  if (descriptor_ < 0) FailIo(std::string("cannot be opened: ") + std::strerror(errno));
  try {
    // The lock ends with its process, however that ends.
    if (::flock(descriptor_, LOCK_EX | LOCK_NB) != 0) FailIo("another process uses this journal");
    ReadOrWriteHeader(fingerprint);
  } catch (...) {
    ::close(descriptor_);
    throw;
  }
}

EvaluationJournal::~EvaluationJournal() { ::close(descriptor_); }

void EvaluationJournal::ReadOrWriteHeader(const std::string& fingerprint) {
  struct stat status = {};
  if (::fstat(descriptor_, &status) != 0) FailIo(std::string("cannot be read: ") + std::strerror(errno));
  size_ = static_cast<std::uint64_t>(status.st_size);
  const std::string wanted = std::string(kMagic) + fingerprint + "\n";
  std::string header;
  ReadAt(0, std::min(size_, kHeaderSize), &header);
  if (std::string_view(header).substr(0, kMagic.size()) != kMagic.substr(0, header.size())) {
    throw Error(ErrorKind::kBadData, path_ + ": expected a journal of evaluations, version 1");
  }
  if (size_ < kHeaderSize) {  // torn, so nothing was ever recorded
    Truncate();
    Write(wanted);
  } else if (header != wanted) {
    throw Error(ErrorKind::kUsage, path_ +
                                       ": is the journal of a fit with other recordings, flags or program; "
                                       "remove it, or use another --output");
  }
  position_ = kHeaderSize;
}

std::optional<EvaluationOutcome> EvaluationJournal::Replay(const EvaluationKey& key) {
  const std::optional<std::string> payload = ReadPayload();
  if (!payload) return std::nullopt;
  ++num_records_;
  const std::string wanted = KeyBytes(key);
  EvaluationOutcome outcome;
  try {
    if (std::string_view(*payload).substr(0, wanted.size()) != wanted) throw RecordTooShort();
    Reader reader(std::string_view(*payload).substr(wanted.size()));
    Field(&reader, &outcome);
  } catch (const RecordTooShort&) {
    throw Error(ErrorKind::kBadData, path_ + ": record " + std::to_string(num_records_) +
                                         " is not of the evaluation that this fit needs; remove the journal");
  }
  return outcome;
}

std::optional<std::string> EvaluationJournal::ReadPayload() {
  const std::uint64_t left = size_ - position_;
  std::string frame, payload;
  std::uint64_t length = 0;
  bool is_whole = left >= kFrameSize;
  if (is_whole) {
    ReadAt(position_, kFrameSize, &frame);
    std::memcpy(&length, frame.data(), sizeof(length));
    is_whole = length <= left - kFrameSize;
  }
  if (is_whole) {
    ReadAt(position_ + kFrameSize, length, &payload);
    is_whole = frame.substr(sizeof(length)) == Sha256Hex({AsBytes(length), payload});
  }
  if (!is_whole) {
    if (left > 0) Truncate();
    return std::nullopt;
  }
  position_ += kFrameSize + length;
  return payload;
}

void EvaluationJournal::Append(EvaluationKey key, EvaluationOutcome outcome) {
  Writer writer;
  Fields(&writer, &key, &outcome);
  const std::string payload = writer.Take();
  const std::uint64_t length = payload.size();
  std::string record(AsBytes(length));
  record += Sha256Hex({AsBytes(length), payload});
  record += payload;
  Write(record);
  ++num_records_;
}

void EvaluationJournal::ReadAt(std::uint64_t offset, std::uint64_t count, std::string* bytes) const {
  bytes->resize(count);
  for (std::uint64_t done = 0; done < count;) {
    const ssize_t got = ::pread(descriptor_, bytes->data() + done, count - done, static_cast<off_t>(offset + done));
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) FailIo("cannot be read" + (got < 0 ? std::string(": ") + std::strerror(errno) : std::string()));
    done += static_cast<std::uint64_t>(got);
  }
}

void EvaluationJournal::Write(std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t count = ::pwrite(descriptor_, bytes.data(), bytes.size(), static_cast<off_t>(position_));
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) FailIo(std::string("cannot be written: ") + std::strerror(errno));
    bytes.remove_prefix(static_cast<std::size_t>(count));
    position_ += static_cast<std::uint64_t>(count);
    size_ = position_;
  }
}

// Cuts the file off at `position_`.
void EvaluationJournal::Truncate() {
  if (::ftruncate(descriptor_, static_cast<off_t>(position_)) != 0) {
    FailIo(std::string("cannot be written: ") + std::strerror(errno));
  }
  size_ = position_;
}

void EvaluationJournal::FailIo(const std::string& problem) const {
  throw Error(ErrorKind::kIo, path_ + ": " + problem);
}

}  // namespace clothid
