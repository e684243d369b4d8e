// `landscape` may be divided, killed and resumed at will: it ends in the bytes of the scan that nobody touched.
#include <gtest/gtest.h>
#include <signal.h>

#include <chrono>
#include <regex>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include "tests/tools/tool_process.h"
#include "tests/tools/tool_test.h"

namespace clothid::landscape_test {
namespace {

namespace fs = std::filesystem;

constexpr int kNumCells = 2 * 2 * 2 * 9 * 8;

const std::vector<std::string> kScan = {"--target",      "a.bin",
                                        "--x",           "mu=0:0.6:9",
                                        "--y",           "k_stretch=20:500:8:log",
                                        "--zoom_around", "mu=0.2,k_stretch=120",
                                        "--zoom",        "0.1",
                                        "--sweep",       "ball.center.x=0.1,0.15",
                                        "--contact",     "both",
                                        "--set",         "mu=0.2,k_stretch=120",
                                        "--gradients"};

class LandscapeTest : public ToolTest {
 protected:
  LandscapeTest() {
    nlohmann::ordered_json scene = SphereJson();
    scene["duration"] = 0.1;
    EXPECT_EQ(Run("simulate --scene " + WriteScene(scene) + " --set mu=0.2,k_stretch=120 --output a.bin").exit_code, 0);
  }

  static std::string Line(const std::vector<std::string>& words) {
    std::string line = "landscape";
    for (const std::string& word : words) line += " '" + word + "'";
    return line;
  }
  // The scan as `kScan` with further flags.
  static std::string Scan(const std::string& flags) { return Line(kScan) + " " + flags; }

  ToolResult ExpectScan(const std::string& command) const {
    const ToolResult result = Run(command);
    EXPECT_EQ(result.exit_code, 0) << command << "\n" << result.err;
    return result;
  }
  std::string File(const std::string& result, const char* name) const { return ReadBytes(folder() / result / name); }
  void ExpectSameFiles(const std::string& result, const std::string& expected) const {
    for (const char* name : {"landscape.csv", "plan.json", "summary.json"}) {
      EXPECT_TRUE(File(result, name) == File(expected, name)) << result << "/" << name;
    }
    std::set<std::string> names;
    for (const auto& entry : fs::directory_iterator(folder() / result)) names.insert(entry.path().filename());
    EXPECT_EQ(names, (std::set<std::string>{"landscape.csv", "plan.json", "summary.json", "timing.csv"}));
  }

