// What `identify` refuses as a program: one line, the right exit code, nothing left behind.
#include <gtest/gtest.h>

#include <string>

#include "tests/tools/tool_test.h"

namespace clothid {
namespace {

class IdentifyTest : public ToolTest {
 protected:
  IdentifyTest() { ExpectSuccess("simulate --scene " + WriteScene(SphereScene()) + " --output good.bin"); }

  void ExpectFlagsRefused(const std::string& flags, const std::string& culprit) const {
    ExpectRefused("identify --target good.bin --output result " + flags, 1, culprit);
  }
};

TEST_F(IdentifyTest, RefusesWrongFlags) {
  ExpectRefused("identify --output result", 1, "--target");
  ExpectRefused("identify --target good.bin extra", 1, "'extra'");
  ExpectFlagsRefused("--bogus", "bogus");
  ExpectFlagsRefused("--jacobian exact", "exact");
  ExpectFlagsRefused("--method newton", "newton");
  ExpectFlagsRefused("--loss cubic", "cubic");
  ExpectFlagsRefused("--max_iterations 0", "--max_iterations");
  ExpectFlagsRefused("--threads 0", "--threads");
  ExpectFlagsRefused("--fit mu,,k_stretch", "--fit");
  ExpectFlagsRefused("--fit weight", "weight");
  ExpectFlagsRefused("--fit mu.ghost", "mu.ghost");
}

TEST_F(IdentifyTest, RefusesWrongParameters) {
  ExpectFlagsRefused("--start mu=nan", "mu");
  ExpectFlagsRefused("--start mu=-0.1", "mu");
  ExpectFlagsRefused("--start k_stretch=-1", "k_stretch");
  ExpectFlagsRefused("--start k_stretch=0", "k_stretch");
  ExpectFlagsRefused("--start k_stretch=inf", "k_stretch");
  ExpectFlagsRefused("--start k_stretch", "k_stretch");
  ExpectFlagsRefused("--lower mu=0.5 --upper mu=0.4", "mu");
  ExpectFlagsRefused("--lower k_stretch=nan", "k_stretch");
}

TEST_F(IdentifyTest, RefusesFilesThatCannotBeOpenedOrWritten) {
  ExpectRefused("identify --target absent.bin --output result", 1, "absent.bin");
  ExpectRefused("identify --target good.bin --scene absent.json --output result", 1, "absent.json");
  ExpectRefused("identify --target good.bin --output good.bin", 1, "good.bin");
  ExpectRefused("identify --target good.bin --output good.bin/result", 1, "good.bin/result");
  ExpectRefused("identify --target good.bin --output /proc/result", 1, "/proc/result");
}

TEST_F(IdentifyTest, RefusesBadRecordings) {
  const std::string good = ReadBytes(folder() / "good.bin");
  WriteBytes(folder() / "bad.bin", good.substr(0, good.size() - 8));
  ExpectRefused("identify --target bad.bin --output result", 2, "bad.bin");
  std::string flipped = good;
  flipped.back() = static_cast<char>(flipped.back() ^ 1);
  WriteBytes(folder() / "bad.bin", flipped);
  ExpectRefused("identify --target good.bin,bad.bin --output result", 2, "bad.bin");
  WriteBytes(folder() / "bad.json", R"({"clothid_scene": 1, "handels": []})");
  ExpectRefused("identify --target good.bin --scene bad.json --output result", 2, "handels");
}

}  // namespace
}  // namespace clothid
