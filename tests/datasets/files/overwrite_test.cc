// An output is an input where both names lead to one file, however they are spelt.
#include "datasets/files/overwrite.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <string>

#include "tests/expect_error.h"
#include "tests/temporary_folder.h"

namespace clothid::overwrite_test {
namespace {

namespace fs = std::filesystem;

class OverwriteTest : public testing::Test {
 protected:
  TemporaryFolder folder_;
  const std::string input_ = folder_.Write("input", "what would be lost");
};

TEST_F(OverwriteTest, SpellingsAndLinksAreOneFile) {
  fs::create_symlink(input_, folder_.File("symbolic"));
  fs::create_hard_link(input_, folder_.File("hard"));
  fs::create_directory(folder_.File("sub"));
  const std::string relative = fs::relative(input_).string();
  for (const std::string& name : {input_, relative, folder_.File("./input"), folder_.File("sub/../input"),
                                  folder_.File("symbolic"), folder_.File("hard")}) {
    EXPECT_TRUE(IsSameFile(name, input_)) << name;
    EXPECT_TRUE(IsSameFile(input_, name)) << name;
  }
  folder_.Write("other", "what would be lost");
  EXPECT_FALSE(IsSameFile(folder_.File("other"), input_));
  EXPECT_FALSE(IsSameFile(folder_.File("absent"), input_));
}

TEST_F(OverwriteTest, FilesThatAreNotThereYetAreKnownByTheirNames) {
  EXPECT_TRUE(IsSameFile(folder_.File("new"), folder_.File("sub/../new")));
  EXPECT_TRUE(IsSameFile("clothid_absent", "./clothid_absent"));
  EXPECT_FALSE(IsSameFile(folder_.File("new"), folder_.File("newer")));
}

TEST_F(OverwriteTest, DevicesAndNoNamesAreNoFiles) {
  EXPECT_FALSE(IsSameFile("/dev/null", "/dev/null"));
  EXPECT_FALSE(IsSameFile("", ""));
}

TEST_F(OverwriteTest, RefusalNamesBoth) {
  ExpectError(
      [&] {
        RefuseOverwrite(input_, {"", folder_.File("absent"), input_});
      },
      ErrorKind::kUsage, {input_.c_str(), ": would replace an input; expected another name"});
  ExpectError([&] { RefuseOverwrite(folder_.File("./input"), {input_}); }, ErrorKind::kUsage,
              {"/./input: would replace the input ", input_.c_str()});
  RefuseOverwrite(folder_.File("output"), {input_});
  RefuseOverwrite("", {input_, ""});
}

}  // namespace
}  // namespace clothid::overwrite_test
