// Whatever the file system or a signal does to a program: results are whole and either all old or all new, nothing else
// is left behind, and the reason is said in a line.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <chrono>
#include <map>
#include <optional>
#include <ostream>
#include <random>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include "tests/last_line.h"
#include "tests/tools/tool_process.h"
#include "tests/tools/tool_test.h"

namespace clothid::hostile_filesystem_test {
namespace {

namespace fs = std::filesystem;
using Contents = std::map<std::string, std::string>;

// A program that writes into the folder `out`.
struct Writer {
  std::string name;
  std::vector<std::string> words;      // of its command line
  std::set<std::string> results;       // the files that it writes
  std::vector<std::string> long_work;  // flags that make it run until it is stopped
  std::string kept;                    // what is kept when it is stopped, for its next run
};

void PrintTo(const Writer& writer, std::ostream* out) { *out << writer.name; }

const std::vector<std::string> kScan = {"landscape", "--target",         "a.bin", "--x", "k_stretch=50:200:4:log",
                                        "--y",       "density=0.1:0.2:3"};
const std::set<std::string> kLandscape = {"landscape.csv", "plan.json", "summary.json", "timing.csv"};

std::vector<std::string> With(std::vector<std::string> words, const std::vector<std::string>& more) {
  words.insert(words.end(), more.begin(), more.end());
  return words;
}

const Writer kSimulate = {"simulate",
                          {"simulate", "--scene", "scene.json", "--output", "out/motion.bin"},
                          {"motion.bin"},
                          {"--scene", "long.json"},
                          ""};
const Writer kIdentify = {
    "identify",
    {"identify", "--target", "a.bin", "--fit", "k_stretch", "--output", "out"},
    {"result.json", "fabric.json", "convergence.csv", "predicted.bin", "card.html", "report.html"},
    {"--starts", "10000"},
    ""};
const Writer kLandscapeScan = {
    "landscape", With(kScan, {"--output", "out"}), kLandscape, {"--y", "density=0.1:0.2:3000"}, ".landscape_cells"};
const Writer kLandscapeMerge = {
    "landscape_merge", {"landscape", "merge", "part0", "part1", "--output", "out"}, kLandscape, {}, ""};
const Writer kBenchmark = {"benchmark",
                           {"benchmark", "backprop", "--scene", "wind", "--settings", "soft", "--nodes", "6", "--steps",
                            "2", "--repeats", "2", "--output", "out"},
                           {"backprop.csv"},
                           {"--nodes", "12,24", "--steps", "20", "--scene", "wind,slope"},
                           ""};

std::string Line(const std::vector<std::string>& words) {
  std::string line;
  for (const std::string& word : words) line += (line.empty() ? "" : " ") + word;
  return line;
}

class HostileTest : public ToolTest {
 protected:
  HostileTest() {
    nlohmann::ordered_json scene = BareScene();
    scene["duration"] = 0.5;
    WriteScene(scene);
    EXPECT_EQ(Run("simulate --scene scene.json --set k_stretch=120 --output a.bin").exit_code, 0);
    fs::create_directory(out());
  }

  fs::path out() const { return folder() / "out"; }

  Contents ReadOut() const {
    Contents files;
    for (const auto& entry : fs::directory_iterator(out())) {
      files[entry.path().filename()] = entry.is_regular_file() ? ReadBytes(entry.path()) : "";
    }
    return files;
  }

  // `command` must fail with a last line on stderr that holds `culprit` and `reason`.
  void ExpectFails(const std::string& command, const std::string& culprit, const std::string& reason) const {
    const ToolResult result = Run(command);
    EXPECT_EQ(result.exit_code, 1) << command << "\n" << result.err;
    const std::string line = LastLine(result.err);
    EXPECT_NE(line.find(culprit), std::string::npos) << command << "\n" << result.err;
    EXPECT_NE(line.find(reason), std::string::npos) << command << "\n" << result.err;
  }

