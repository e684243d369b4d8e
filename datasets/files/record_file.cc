#include "datasets/files/record_file.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

#include "datasets/files/sha256.h"
#include "sim/base/error.h"

namespace clothid {
namespace {

constexpr std::uint64_t kDigestSize = 64;
constexpr std::uint64_t kLengthsSize = 2 * sizeof(std::uint64_t);
constexpr std::uint64_t kFrameSize = kLengthsSize + kDigestSize;  // of a record, before its payload

std::string MakeFrame(std::string_view payload) {
  const std::uint64_t lengths[] = {payload.size(), ~static_cast<std::uint64_t>(payload.size())};
  std::string frame(reinterpret_cast<const char*>(lengths), kLengthsSize);
  return frame += Sha256Hex({payload});
}

}  // namespace

RecordFile::RecordFile(const std::string& path, const Kind& kind, const std::string& fingerprint) : path_(path) {
  descriptor_ = ::open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666);
  if (descriptor_ < 0) FailIo(std::string("cannot be opened: ") + std::strerror(errno));
  try {
    // The lock ends with its process, however that ends.
    if (::flock(descriptor_, LOCK_EX | LOCK_NB) != 0) {
      FailIo(errno == EWOULDBLOCK ? "another process uses this file"
                                  : std::string("cannot be locked: ") + std::strerror(errno));
    }
    ReadOrWriteHeader(kind, fingerprint);
  } catch (...) {
    ::close(descriptor_);
    throw;
  }
}

RecordFile::~RecordFile() { ::close(descriptor_); }

void RecordFile::ReadOrWriteHeader(const Kind& kind, const std::string& fingerprint) {
  struct stat status = {};
  if (::fstat(descriptor_, &status) != 0) FailIo(std::string("cannot be read: ") + std::strerror(errno));
  size_ = static_cast<std::uint64_t>(status.st_size);
  const std::string title = kind.title + "\n", wanted = title + fingerprint + "\n";
  std::string header;
  ReadAt(0, std::min<std::uint64_t>(size_, wanted.size()), &header);
  if (std::string_view(header).substr(0, title.size()) != std::string_view(title).substr(0, header.size())) {
    throw Error(ErrorKind::kBadData, path_ + ": expected " + kind.expected);
  }
  if (size_ < wanted.size()) {  // torn, so nothing was ever recorded
    Truncate();
    Write(wanted);
  } else if (header != wanted) {
    throw Error(ErrorKind::kUsage, path_ + ": " + kind.mismatch);
  }
  position_ = wanted.size();
}

RecordFile::Next RecordFile::Read(std::string* payload) {
  const std::uint64_t left = size_ - position_;
  if (left == 0) return Next::kEnd;
  if (left < kFrameSize) return Next::kTorn;
  std::string frame;
  ReadAt(position_, kFrameSize, &frame);
  std::uint64_t lengths[2] = {};
  std::memcpy(lengths, frame.data(), kLengthsSize);
  if (lengths[0] != ~lengths[1]) return IsZeroToTheEnd() ? Next::kTorn : Next::kDamaged;
  if (lengths[0] > kMaxRecordBytes) return Next::kDamaged;
  if (lengths[0] > left - kFrameSize) return Next::kTorn;
  ReadAt(position_ + kFrameSize, lengths[0], payload);
  if (frame != MakeFrame(*payload)) return lengths[0] == left - kFrameSize ? Next::kTorn : Next::kDamaged;
  position_ += kFrameSize + lengths[0];
  return Next::kRecord;
}

void RecordFile::Append(std::string_view payload) {
  Truncate();
  Write(MakeFrame(payload));
  Write(payload);
}

// What a file system leaves where a power cut came between the size of the file and its bytes.
bool RecordFile::IsZeroToTheEnd() const {
  constexpr std::uint64_t kChunk = 1 << 16;
  std::string bytes;
  for (std::uint64_t offset = position_; offset < size_; offset += bytes.size()) {
    ReadAt(offset, std::min(kChunk, size_ - offset), &bytes);
    if (bytes.find_first_not_of('\0') != std::string::npos) return false;
  }
  return true;
}

void RecordFile::ReadAt(std::uint64_t offset, std::uint64_t count, std::string* bytes) const {
  bytes->resize(count);
  for (std::uint64_t done = 0; done < count;) {
    const ssize_t got = ::pread(descriptor_, bytes->data() + done, count - done, static_cast<off_t>(offset + done));
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) FailIo("cannot be read" + (got < 0 ? std::string(": ") + std::strerror(errno) : std::string()));
    done += static_cast<std::uint64_t>(got);
  }
}

void RecordFile::Write(std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t count = ::pwrite(descriptor_, bytes.data(), bytes.size(), static_cast<off_t>(position_));
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) FailIo(std::string("cannot be written: ") + std::strerror(errno));
    bytes.remove_prefix(static_cast<std::size_t>(count));
    position_ += static_cast<std::uint64_t>(count);
    size_ = position_;
  }
}

void RecordFile::Truncate() {
  if (position_ == size_) return;
  if (::ftruncate(descriptor_, static_cast<off_t>(position_)) != 0) {
    FailIo(std::string("cannot be written: ") + std::strerror(errno));
  }
  size_ = position_;
}

void RecordFile::FailIo(const std::string& problem) const { throw Error(ErrorKind::kIo, path_ + ": " + problem); }

}  // namespace clothid
