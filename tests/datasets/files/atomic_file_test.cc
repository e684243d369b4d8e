// A file is replaced whole or not at all, by one writer at a time, and nothing is left beside it.
#include "datasets/files/atomic_file.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <set>
#include <string>

#include "tests/expect_error.h"
#include "tests/temporary_folder.h"

namespace clothid::atomic_file_test {
namespace {

namespace fs = std::filesystem;

class AtomicFileTest : public testing::Test {
 protected:
  std::string Bytes(const std::string& name) const {
    std::ifstream file(folder_.File(name), std::ios::binary);
    return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
  }
  std::set<std::string> Names() const {
    std::set<std::string> names;
    for (const auto& entry : fs::directory_iterator(folder_.path())) names.insert(entry.path().filename());
    return names;
  }

  TemporaryFolder folder_;
  const std::string path_ = folder_.Write("file", "a longer text than the new one");
};

TEST_F(AtomicFileTest, ReplacesAFile) {
  CheckFileCanBeWritten(path_);
  EXPECT_EQ(Bytes("file"), "a longer text than the new one");
  WriteFileAtomically(path_, {"new ", "", "text"});
  EXPECT_EQ(Bytes("file"), "new text");
  CheckFileCanBeWritten(folder_.File("other"));
  EXPECT_EQ(Names(), std::set<std::string>{"file"});
}

TEST_F(AtomicFileTest, FollowsLinks) {
  fs::create_directory(folder_.File("sub"));
  fs::create_symlink("../file", folder_.File("sub/link"));
  WriteFileAtomically(folder_.File("sub/link"), {"new"});
  EXPECT_TRUE(fs::is_symlink(folder_.File("sub/link")));
  EXPECT_EQ(Bytes("file"), "new");
  EXPECT_EQ(Names(), (std::set<std::string>{"file", "sub"}));
}

TEST_F(AtomicFileTest, MakesTheFileThatALinkLeadsTo) {
  fs::create_directory(folder_.File("sub"));
  fs::create_symlink("second", folder_.File("first"));
  fs::create_symlink("sub/new", folder_.File("second"));
  CheckFileCanBeWritten(folder_.File("first"));
  WriteFileAtomically(folder_.File("first"), {"text"});
  EXPECT_TRUE(fs::is_symlink(folder_.File("first")));
  EXPECT_EQ(Bytes("sub/new"), "text");
  fs::create_symlink("loop", folder_.File("loop"));
  ExpectError([&] { WriteFileAtomically(folder_.File("loop"), {"text"}); }, ErrorKind::kIo,
              {"loop: cannot be written: Too many levels of symbolic links"});
  EXPECT_TRUE(fs::is_symlink(folder_.File("loop")));
}

TEST_F(AtomicFileTest, RefusesASecondWriterAndTakesOverFromADeadOne) {
  const std::string hidden = folder_.Write(".file.part", "what a process that was killed has left");
  const int other = ::open(hidden.c_str(), O_WRONLY);
  ASSERT_EQ(::flock(other, LOCK_EX), 0);
  for (const auto& write : {+[](const std::string& path) { CheckFileCanBeWritten(path); },
                            +[](const std::string& path) { WriteFileAtomically(path, {"new"}); }}) {
    ExpectError([&] { write(path_); }, ErrorKind::kIo, {"file: cannot be written", "another process"});
    EXPECT_EQ(Bytes("file"), "a longer text than the new one");
    EXPECT_EQ(Bytes(".file.part"), "what a process that was killed has left");
  }
  ::close(other);
  WriteFileAtomically(path_, {"new"});
  EXPECT_EQ(Bytes("file"), "new");
  EXPECT_EQ(Names(), std::set<std::string>{"file"});
}

TEST_F(AtomicFileTest, RefusesWhatIsNoFile) {
  fs::create_directory(folder_.File("sub"));
  for (const char* name : {"sub", "file/below", "absent/file"}) {
    const std::string path = folder_.File(name);
    ExpectError([&] { CheckFileCanBeWritten(path); }, ErrorKind::kIo, {name, "cannot be written: "});
    ExpectError([&] { WriteFileAtomically(path, {"new"}); }, ErrorKind::kIo, {name, "cannot be written: "});
  }
  EXPECT_EQ(Names(), (std::set<std::string>{"file", "sub"}));
}

// First the pipe: where it is replaced, /dev/full is better left alone.
TEST_F(AtomicFileTest, WritesToPipesAndDevicesAsTheyAre) {
  const std::string path = folder_.File("pipe");
  ASSERT_EQ(::mkfifo(path.c_str(), 0600), 0);
  const int reader = ::open(path.c_str(), O_RDONLY | O_NONBLOCK);
  CheckFileCanBeWritten(path);
  WriteFileAtomically(path, {"new"});
  char text[8] = {};
  EXPECT_EQ(::read(reader, text, sizeof(text)), 3);
  EXPECT_STREQ(text, "new");
  ::close(reader);
  ASSERT_TRUE(fs::is_fifo(path));
  if (!fs::is_character_file("/dev/full")) GTEST_SKIP() << "no /dev/full here";
  ExpectError([] { WriteFileAtomically("/dev/full", {"new"}); }, ErrorKind::kIo, {"/dev/full: cannot be written: No"});
}

TEST_F(AtomicFileTest, FlushesFilesAndFolders) {
  EXPECT_TRUE(FlushToDisk(path_));
  EXPECT_TRUE(FlushToDisk(folder_.path()));
  EXPECT_FALSE(FlushToDisk(folder_.File("absent")));
}

}  // namespace
}  // namespace clothid::atomic_file_test