  // The words that run a command with file systems of its own; nothing where that is not permitted.
  std::optional<std::string> Namespace() const {
    for (const char* words : {"unshare -m", "unshare -rm"}) {
      if (Run(std::string(words) + " mount -t tmpfs none out").exit_code == 0) return words;
    }
    return std::nullopt;
  }
};

class WriterTest : public HostileTest, public testing::WithParamInterface<Writer> {
 protected:
  WriterTest() {
    if (GetParam().name != kLandscapeMerge.name) return;
    for (const std::string index : {"0", "1"}) {
      const ToolResult result = Run(Line(kScan) + " --shard " + index + "/2 --output part" + index);
      EXPECT_EQ(result.exit_code, 0) << result.err;
    }
  }

  std::string Command() const { return Line(GetParam().words); }

  void ExpectRuns() const {
    const ToolResult result = Run(Command());
    ASSERT_EQ(result.exit_code, 0) << result.err;
    ExpectResults();
  }
  void ExpectResults() const {
    std::set<std::string> names;
    for (const auto& [name, content] : ReadOut()) {
      names.insert(name);
      EXPECT_GT(content.size(), 100u) << name;
    }
    EXPECT_EQ(names, GetParam().results);
  }
  // As `before`, beside what is kept for the next run, and removes that.
  void ExpectUnchanged(const Contents& before, const std::string& after_what) const {
    if (!GetParam().kept.empty()) fs::remove(out() / GetParam().kept);
    EXPECT_TRUE(ReadOut() == before) << after_what;
  }
};

INSTANTIATE_TEST_SUITE_P(Programs, WriterTest,
                         testing::Values(kSimulate, kIdentify, kLandscapeScan, kLandscapeMerge, kBenchmark),
                         [](const auto& writer) { return writer.param.name; });

// Those that may run for long.
class LongWriterTest : public WriterTest {
 protected:
  LongWriterTest() {
    nlohmann::ordered_json scene = BareScene();
    scene["duration"] = 1e4;
    WriteScene(scene, "long.json");
  }

