// What was written comes back, and a damaged record is told from one that is not whole.
#include "datasets/files/record_file.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <vector>

#include "tests/expect_error.h"
#include "tests/temporary_folder.h"

namespace clothid::record_file_test {
namespace {

using Next = RecordFile::Next;

const std::string kFingerprint(64, 'a');
const RecordFile::Kind kKind = {"clothid test 1", "a file of tests", "is of another test"};
const std::vector<std::string> kRecords = {"one", "", std::string("thr\0e", 5)};

class RecordFileTest : public testing::Test {
 protected:
  RecordFileTest() : path_(folder_.File("records")) {
    RecordFile file(path_, kKind, kFingerprint);
    for (const std::string& record : kRecords) {
      ends_.push_back(Bytes().size());
      file.Append(record);
    }
    whole_ = Bytes();
  }

  std::string Bytes() const {
    std::ifstream file(path_, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
  }

  // The records up to the first that is none, and what that is.
  static Next ReadAll(RecordFile* file, std::vector<std::string>* records) {
    std::string record;
    for (;;) {
      const Next next = file->Read(&record);
      if (next != Next::kRecord) return next;
      records->push_back(record);
    }
  }

  TemporaryFolder folder_;
  std::string path_, whole_;
  std::vector<std::size_t> ends_;  // [i] of the file before record i
};

TEST_F(RecordFileTest, GivesBackWhatWasAdded) {
  std::vector<std::string> records;
  RecordFile file(path_, kKind, kFingerprint);
  EXPECT_EQ(ReadAll(&file, &records), Next::kEnd);
  EXPECT_EQ(records, kRecords);
  EXPECT_EQ(Bytes(), whole_);
}

TEST_F(RecordFileTest, GoesOnFromEveryTornTail) {
  for (std::size_t length = 0; length < whole_.size(); ++length) {
    folder_.Write("records", whole_.substr(0, length));
    std::vector<std::string> records;
    RecordFile file(path_, kKind, kFingerprint);
    const Next next = ReadAll(&file, &records);
    std::size_t num_whole = 0;
    while (num_whole + 1 < ends_.size() && ends_[num_whole + 1] <= length) ++num_whole;
    ASSERT_EQ(records.size(), num_whole) << length;
    ASSERT_EQ(next, length <= ends_[0] || length == ends_[num_whole] ? Next::kEnd : Next::kTorn) << length;
    for (std::size_t i = num_whole; i < kRecords.size(); ++i) file.Append(kRecords[i]);
    ASSERT_EQ(Bytes(), whole_) << length;
  }
}

TEST_F(RecordFileTest, TellsDamageFromATornTail) {
  for (std::size_t i = ends_[0]; i < whole_.size(); ++i) {
    std::string damaged = whole_;
    damaged[i] = static_cast<char>(damaged[i] ^ (1 << (i % 8)));
    folder_.Write("records", damaged);
    std::vector<std::string> records;
    RecordFile file(path_, kKind, kFingerprint);
    const Next next = ReadAll(&file, &records);
    const std::size_t record = i < ends_[1] ? 0 : i < ends_[2] ? 1 : 2;
    ASSERT_EQ(records.size(), record) << i;
    const bool is_length = i - ends_[record] < 16;
    ASSERT_EQ(next, record == 2 && !is_length ? Next::kTorn : Next::kDamaged) << i;
    ASSERT_EQ(Bytes(), damaged) << "nothing is cut off before it is asked for";
    file.Truncate();
    ASSERT_EQ(Bytes(), whole_.substr(0, ends_[record])) << i;
  }
}

// What a power cut may leave of a file that has grown.
TEST_F(RecordFileTest, GoesOnFromZeros) {
  for (const std::size_t num_zeros : {1, 79, 80, 200, 200000}) {
    folder_.Write("records", whole_ + std::string(num_zeros, '\0'));
    std::vector<std::string> records;
    RecordFile file(path_, kKind, kFingerprint);
    ASSERT_EQ(ReadAll(&file, &records), Next::kTorn) << num_zeros;
    EXPECT_EQ(records, kRecords);
    file.Append("four");
    EXPECT_EQ(Bytes().size(), whole_.size() + 80 + 4);
  }
  folder_.Write("records", whole_ + std::string(200000, '\0') + "x");
  std::vector<std::string> records;
  RecordFile file(path_, kKind, kFingerprint);
  EXPECT_EQ(ReadAll(&file, &records), Next::kDamaged);
}

TEST_F(RecordFileTest, ARecordBeyondTheLimitIsDamaged) {
  const std::uint64_t lengths[] = {kMaxRecordBytes + 1, ~(kMaxRecordBytes + 1)};
  folder_.Write("records", whole_.substr(0, ends_[0]) + std::string(reinterpret_cast<const char*>(lengths), 16));
  std::filesystem::resize_file(path_, kMaxRecordBytes << 1);  // sparse
  std::string payload;
  EXPECT_EQ(RecordFile(path_, kKind, kFingerprint).Read(&payload), Next::kDamaged);
  EXPECT_LT(payload.capacity(), kMaxRecordBytes);
}

TEST_F(RecordFileTest, RefusesOtherFiles) {
  ExpectError([&] { RecordFile(path_, kKind, std::string(64, 'b')); }, ErrorKind::kUsage, {"records", "another test"});
  ExpectError(
      [&] {
        RecordFile(path_, {"clothid test 2", "a newer file", ""}, kFingerprint);
      },
      ErrorKind::kBadData, {"records", "expected a newer file"});
  ExpectError([&] { RecordFile(path_ + "/below", kKind, kFingerprint); }, ErrorKind::kIo, {"below", "opened"});
  EXPECT_EQ(Bytes(), whole_);
  const RecordFile file(path_, kKind, kFingerprint);
  ExpectError([&] { RecordFile(path_, kKind, kFingerprint); }, ErrorKind::kIo, {"records", "another process"});
}

}  // namespace
}  // namespace clothid::record_file_test