  std::uintmax_t StoreSize(const std::string& result) const {
    std::error_code error;
    const std::uintmax_t size = fs::file_size(folder() / result / ".landscape_cells", error);
    return error ? 0 : size;
  }
  // Sends `signal` once some cells more are done; the exit code, nothing where the signal ended the process.
  std::optional<int> Stop(const std::string& result, std::vector<std::string> flags, int num_cells, int signal) const {
    constexpr std::uintmax_t kRecordSize = 200;
    const std::uintmax_t wanted = std::max<std::uintmax_t>(StoreSize(result), 100) + num_cells * kRecordSize;
    flags.insert(flags.begin(), kScan.begin(), kScan.end());
    flags.insert(flags.end(), {"--output", result});
    const ToolProcess process("landscape", folder(), flags);
    while (process.IsRunning() && StoreSize(result) < wanted) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    process.Signal(signal);
    return process.Wait();
  }
};

TEST_F(LandscapeTest, WritesEveryCellAndSaysWhatItFound) {
  const ToolResult result = ExpectScan(Scan("--output whole"));
  EXPECT_EQ(result.out.find("whole: " + std::to_string(kNumCells) + " cells, 0 failed\n"), 0u) << result.out;
  EXPECT_NE(result.out.find("\nball.center.x=0.15  velocity   0.1  "), std::string::npos) << result.out;
  EXPECT_TRUE(std::regex_search(result.out, std::regex("cells in .* s on 1 thread: .* cells/s"))) << result.out;
  EXPECT_NE(result.err.find("cells 576 of 576"), std::string::npos) << result.err;
  const std::string csv = File("whole", "landscape.csv");
  EXPECT_EQ(std::count(csv.begin(), csv.end(), '\n'), 1 + kNumCells);
  const nlohmann::json plan = nlohmann::json::parse(File("whole", "plan.json"));
  EXPECT_EQ(plan["schema"], "clothid.landscape/1");
  EXPECT_EQ(plan["settings"].size(), 4u);
  EXPECT_TRUE(plan["shard"].is_null());
}

TEST_F(LandscapeTest, ShardsThatWereKilledEndInTheSameBytes) {
  ExpectScan(Scan("--output whole"));
  for (const int count : {1, 3, 7}) {
    std::string folders;
    int num_killed = 0;
    for (int index = 0; index < count; ++index) {
      const std::string shard = std::to_string(index) + "/" + std::to_string(count);
      const std::string result = "part" + std::to_string(count) + "_" + std::to_string(index);
      const std::vector<std::string> flags = {"--shard", shard, "--resume", "--threads", index % 2 == 0 ? "2" : "1"};
      for (int kill = 0; kill < 2; ++kill) {
        num_killed += !Stop(result, flags, kNumCells / count / 4, SIGKILL).has_value();
      }
      const ToolResult rest = ExpectScan(Scan("--resume --shard " + shard + " --output " + result));
      EXPECT_NE(rest.out.find("cells were done before"), std::string::npos) << rest.out;
      folders = result + " " + folders;
    }
    EXPECT_GT(num_killed, count);
    ExpectScan("landscape merge " + folders + "--output merged" + std::to_string(count));
    ExpectSameFiles("merged" + std::to_string(count), "whole");
  }
}

TEST_F(LandscapeTest, PlotsWhatItScanned) {
  ExpectScan(Scan("--output whole"));
  const nlohmann::json summary = nlohmann::json::parse(File("whole", "summary.json"));
  ASSERT_EQ(summary["settings"].size(), 4u);
  const nlohmann::json& window = summary["settings"][0]["windows"][0];
  EXPECT_GT(window["per_rollout"]["contact_changes"], 0.0);
  EXPECT_GT(window["contacts_per_step"], 0.0);
  EXPECT_GT(window["roughness"]["off_quadratic"], 0.0);
  EXPECT_GT(window["roughness"]["gradient_gap"], 0.0);

  const ToolResult plot = Run("landscape plot whole");
  EXPECT_EQ(plot.exit_code, 0) << plot.err;
  EXPECT_EQ(plot.out.find("whole/landscape.html\n"), 0u) << plot.out;
  EXPECT_NE(File("whole", "landscape.html").find("ball.center.x=0.15"), std::string::npos);
  const bool has_png = fs::exists(folder() / "whole" / "landscape.png");
  EXPECT_EQ(plot.out.find("whole/landscape.png\n") != std::string::npos, has_png) << plot.out;
  EXPECT_EQ(plot.err.find("landscape: landscape.png is left out: ") == 0, !has_png) << plot.err;
}

TEST_F(LandscapeTest, PlotsNothingElse) {
  ExpectScan(Scan("--shard 0/7 --output part"));
  EXPECT_FALSE(fs::exists(folder() / "part" / "summary.json"));
  ExpectRefused("landscape plot part", 2, "part");
  ExpectRefused("landscape plot nowhere", 1, "nowhere");
  ExpectRefused("landscape plot", 1, "plot: expected one folder");
  ExpectRefused("landscape plot whole --gradients", 1, "--gradients: is a flag of landscape, not of plot");
  ExpectRefused("landscape plot whole --output elsewhere", 1,
                "--output: is a flag of landscape and merge, not of plot");
  ExpectRefused("landscape merge whole --output merged --threads 2", 1,
                "--threads: is a flag of landscape, not of merge");
  ExpectRefused("landscape plot part part", 1, "plot: expected one folder");
}

TEST_F(LandscapeTest, ResumingDoesNotReplaceAFinishedScanByAnother) {
  ExpectScan(Scan("--shard 0/7 --output part"));
  const std::string before = File("part", "landscape.csv");
  const ToolResult result = Run(Scan("--shard 1/7 --resume --output part"));
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_NE(result.err.find("part: holds the landscape of another scan or shard"), std::string::npos) << result.err;
  EXPECT_EQ(File("part", "landscape.csv"), before);
}

TEST_F(LandscapeTest, AnInterruptedScanGoesOn) {
  ExpectScan(Scan("--output whole"));
  for (const int signal : {SIGINT, SIGTERM}) {
    EXPECT_EQ(Stop("stopped", {"--resume"}, 20, signal), 130);
    EXPECT_FALSE(fs::exists(folder() / "stopped" / "landscape.csv"));
  }
  ExpectRefused(Scan("--output stopped"), 1, "--resume");
  ExpectRefused("landscape merge stopped --output merged", 2, "--resume");
  ExpectScan(Scan("--resume --threads 2 --output stopped"));
  ExpectSameFiles("stopped", "whole");
  const ToolResult again = ExpectScan(Scan("--resume --output stopped"));
  EXPECT_NE(again.out.find("576 cells were done before"), std::string::npos) << "what is finished stays";
  ExpectSameFiles("stopped", "whole");
}

TEST_F(LandscapeTest, RefusesAStoreThatDoesNotFit) {
  ASSERT_FALSE(Stop("killed", {}, 20, SIGKILL).has_value());
  const fs::path store = folder() / "killed" / ".landscape_cells";
  ExpectRefused(Scan("--resume --shard 0/3 --output killed"), 1, ".landscape_cells: is of a scan with another");
  ExpectRefused(Scan("--resume --sweep touch=1e-3 --output killed"), 1, "is of a scan with another");
  std::vector<std::string> other = kScan;
  *std::next(std::find(other.begin(), other.end(), "--set")) = "mu=0.21,k_stretch=120";
  ExpectRefused(Line(other) + " --resume --output killed", 1, "is of a scan with another");
  const std::string bytes = ReadBytes(store);
  std::string damaged = bytes;
  damaged[bytes.size() / 2] = static_cast<char>(damaged[bytes.size() / 2] ^ 1);
  WriteBytes(store, damaged);
  ExpectRefused(Scan("--resume --output killed"), 2, "is damaged");
  WriteBytes(store, bytes.substr(0, bytes.size() - 5));
  ExpectScan(Scan("--resume --output killed"));
  ExpectScan(Scan("--output whole"));
  ExpectSameFiles("killed", "whole");
}

TEST_F(LandscapeTest, RefusesShardsThatDoNotFit) {
  ExpectScan(Scan("--shard 0/2 --output a"));
  ExpectScan(Scan("--shard 1/2 --output b"));
  ExpectScan(Scan("--shard 1/2 --contact gap --output c"));
  ExpectRefused("landscape merge a --output merged", 1, "shard 1 of 2 is missing");
  ExpectRefused("landscape merge a b a --output merged", 1, "shard 0 of 2");
  ExpectRefused("landscape merge a c --output merged", 1, "c: is of another scan than a");
  ExpectRefused("landscape merge a b --output b", 1, "--output");
  ExpectRefused("landscape merge --output merged", 1, "folders");
}

TEST_F(LandscapeTest, AFailedRolloutIsNoNumber) {
  nlohmann::ordered_json scene = SphereJson();
  scene["solver"] = {{"max_newton_iterations", 1}, {"max_substep_halvings", 0}};
  WriteScene(scene, "hopeless.json");
  const ToolResult result =
      ExpectScan("landscape --target a.bin --scene hopeless.json --x mu=0:0.6:2 --y k_stretch=20:500:2");
  EXPECT_NE(result.out.find("4 cells, 4 failed; the first, cell 0: step 1 did not converge"), std::string::npos)
      << result.out;
  EXPECT_NE(result.out.find("\nscene as it is, gap, zoom 1: every cell failed\n"), std::string::npos) << result.out;
  EXPECT_NE(File("landscape_result", "landscape.csv").find("\n0,20,,gap,,0,"), std::string::npos);
  ExpectRefused(
      "landscape --target a.bin --scene hopeless.json --x mu=0:0.6:2 --y k_stretch=20:500:2 --output b "
      "--set mu=0.2,k_stretch=100",
      2, "true parameters");
}

TEST_F(LandscapeTest, NamesTheWrongFlag) {
  const auto expect_refused = [&](const std::string& flags, const std::string& culprit) {
    ExpectRefused("landscape --target a.bin --x mu=0:0.6:5 --y k_stretch=20:500:5:log " + flags, 1, culprit);
  };
  expect_refused("--x mu=0.6:0:5", "--x: 'mu=0.6:0:5': expected a lower end below the upper one");
  expect_refused("--y k_stretch=20:500:0", "--y: 'k_stretch=20:500:0': expected at least 2 cells");
  expect_refused("--y weight=20:500:5", "--y: unknown parameter 'weight'");
  expect_refused("--y mu=0:1:5", "--y: 'mu' is on --x already");
  expect_refused("--zoom 0.1", "--zoom");
  expect_refused("--sweep bal.center.x=0", "--sweep: 'bal.center.x=0'");
  expect_refused("--sweep 'ball.center.x=0;contact=1'", "--sweep");
  expect_refused("--sweep ball.center.x=0 --sweep ball.center.x=1", "'ball.center.x': is there twice");
  expect_refused("--sweep ball.mu=0.1", "--sweep: 'ball.mu=0.1': changes 'mu', which is on --x");
  expect_refused("--sweep 'touch=1e-3;materials.k_stretch=100,70'",
                 "--sweep: 'touch=0.001;materials.k_stretch=70': changes 'k_stretch', which is on --y");
  expect_refused("--sweep duration=1e9", "--sweep: 'duration': has no effect");
  expect_refused("--sweep wind.mean.x=1",
                 "key 'wind.mean': expected an array of three numbers; the scene has to have the array");
  expect_refused("--contact all", "--contact");
  expect_refused("--set mu=0.3", "--set");
  expect_refused("--shard 3/3", "--shard");
  expect_refused("--threads 0", "--threads");
  expect_refused("--gradient", "gradient");
  expect_refused("paint", "'paint': unknown command");
  expect_refused("--target b.bin", "b.bin");
  expect_refused("--scene b.json", "b.json");
  expect_refused("--output a.bin/below", "--output");
  ExpectRefused("landscape --x mu=0:0.6:5 --y k_stretch=20:500:5", 1, "--target");
  WriteBytes(folder() / "bad.bin", "no recording");
  ExpectRefused("landscape --target bad.bin --x mu=0:0.6:5 --y k_stretch=20:500:5", 2, "bad.bin");
}

TEST_F(LandscapeTest, RefusesToReplaceWhatItReads) {
  fs::create_directory(folder() / "b");
  fs::copy_file(folder() / "a.bin", folder() / "b/plan.json");
  ExpectRefused("landscape --target b/plan.json --x mu=0:0.6:5 --y k_stretch=20:500:5 --output ./b", 1,
                "--target: b/plan.json: the results in --output ./b would replace it");
}

TEST_F(LandscapeTest, AShardLeavesNoSummaryOfAnotherScan) {
  const std::string scan = "landscape --target a.bin --x mu=0:0.6:2 --y k_stretch=20:500:2 --output part";
  ExpectScan(scan);
  EXPECT_TRUE(fs::exists(folder() / "part/summary.json"));
  ExpectScan(scan + " --shard 0/2");
  EXPECT_FALSE(fs::exists(folder() / "part/summary.json"));
  EXPECT_TRUE(fs::exists(folder() / "part/plan.json"));
}

TEST_F(LandscapeTest, AStoreThatCannotBeWrittenEndsTheScan) {
  // No file may grow beyond 10 blocks of 512 bytes: room for some cells, not for all.
  const ToolResult result =
      Run("sh -c 'trap \"\" XFSZ; ulimit -f 10; exec landscape --target a.bin --x mu=0:0.6:9 "
          "--y k_stretch=20:500:9 --threads 2 --output full'");
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_NE(result.err.find(".landscape_cells: cannot be written"), std::string::npos) << result.err;
  ExpectScan("landscape --target a.bin --x mu=0:0.6:9 --y k_stretch=20:500:9 --output whole");
  const ToolResult rest =
      ExpectScan("landscape --target a.bin --x mu=0:0.6:9 --y k_stretch=20:500:9 --output full --resume");
  EXPECT_NE(rest.out.find("cells were done before"), std::string::npos) << rest.out;
  ExpectSameFiles("full", "whole");
}

}  // namespace
}  // namespace clothid::landscape_test
