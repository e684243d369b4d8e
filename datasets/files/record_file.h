// A file of records that may be added to until its process is killed: that takes at most the record under way.
//
// The file: the title of its kind, "\n", a fingerprint (64 hexadecimal digits), "\n", then records: the length of the
// payload (8 bytes), the complement of the length (8 bytes), the SHA-256 of the payload (64 digits), the payload. What
// is read is checked; the two lengths tell a record whose end is missing from one that was damaged.
#ifndef CLOTHID_DATASETS_FILES_RECORD_FILE_H_
#define CLOTHID_DATASETS_FILES_RECORD_FILE_H_

#include <cstdint>
#include <string>
#include <string_view>

namespace clothid {

// The longest payload. A record that claims more counts as damaged.
inline constexpr std::uint64_t kMaxRecordBytes = std::uint64_t{1} << 30;

class RecordFile {
 public:
  // What the file is for, in words for messages.
  struct Kind {
    std::string title;     // "clothid journal 3"
    std::string expected;  // "a journal of evaluations, version 2"
    std::string mismatch;  // completes "FILE: " where the fingerprint is another one
  };

  // Opens or makes the file. `fingerprint` [64 digits] stands for everything that determines the records. Throws
  // `Error`: kIo where the file cannot be opened or written or another process has it open, kBadData where it is of
  // another kind, kUsage where it has another fingerprint.
  RecordFile(const std::string& path, const Kind& kind, const std::string& fingerprint);
  ~RecordFile();
  RecordFile(const RecordFile&) = delete;
  RecordFile& operator=(const RecordFile&) = delete;

  enum class Next {
    kRecord,   // `payload` holds it
    kEnd,      // there is none left
    kTorn,     // the last record is not whole, or zeros to the end: its process, or the machine, came to an end
    kDamaged,  // a record is not what was written, and others may follow
  };
  // Reads the next record. Throws `Error` (kIo).
  Next Read(std::string* payload);

  // Adds a record behind those that were read; whatever stood there is cut off. The end of the process cannot undo it
  // once it is added, and tears it before. The end of the machine may take the records of the last half minute: to
  // flush each to the disk would take longer than to make a small one again. Throws `Error` (kIo).
  void Append(std::string_view payload);
  // Cuts off what stands behind the records that were read or added. Throws `Error` (kIo).
  void Truncate();

  const std::string& path() const { return path_; }

 private:
  void ReadOrWriteHeader(const Kind& kind, const std::string& fingerprint);
  bool IsZeroToTheEnd() const;
  void ReadAt(std::uint64_t offset, std::uint64_t count, std::string* bytes) const;
  void Write(std::string_view bytes);
  [[noreturn]] void FailIo(const std::string& problem) const;

  std::string path_;
  int descriptor_ = -1;
  std::uint64_t size_ = 0;      // of the file
  std::uint64_t position_ = 0;  // end of what was read or added
};

}  // namespace clothid

#endif  // CLOTHID_DATASETS_FILES_RECORD_FILE_H_
