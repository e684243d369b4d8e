// `identify --resume` may be killed at any moment: run again, it ends in the bytes of the fit that nobody killed.
#include <gtest/gtest.h>
#include <signal.h>

#include <algorithm>
#include <chrono>
#include <map>
#include <random>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

#include "sim/base/error.h"
#include "tests/identify/lasting_result.h"
#include "tests/tools/tool_process.h"
#include "tests/tools/tool_test.h"

namespace clothid::resume_test {
namespace {

namespace fs = std::filesystem;
using Seconds = std::chrono::duration<double>;

constexpr int kKillsPerMethod = 6;

std::vector<std::string> Names(const std::map<std::string, std::string>& files) {
  std::vector<std::string> names;
  for (const auto& [name, content] : files) names.push_back(name);
  return names;
}

class ResumeTest : public ToolTest {
 protected:
  ResumeTest() {
    const std::string scene = WriteScene(nlohmann::ordered_json::parse(R"({
      "clothid_scene": 1, "time_step": 0.01, "duration": 0.3,
      "mesh": {"grid": {"nodes": [8, 8], "size": [0.3, 0.3]}}, "handles": [0, 1, 2, 3, 4, 5, 6, 7],
      "obstacles": [{"name": "ball", "type": "sphere", "center": [0.15, 0.2, -0.12], "radius": 0.1, "mu": 0.5}],
      "materials": {"density": 0.2, "k_stretch": 50, "k_bend": 2e-3, "drag": 0.1},
      "solver": {"step_tolerance": 1e-6}})"));
    const std::string simulate = "simulate --scene " + scene + " --set mu=0.2,k_stretch=120 --noise 0.001 --seed ";
    ExpectRuns(simulate + "1 --output a.bin");
    ExpectRuns(simulate + "2 --output b.bin");
  }

  void ExpectRuns(const std::string& command) const { ASSERT_EQ(Run(command).exit_code, 0) << command; }

  ToolProcess Start(std::vector<std::string> flags) const {
    flags.insert(flags.end(), {"--target", "a.bin,b.bin", "--threads", "2", "--output", "result"});
    return ToolProcess("identify", folder(), flags);
  }
  ToolProcess Resume(std::vector<std::string> flags) const {
    flags.push_back("--resume");
    return Start(flags);
  }

  fs::path result() const { return folder() / "result"; }
  std::uintmax_t JournalSize(int recording) const {
    std::error_code error;
    const std::uintmax_t size = fs::file_size(result() / (".journal_" + std::to_string(recording) + ".bin"), error);
    return error ? 0 : size;
  }
  // Lets a fit go on until both journals hold some evaluations, of at least one rollout each.
  void WaitForEvaluations(const ToolProcess& identify) const {
    const std::uintmax_t some = 4 * fs::file_size(folder() / "a.bin");
    while (identify.IsRunning() && std::min(JournalSize(1), JournalSize(2)) < some) {
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
  }
};

class KillTest : public ResumeTest, public testing::WithParamInterface<std::vector<std::string>> {
 protected:
  // Starts a fit and kills it at a random moment within a part of the seconds that a fit takes: of that many parts of
  // the same length, the one of that index; every second time, though, soon after it has a journal, which stages before
  // it may keep it waiting for. Whether the fit was still running.
  bool Kill(int part, int num_parts, std::mt19937* random) {
    const auto start = std::chrono::steady_clock::now();
    const ToolProcess identify = Resume(GetParam());
    const double share = std::uniform_real_distribution<double>(0.0, 1.0)(*random);
    if (part % 2 == 1) {
      while (identify.IsRunning() && JournalSize(1) == 0) std::this_thread::sleep_for(std::chrono::milliseconds(1));
      std::this_thread::sleep_for(0.1 * share * duration_);
    } else {
      std::this_thread::sleep_for((part + share) / num_parts * duration_);
    }
    identify.Signal(SIGKILL);
    const bool was_running = !identify.Wait().has_value();
    // How long a fit takes varies with what else the machine does.
    if (!was_running) duration_ = std::min<Seconds>(duration_, std::chrono::steady_clock::now() - start);
    return was_running;
  }

