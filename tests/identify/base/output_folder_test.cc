// All files or none, and no trace of a run that failed.
#include "identify/base/output_folder.h"

#include <gtest/gtest.h>
#include <stdlib.h>

#include <fstream>
#include <iterator>

#include "tests/expect_error.h"

namespace clothid::output_folder_test {
namespace {

namespace fs = std::filesystem;

class OutputFolderTest : public testing::Test {
 protected:
  OutputFolderTest() {
    std::string name = testing::TempDir() + "clothid_output_XXXXXX";
    EXPECT_NE(mkdtemp(name.data()), nullptr);
    root_ = name;
  }
  ~OutputFolderTest() override { fs::remove_all(root_); }

  static std::string Read(const fs::path& path) {
    std::ifstream file(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
  }
  static std::ptrdiff_t NumEntries(const fs::path& path) {
    return std::distance(fs::directory_iterator(path), fs::directory_iterator());
  }

  fs::path root_;
};

TEST_F(OutputFolderTest, CommitGivesTheNames) {
  const fs::path path = root_ / "a" / "b";
  {
    OutputFolder folder(path.string() + "/");
    EXPECT_EQ(NumEntries(path), 0);
    folder.Write("x.txt", "one\n");
    folder.Write("x.txt", "two\n");
    std::ofstream(folder.TemporaryPath("y.bin")) << "three";
    EXPECT_FALSE(fs::exists(path / "x.txt"));
    folder.Commit();
  }
  EXPECT_EQ(NumEntries(path), 2);
  EXPECT_EQ(Read(path / "x.txt"), "two\n");
  EXPECT_EQ(Read(path / "y.bin"), "three");
}

TEST_F(OutputFolderTest, WithoutCommitNothingIsLeft) {
  {
    OutputFolder folder((root_ / "a" / "b").string());
    folder.Write("x.txt", "one");
  }
  EXPECT_EQ(NumEntries(root_), 0);
}

TEST_F(OutputFolderTest, KeepsWhatWasThere) {
  std::ofstream(root_ / "x.txt") << "old";
  {
    OutputFolder folder(root_.string());
    folder.Write("x.txt", "new");
  }
  EXPECT_EQ(NumEntries(root_), 1);
  EXPECT_EQ(Read(root_ / "x.txt"), "old");
}

TEST_F(OutputFolderTest, RemovesWhatAKilledRunLeft) {
  fs::create_directory(root_ / ".clothid_part");
  std::ofstream(root_ / ".clothid_part" / "y.txt") << "half of";
  OutputFolder folder(root_.string());
  EXPECT_EQ(NumEntries(root_), 0);
}

TEST_F(OutputFolderTest, CommitRemovesJournals) {
  std::ofstream(root_ / ".journal_1.bin") << "old";
  {
    OutputFolder folder(root_.string());
    folder.Write("x.txt", "new");
    std::ofstream(root_ / ".journal_2.bin") << "new";
    EXPECT_TRUE(fs::exists(root_ / ".journal_1.bin"));
    folder.Commit();
  }
  EXPECT_EQ(NumEntries(root_), 1);
  EXPECT_EQ(Read(root_ / "x.txt"), "new");
}

TEST_F(OutputFolderTest, OneAtATime) {
  const std::string path = (root_ / "a").string();
  {
    OutputFolder first(path);
    first.Write("x.txt", "first");
    ExpectError([&] { OutputFolder second(path); }, ErrorKind::kIo, {"--output", "a: another process"});
    first.Commit();
    ExpectError([&] { OutputFolder second(path); }, ErrorKind::kIo, {"--output", "a: another process"});
  }
  EXPECT_EQ(Read(root_ / "a" / "x.txt"), "first");
  OutputFolder second(path);
}

TEST_F(OutputFolderTest, AFitWhoseResultsCannotBeWrittenKeepsItsJournals) {
  fs::create_directory(root_ / "x.txt");
  {
    OutputFolder folder(root_.string());
    std::ofstream(root_ / ".journal_1.bin") << "new";
    folder.Write("x.txt", "new");
    ExpectError([&] { folder.Commit(); }, ErrorKind::kIo, {"x.txt: cannot be written"});
  }
  EXPECT_EQ(NumEntries(root_), 2);
  EXPECT_EQ(Read(root_ / ".journal_1.bin"), "new");
}

TEST_F(OutputFolderTest, CommitsAllOrNothing) {
  fs::create_directory(root_ / "y.txt");
  {
    OutputFolder folder(root_.string());
    folder.Write("x.txt", "new");
    folder.Write("y.txt", "new");
    ExpectError([&] { folder.Commit(); }, ErrorKind::kIo, {"--output", "y.txt: cannot be written", "folder"});
  }
  EXPECT_EQ(NumEntries(root_), 1);
}

TEST_F(OutputFolderTest, CommitRemovesEarlierResults) {
  for (const char* name : {"x.txt", "old.txt", "old.csv"}) std::ofstream(root_ / name) << "old";
  fs::create_directory(root_ / "folder.txt");
  {
    OutputFolder folder(root_.string());
    folder.RemoveOthers([](const std::string& name) { return fs::path(name).extension() == ".txt"; });
    folder.Write("x.txt", "new");
    folder.Write("y.txt", "new");
    folder.Drop("y.txt");
    EXPECT_EQ(NumEntries(root_), 5);
    folder.Commit();
  }
  EXPECT_EQ(NumEntries(root_), 3);
  EXPECT_EQ(Read(root_ / "x.txt"), "new");
  EXPECT_EQ(Read(root_ / "old.csv"), "old");
  EXPECT_TRUE(fs::exists(root_ / "folder.txt"));
}

TEST_F(OutputFolderTest, AFolderThatWasRemovedIsMadeAgain) {
  OutputFolder folder((root_ / "a" / "b").string());
  fs::remove_all(root_ / "a");
  folder.Write("x.txt", "new");
  ExpectError([&] { OutputFolder second(folder.path()); }, ErrorKind::kIo, {"b: another process"});
  folder.Commit();
  EXPECT_EQ(Read(root_ / "a" / "b" / "x.txt"), "new");
}

TEST_F(OutputFolderTest, RefusesInputsThatResultsWouldReplace) {
  const auto is_result = [](const std::string& name) { return name == "x.bin"; };
  const std::string folder = (root_ / "a").string();
  ExpectNotReplaced("--target", folder + "/x.bin", folder, is_result);
  fs::create_directory(folder);
  for (const char* name : {"x.bin", "y.bin"}) std::ofstream(fs::path(folder) / name) << "old";
  ExpectNotReplaced("--target", folder + "/y.bin", folder, is_result);
  ExpectNotReplaced("--target", folder + "/absent.bin", folder, is_result);
  fs::create_symlink(folder + "/x.bin", root_ / "link.bin");
  for (const std::string& input : {folder + "/x.bin", folder + "/../a/x.bin", (root_ / "link.bin").string()}) {
    ExpectError([&] { ExpectNotReplaced("--target", input, folder + "/", is_result); }, ErrorKind::kUsage,
                {"--target: ", input.c_str(), "would replace it"});
  }
}

TEST_F(OutputFolderTest, KeepsJournalsOnRequest) {
  {
    OutputFolder folder((root_ / "a").string());
    std::ofstream(fs::path(folder.path()) / ".journal_1.bin") << "new";
    folder.KeepJournals();
    folder.Commit();
  }
  EXPECT_EQ(Read(root_ / "a" / ".journal_1.bin"), "new");
}

TEST_F(OutputFolderTest, WithoutCommitOnlyOldJournalsAreLeft) {
  std::ofstream(root_ / ".journal_1.bin") << "old";
  {
    OutputFolder old(root_.string()), made((root_ / "a").string());
    for (const OutputFolder* folder : {&old, &made})
      std::ofstream(fs::path(folder->path()) / ".journal_2.bin") << "new";
  }
  EXPECT_EQ(NumEntries(root_), 1);
  EXPECT_EQ(Read(root_ / ".journal_1.bin"), "old");
}

TEST_F(OutputFolderTest, RefusesWhatCannotBeWritten) {
  std::ofstream(root_ / "file") << "content";
  const std::string file = (root_ / "file").string();
  ExpectError([&] { OutputFolder folder(file); }, ErrorKind::kIo, {"--output", "file", "not a folder"});
  ExpectError([&] { OutputFolder folder(file + "/sub/sub"); }, ErrorKind::kIo, {"--output", "file"});
  ExpectError([&] { OutputFolder folder("/proc/clothid"); }, ErrorKind::kIo, {"--output", "/proc/clothid"});
  ExpectError([] { OutputFolder folder(""); }, ErrorKind::kUsage, {"--output"});
  EXPECT_EQ(NumEntries(root_), 1);
}

}  // namespace
}  // namespace clothid::output_folder_test
