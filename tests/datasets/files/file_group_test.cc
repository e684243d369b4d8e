// Files that belong together come to their places together, by one writer at a time, and nothing is left beside them.
#include "datasets/files/file_group.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/file.h>
#include <unistd.h>

#include <filesystem>
#include <set>
#include <string>

#include "sim/base/text_file.h"
#include "tests/expect_error.h"
#include "tests/temporary_folder.h"

namespace clothid::file_group_test {
namespace {

namespace fs = std::filesystem;

using Strings = std::set<std::string>;

class FileGroupTest : public testing::Test {
 protected:
  Strings Names() const {
    Strings names;
    for (const auto& entry : fs::directory_iterator(folder_.path())) names.insert(entry.path().filename());
    return names;
  }
  std::string Text(const std::string& name) const { return ReadFile(folder_.File(name), 100); }

  TemporaryFolder folder_;
  const std::string path_ = folder_.File("group");
};

TEST_F(FileGroupTest, ReplacesFilesTogether) {
  folder_.Write("a", "old");
  folder_.Write("c", "old");
  {
    FileGroup group(path_);
    group.Write("a", "new");
    group.Write("b", "new");
    group.Remove("c");
    group.Remove("absent");
    EXPECT_EQ(Text("a"), "old");
    group.Commit();
  }
  EXPECT_EQ(Names(), (Strings{"a", "b"}));
  EXPECT_EQ(Text("a"), "new");
}

TEST_F(FileGroupTest, LeavesNothingWithoutCommit) {
  folder_.Write("a", "old");
  { FileGroup(path_).Write("a", "new"); }
  EXPECT_EQ(Names(), Strings{"a"});
  EXPECT_EQ(Text("a"), "old");
}

TEST_F(FileGroupTest, ChangesNothingWhereAPlaceIsTaken) {
  folder_.Write("a", "old");
  fs::create_directory(folder_.File("b"));
  {
    FileGroup group(path_);
    group.Write("a", "new");
    group.Write("b", "new");
    ExpectError([&] { group.Commit(); }, ErrorKind::kIo, {"/b: cannot be written: "});
  }
  EXPECT_EQ(Names(), (Strings{"a", "b"}));
  EXPECT_EQ(Text("a"), "old");
}

TEST_F(FileGroupTest, RefusesASecondWriterAndTakesOverFromADeadOne) {
  fs::create_directory(folder_.File(".group.part"));
  folder_.Write(".group.part/left", "by a process that was killed");
  {
    FileGroup group(path_);
    EXPECT_TRUE(fs::is_empty(folder_.File(".group.part")));
    group.Write("a", "new");
    ExpectError([&] { FileGroup second(path_); }, ErrorKind::kIo, {"group: cannot be written: another process"});
    group.Commit();
  }
  EXPECT_EQ(Names(), Strings{"a"});
}

TEST_F(FileGroupTest, RefusesAFolderThatIsNotThere) {
  ExpectError([&] { FileGroup group(folder_.File("absent/group")); }, ErrorKind::kIo, {"absent/group: cannot be wr"});
}

}  // namespace
}  // namespace clothid::file_group_test