  Seconds duration_ = Seconds(0.0);
};

INSTANTIATE_TEST_SUITE_P(Methods, KillTest,
                         testing::Values(std::vector<std::string>{"--jacobian", "adjoint"},
                                         std::vector<std::string>{"--jacobian", "sensitivity", "--starts", "2",
                                                                  "--profile", "mu", "--discretization", "step"},
                                         std::vector<std::string>{"--jacobian", "numeric"}));

TEST_P(KillTest, EndsInTheSameBytes) {
  const auto start = std::chrono::steady_clock::now();
  const std::optional<int> exit_code = Start(GetParam()).Wait();
  ASSERT_TRUE(exit_code == kExitSuccess || exit_code == kExitNotIdentifiable) << *exit_code;
  duration_ = std::chrono::steady_clock::now() - start;
  const std::map<std::string, std::string> expected = ReadLastingResult(result());
  for (const char* name : {"convergence.csv", "predicted.bin", "predicted_2.bin", "report.html", "result.json"}) {
    ASSERT_EQ(expected.count(name), 1u) << name;
  }

  int num_running = 0, num_fitting = 0;
  for (int seed = 1; seed <= kKillsPerMethod; ++seed) {
    fs::remove_all(result());
    std::mt19937 random(static_cast<unsigned>(seed));
    num_running += Kill(seed - 1, kKillsPerMethod, &random);
    num_fitting += JournalSize(1) > 0;
    if (seed % 3 == 0) Kill(0, 1, &random);
    ASSERT_EQ(Resume(GetParam()).Wait(), exit_code) << seed;
    const std::map<std::string, std::string> files = ReadLastingResult(result());
    ASSERT_EQ(Names(files), Names(expected)) << seed;
    for (const auto& [name, content] : expected) EXPECT_TRUE(files.at(name) == content) << name << " of seed " << seed;
  }
  RecordProperty("killed_while_running", num_running);
  RecordProperty("killed_with_a_journal", num_fitting);
  EXPECT_GT(2 * num_running, kKillsPerMethod);
  EXPECT_GT(2 * num_fitting, kKillsPerMethod);
}

TEST_F(ResumeTest, AnInterruptedFitGoesOn) {
  const std::vector<std::string> flags = {"--jacobian", "numeric", "--horizon", "full"};
  ASSERT_EQ(Start(flags).Wait(), 0);
  const std::map<std::string, std::string> expected = ReadLastingResult(result());
  fs::remove_all(result());

  const ToolProcess interrupted = Resume(flags);
  WaitForEvaluations(interrupted);
  interrupted.Signal(SIGINT);
  EXPECT_EQ(interrupted.Wait(), 130);
  const nlohmann::json saved = nlohmann::json::parse(ReadBytes(result() / "result.json"));
  EXPECT_EQ(saved["status"], "interrupted");
  EXPECT_GT(JournalSize(1), 0u);

  EXPECT_EQ(Resume(flags).Wait(), 0);
  EXPECT_TRUE(ReadLastingResult(result()) == expected);
}

TEST_F(ResumeTest, RefusesTheJournalOfAnotherFit) {
  const ToolProcess killed = Resume({"--jacobian", "numeric", "--horizon", "full"});
  WaitForEvaluations(killed);
  killed.Signal(SIGKILL);
  EXPECT_FALSE(killed.Wait().has_value());
  const std::string journal = ReadBytes(result() / ".journal_1.bin");
  ExpectRefused("identify --target a.bin,b.bin --resume --output result", 1, "result/.journal_1.bin");
  ExpectRefused("identify --target b.bin,a.bin --jacobian numeric --horizon full --resume --output result", 1,
                ".journal_1.bin");
  ExpectRefused("identify --target a.bin,b.bin --jacobian numeric --horizon full --resume --output result --fit weight",
                1, "weight");
  EXPECT_EQ(ReadBytes(result() / ".journal_1.bin"), journal);
}

TEST_F(ResumeTest, AFitThatCannotStartLeavesNothing) {
  ExpectRefused("identify --target a.bin --resume --output result --fit weight", 1, "weight");
  const fs::path scene = folder() / "scene.json";
  std::string text = ReadBytes(scene);
  text.insert(text.rfind("\"step_tolerance\""), "\"max_newton_iterations\": 1, \"max_substep_halvings\": 0, ");
  WriteBytes(folder() / "hopeless.json", text);
  ExpectRefused("identify --target a.bin --scene hopeless.json --resume --output result", 3, "did not converge");
}

TEST_F(ResumeTest, AJournalThatCannotBeWrittenEndsTheFit) {
  // No file may grow beyond 20 blocks of 512 bytes: room for the header, not for a record.
  ExpectRefused("sh -c 'trap \"\" XFSZ; ulimit -f 20; exec identify --target a.bin --resume --output result'", 1,
                ".journal_1.bin: cannot be written");
}

}  // namespace
}  // namespace clothid::resume_test