  // Asks without taking the lock, which would be in the way of the program.
  bool IsLocked() const {
    struct stat status = {};
    if (::stat(out().c_str(), &status) != 0) return false;
    return ReadBytes("/proc/locks").find(":" + std::to_string(status.st_ino) + " ") != std::string::npos;
  }
  // Starts the program on work that it does not get done, and waits until it is at it.
  ToolProcess StartLongWork() const {
    const std::vector<std::string> words = With(GetParam().words, GetParam().long_work);
    const ToolProcess process(words.front(), folder(), {words.begin() + 1, words.end()});
    const bool has_folder = GetParam().name != kSimulate.name;
    while (process.IsRunning() && !(process.Catches(SIGTERM) && (!has_folder || IsLocked()))) {
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    return process;
  }
};

INSTANTIATE_TEST_SUITE_P(Programs, LongWriterTest, testing::Values(kSimulate, kIdentify, kLandscapeScan, kBenchmark),
                         [](const auto& writer) { return writer.param.name; });

TEST_P(WriterTest, ReplacesWhatIsThere) {
  ExpectRuns();
  for (const std::string& name : GetParam().results) WriteBytes(out() / name, "old");
  ExpectRuns();
}

TEST_P(WriterTest, FilesThatMayNotGrowStayAsTheyWere) {
  ExpectRuns();
  const Contents before = ReadOut();
  for (const int blocks : {1, 2}) {  // of 512 bytes
    // What a fit says on its way is longer, so it goes through a pipe.
    const std::string command = "bash -c 'set -o pipefail; (ulimit -f " + std::to_string(blocks) + "; exec " +
                                Command() + ") 2>&1 >/dev/null | cat >&2'";
    if (blocks == 1) ExpectFails(command, "out/", "cannot be written: File too large");
    if (blocks > 1 && Run(command).exit_code == 0) continue;
    ExpectUnchanged(before, command);
  }
}

TEST_P(WriterTest, AFullDiskIsAnError) {
  const std::optional<std::string> isolated = Namespace();
  if (!isolated) GTEST_SKIP() << "mounting is not permitted";
  // The first page takes the old file, or some of the new ones.
  const ToolResult result =
      Run(*isolated + " sh -c 'mount -t tmpfs -o size=4k none out && echo old > out/" + *GetParam().results.begin() +
          " && " + Command() + " >/dev/null; echo exit $?; ls -A out; cat out/*'");
  const std::string kept = GetParam().kept.empty() ? "" : GetParam().kept + "\n";
  EXPECT_EQ(result.out, "exit 1\n" + kept + *GetParam().results.begin() + "\nold\n") << result.err;
  EXPECT_NE(LastLine(result.err).find("cannot be written: No space left on device"), std::string::npos) << result.err;
}

TEST_P(WriterTest, AReadOnlyFileSystemIsAnError) {
  const std::optional<std::string> isolated = Namespace();
  if (!isolated) GTEST_SKIP() << "mounting is not permitted";
  const std::string mount = "mount --bind out out && mount -o remount,ro,bind out out && exec ";
  ExpectFails(*isolated + " sh -c '" + mount + Command() + "'", "out", "Read-only file system");
  ExpectUnchanged({}, "read-only");
}

TEST_P(WriterTest, AFolderThatMayNotBeWrittenToIsAnError) {
  std::string user;
  if (::geteuid() == 0) {
    user = "setpriv --reuid=65534 --regid=65534 --clear-groups ";
    fs::permissions(folder(), fs::perms(0755));
    if (Run(user + GetParam().words.front() + " --version").exit_code != 0) GTEST_SKIP() << "no other user can run it";
  }
  fs::permissions(out(), fs::perms(0555));
  ExpectFails(user + Command(), "out", "Permission denied");
  ExpectUnchanged({}, "no permission");
}

TEST_P(WriterTest, AFileInThePlaceOfTheFolderIsAnError) {
  fs::remove(out());
  WriteBytes(out(), "old");
  ExpectFails(Command(), "out", GetParam().name == kSimulate.name ? "Not a directory" : "is not a folder");
  EXPECT_EQ(ReadBytes(out()), "old");
}

TEST_P(WriterTest, ASecondRunIsRefusedUntilTheFirstEnds) {
  const bool is_file = GetParam().name == kSimulate.name;
  const fs::path place = is_file ? out() / ".motion.bin.part" : out();
  if (is_file) WriteBytes(place, "half of");
  const int first = ::open(place.c_str(), O_RDONLY);
  ASSERT_EQ(::flock(first, LOCK_EX), 0);
  const Contents before = ReadOut();
  ExpectFails(Command(), is_file ? "out/motion.bin" : "out", "another process is writing");
  ExpectUnchanged(before, "locked");
  ::close(first);
  ExpectRuns();
}

TEST_P(WriterTest, FullStandardOutputIsAnError) {
  if (!fs::is_character_file("/dev/full")) GTEST_SKIP() << "no /dev/full here";
  ExpectFails("sh -c 'exec " + Command() + " >/dev/full'", "standard output", "No space left on device");
  ExpectResults();
  ExpectFails("sh -c 'exec " + Command() + " --help >/dev/full'", "standard output", "cannot be written");
}

TEST_P(LongWriterTest, SignalsLeaveNothingHalfDone) {
  for (const int signal : {SIGTERM, SIGINT, SIGHUP}) {
    for (const auto& entry : fs::directory_iterator(out())) fs::remove_all(entry.path());
    const ToolProcess process = StartLongWork();
    process.Signal(signal);
    EXPECT_EQ(process.Wait(), 130) << signal;
    std::set<std::string> names;
    for (const auto& [name, content] : ReadOut()) names.insert(name);
    names.erase(GetParam().kept);
    // identify writes the best point so far, once there is one.
    if (!names.empty() && GetParam().name == kIdentify.name) {
      EXPECT_EQ(nlohmann::json::parse(ReadBytes(out() / "result.json"))["status"], "interrupted");
      names = {};
    }
    EXPECT_TRUE(names.empty()) << *names.begin();
  }
}

TEST_P(LongWriterTest, WhatWasKilledIsNotInTheWay) {
  const ToolProcess process = StartLongWork();
  process.Signal(SIGSTOP);
  if (GetParam().name != kSimulate.name) ExpectFails(Command(), "out", "another process is writing");
  process.Signal(SIGKILL);
  EXPECT_FALSE(process.Wait().has_value());
  if (!GetParam().kept.empty()) fs::remove(out() / GetParam().kept);
  ExpectRuns();
}

// The kills are spread over the time that a run takes; whatever has its name is whole.
TEST_P(WriterTest, KilledAtAnyMoment) {
  const auto start = std::chrono::steady_clock::now();
  ExpectRuns();
  const std::chrono::duration<double> duration = std::chrono::steady_clock::now() - start;
  const Contents expected = ReadOut();
  std::mt19937 random(1);
  for (int kill = 0; kill < 8; ++kill) {
    const std::vector<std::string>& words = GetParam().words;
    const ToolProcess process(words.front(), folder(), {words.begin() + 1, words.end()});
    std::this_thread::sleep_for(std::uniform_real_distribution<double>(0.0, 1.0)(random) * duration);
    process.Signal(SIGKILL);
    process.Wait();
    for (const std::string& name : GetParam().results) {
      const std::string content = ReadBytes(out() / name);
      // Those with times in them differ in some digits.
      if (fs::path(name).extension() == ".bin") {
        EXPECT_TRUE(content == expected.at(name)) << name;
      } else {
        EXPECT_EQ(content.back(), '\n') << name;
        EXPECT_EQ(std::count(content.begin(), content.end(), '\n'),
                  std::count(expected.at(name).begin(), expected.at(name).end(), '\n'))
            << name;
      }
    }
    if (!GetParam().kept.empty()) fs::remove(out() / GetParam().kept);
  }
  ExpectRuns();
}

TEST_F(HostileTest, AFitWhoseResultsCannotBeWrittenGoesOnFromItsEnd) {
  const std::string command = Line(kIdentify.words) + " --resume";
  fs::create_directory(out() / "result.json");
  ExpectFails(command, "out/result.json", "cannot be written: is a folder");
  EXPECT_EQ(ReadOut().size(), 2u) << "the folder, and the journal of the fit and of those that led it";
  EXPECT_GT(ReadOut()[".journal_1.bin"].size(), 1000u);
  fs::remove(out() / "result.json");
  EXPECT_EQ(Run(command).exit_code, 0);
  EXPECT_EQ(ReadOut().size(), kIdentify.results.size());
}

// What fits is there: the table, and the small files without those that are of another fit.
TEST_F(HostileTest, AFitWhoseReportDoesNotFitKeepsItsResult) {
  const std::optional<std::string> isolated = Namespace();
  if (!isolated) GTEST_SKIP() << "mounting is not permitted";
  const ToolResult result =
      Run(*isolated +
          " sh -c 'mount -t tmpfs -o size=256k none out && echo old > out/predicted.bin && "
          "echo old > out/predicted_2.bin && " +
          Line(kIdentify.words) + " --resume; echo exit $?; ls out; cat out/result.json; ls -A out | grep journal'");
  EXPECT_EQ(result.out.rfind("parameter ", 0), 0u) << result.out;
  EXPECT_NE(result.out.find("exit 1\nconvergence.csv\nfabric.json\nresult.json\n{"), std::string::npos) << result.out;
  EXPECT_NE(result.out.find("\n}\n.journal_1.bin\n"), std::string::npos) << "a fit that resumes goes on from its end";
  EXPECT_NE(LastLine(result.err).find("report.html: cannot be written: No space left on device; result.json is "),
            std::string::npos)
      << result.err;
}

TEST_F(HostileTest, MotionNoticesFullStandardOutput) {
  if (!fs::is_character_file("/dev/full")) GTEST_SKIP() << "no /dev/full here";
  for (const std::string command : {"info a.bin", "check a.bin", "--version"}) {
    ExpectFails("sh -c 'exec motion " + command + " >/dev/full'", "motion: standard output", "No space left");
  }
}

TEST_F(HostileTest, MissingFoldersAreMadeForFoldersAlone) {
  ExpectRefused("simulate --scene scene.json --output absent/motion.bin", 1,
                "absent/motion.bin: cannot be written: No");
  EXPECT_EQ(Run(Line(kScan) + " --output absent/result").exit_code, 0);
  EXPECT_TRUE(fs::exists(folder() / "absent" / "result" / "plan.json"));
}

}  // namespace
}  // namespace clothid::hostile_filesystem_test
