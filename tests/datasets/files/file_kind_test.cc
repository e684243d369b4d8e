// What a file is called that is no recording.
#include "datasets/files/file_kind.h"

#include <gtest/gtest.h>

#include <string>

namespace clothid::file_kind_test {
namespace {

TEST(FileKind, TellsFilesByTheirStart) {
  EXPECT_EQ(FileKind("\x1f\x8b\x08"), "packed with gzip");
  EXPECT_EQ(FileKind(std::string("PK\x03\x04\x14\0", 6)), "packed with zip (.npz is, too)");
  EXPECT_EQ(FileKind("\x93NUMPY\x01"), "a NumPy array");
  EXPECT_EQ(FileKind("ply\nformat ascii 1.0\n"), "a PLY mesh");
  EXPECT_EQ(FileKind(" \n{\"a\": 1}"), "JSON text");
  EXPECT_EQ(FileKind("[1, 2]"), "JSON text");
  EXPECT_EQ(FileKind("t,id,x,y,z\r\n"), "text");
}

TEST(FileKind, SaysNothingOfOtherBytes) {
  EXPECT_EQ(FileKind(""), "");
  EXPECT_EQ(FileKind(std::string("\x38\x04\0\0\0\0\0\0{\"__metadata__\"", 24)), "");
  EXPECT_EQ(FileKind(std::string("text\0", 5)), "");
  EXPECT_EQ(FileKind("\xff\xff\xff\xff\xff\xff\xff\xff{\"__metadata__\""), "");
}

}  // namespace
}  // namespace clothid::file_kind_test
